"""Markers for RViz: objects, tool, contacts and forces, in the colours and lengths of Palpate's viewer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.so3 import pose
from palpate.record.ticks import Ticks
from palpate.ros.around.convert import WORLD, is_heard, latched, point, vector

if TYPE_CHECKING:
    from palpate.session import Session

FORCE_SCALE = 0.06
"""Length of a force arrow [m/N]."""
DEFLECTION_SCALE = 10.0
"""Length of the deflection arrow over the deflection [-]."""
MOST_TRIANGLES = 20_000
"""Limit above which an object is drawn with a coarser mesh."""
_RED, _GREEN, _BLUE = (0.78, 0.0, 0.0, 1.0), (0.0, 0.51, 0.12, 1.0), (0.12, 0.44, 0.85, 0.6)
_YELLOW, _TISSUE = (0.9, 0.75, 0.1, 0.6), (0.62, 0.25, 0.2, 0.8)
_SHORTEST = 1e-4  # shorter arrows are deleted [m]


class Markers:
    """Publishes ~/markers, and ~/objects (latched), in the frame palpate_world."""

    def __init__(self, node: Any, session: Session) -> None:
        from visualization_msgs.msg import MarkerArray

        self._node, self._session = node, session
        self._markers = node.create_publisher(MarkerArray, "~/markers", 10)
        self._objects = node.create_publisher(MarkerArray, "~/objects", latched())
        self._objects_are_old = True

    def show(self, tick: Ticks) -> None:
        """Draw the newest tick, and objects that are new, for those who listen."""
        if self._objects_are_old and is_heard(self._objects):
            self._objects_are_old = False
            self._publish_objects()
        if not is_heard(self._markers):
            return
        from visualization_msgs.msg import Marker, MarkerArray

        X_WL = self._session.rig.arms.X_WL
        p_WH = (X_WL @ pose(tick["p_LH"], tick["quat_LH"]))[:3, 3]
        radius, R_WL = self._session.rig.scene.contact.radius, X_WL[:3, :3]
        n = int(np.nan_to_num(tick["contacts"]))
        p_WS = tick["p_WP"] - tick["delta_x"] if n else tick["p_WT"]
        drawn = [
            self._arrow("force_body", p_WH, FORCE_SCALE * (R_WL @ tick["F_H_H"]), _RED, 0.006),
            self._arrow("force_spatial", p_WH, FORCE_SCALE * (R_WL @ tick["F_H_L"]), _GREEN, 0.006),
            self._arrow("deflection", p_WS, DEFLECTION_SCALE * np.array(tick["delta_x"]), _RED, 0.0032),
            self._ball("tool", tick["p_WT"], radius, _BLUE),
            self._ball("proxy", tick["p_WP"], radius, _YELLOW),
        ]
        contacts = self._marker("contacts", Marker.SPHERE_LIST, _RED)
        contacts.scale = vector(np.full(3, 0.6 * radius + 0.001))
        touched = np.asarray(tick["p_WC"]).reshape(-1, 3)[:n]
        contacts.points = [point(p) for p in touched if np.isfinite(p).all()]
        contacts.action = Marker.ADD if contacts.points else Marker.DELETE
        self._markers.publish(MarkerArray(markers=[*drawn, contacts]))

    def draw_objects(self) -> None:
        """Draw the scene's objects again, as soon as somebody listens."""
        self._objects_are_old = True

    def _publish_objects(self) -> None:
        """Draw the scene's objects; each marker follows the frame of its object."""
        from visualization_msgs.msg import Marker, MarkerArray

        drawn = [Marker(action=Marker.DELETEALL)]
        for placed, obj in zip(self._session.rig.surfaces, self._session.rig.snapshot.objects, strict=True):
            vertices, triangles = placed.drawable(MOST_TRIANGLES)
            mesh = self._marker(f"object_{obj.name}", Marker.TRIANGLE_LIST, _TISSUE)
            mesh.header.frame_id, mesh.frame_locked = f"palpate_object_{obj.name}", True
            mesh.scale = vector(np.ones(3))
            mesh.points = [point(vertices[k]) for k in triangles.reshape(-1)]
            drawn.append(mesh)
        self._objects.publish(MarkerArray(markers=drawn))

    def _marker(self, name: str, kind: int, colour: tuple[float, ...]) -> Any:
        from std_msgs.msg import ColorRGBA
        from visualization_msgs.msg import Marker

        marker = Marker(ns=name, type=kind, action=Marker.ADD)
        marker.header.frame_id = WORLD
        marker.pose.orientation.w = 1.0
        marker.color = ColorRGBA(r=colour[0], g=colour[1], b=colour[2], a=colour[3])
        return marker

    def _arrow(self, name: str, start: Array, along: Array, colour: tuple[float, ...], width: float) -> Any:
        from visualization_msgs.msg import Marker

        arrow = self._marker(name, Marker.ARROW, colour)
        arrow.scale = vector(np.array([width, 2.4 * width, 0.0]))
        seen = np.isfinite([*start, *along]).all() and float(np.linalg.norm(along)) > _SHORTEST
        arrow.action = Marker.ADD if seen else Marker.DELETE
        arrow.points = [point(start), point(start + along)] if seen else []
        return arrow

    def _ball(self, name: str, p: Array, radius: float, colour: tuple[float, ...]) -> Any:
        from visualization_msgs.msg import Marker

        ball = self._marker(name, Marker.SPHERE, colour)
        ball.scale, seen = vector(np.full(3, 2.0 * radius)), bool(np.isfinite(p).all())
        ball.action = Marker.ADD if seen else Marker.DELETE
        if seen:
            ball.pose.position = point(p)
        return ball
