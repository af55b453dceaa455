"""Draws the tool's spheres, the proxy, and a red point at each contact."""

from __future__ import annotations

import numpy as np
import viser

from palpate.base.arrays import Array
from palpate.base.arrays.so3 import pose
from palpate.record.ticks import SIGNALS, Ticks
from palpate.viewer.stage import Stage

Presses = dict[int, list[tuple[Array, float, Array, Array | None]]]
"""Arguments of `OrganDrawing.press` by the number of the object."""
SMALL = 0.004
"""Largest radius of a tool sphere that is drawn opaque [m]."""
BLUE, YELLOW, RED = (90, 170, 255), (255, 214, 70), (225, 20, 20)
GREY = (150, 150, 150)


class ToolDrawing:
    """Spheres of the tool, the proxy of the strongest contact, and the points of contact."""

    def __init__(self, scene: viser.SceneApi, stage: Stage) -> None:
        """Draws everything at the origin."""
        self._stage, r = stage, stage.radius
        # A small opaque sphere stays visible inside a transparent organ; a large one would hide the tool.
        clear = None if r <= SMALL else 0.5
        self._spr = scene.add_icosphere("/spr", r, BLUE, opacity=clear, cast_shadow=False)
        self._proxy = scene.add_icosphere("/proxy", r, YELLOW, opacity=clear, cast_shadow=False, visible=False)
        # The remote tool where it was; it will be where the local one is (the signal remote_delay says when).
        self._ghost = scene.add_icosphere("/remote", r, GREY, opacity=0.6, cast_shadow=False, visible=False)
        self._spheres = [
            scene.add_icosphere(f"/tool/{k}", s.core.radius, BLUE, subdivisions=2, wireframe=True, cast_shadow=False)
            for k, s in enumerate(stage.spheres)
        ]
        point = max(0.3 * r, 0.0006)
        self._points = [
            scene.add_icosphere(f"/contacts/{k}", point, RED, subdivisions=1, cast_shadow=False, visible=False)
            for k in range(SIGNALS["touch_sphere"].size if stage.spheres else len(stage.objects))
        ]

    @property
    def p_WT(self) -> Array:
        """Drawn position of the tool tip (3,) [m]."""
        return np.array(self._spr.position)

    def presses(self, tick: Ticks, at_tip: Array | None = None) -> Presses:
        """Arguments of `OrganDrawing.press` by the number of the object, for the tool as drawn by `show`.

        at_tip: centre (3,) in W of the sphere that dents the surface instead of the drawn one at the tip [m].
        """
        found: Presses = {}
        points = np.asarray(tick["p_WC"]).reshape(-1, 3)
        for k in range(min(int(tick["contacts"]), len(points))):
            sphere, obj, point = int(tick["touch_sphere"][k]), int(tick["touch_object"][k]), points[k]
            if not np.isfinite(point).all() or not 0 <= sphere <= len(self._spheres):
                continue
            node = self._spr if sphere == 0 else self._spheres[sphere - 1]
            normal = np.array(tick["normal"]) if k == 0 and np.any(tick["normal"]) else None
            centre = at_tip if sphere == 0 and at_tip is not None else np.array(node.position)
            found.setdefault(obj, []).append((centre, float(node.radius), point, normal))
        return found

    def show(self, tick: Ticks, links: dict[str, Array], shift: Array) -> None:
        """Moves the tool to a tick; links: poses of the follower's links in B; shift: of the drawn tool (3,) [m]."""
        touches = int(tick["contacts"])
        known = float(tick["remote_received"]) > 0.0
        if known:
            self._ghost.position = tick["p_WR"] + shift
        if self._ghost.visible != known:
            self._ghost.visible = known
        self._spr.position = tick["p_WT"] + shift
        self._proxy.visible = touches > 0
        if touches:
            self._proxy.position = tick["p_WP"]
        if self._spheres:
            X_WT, X_WB = pose(tick["p_WT"], tick["quat_WT"]), self._stage.follower.X_WA
            for sphere, node in zip(self._stage.spheres, self._spheres, strict=True):
                node.position = sphere.centre(X_WT, X_WB, links, float(tick["jaw"])) + shift
        for k, point in enumerate(self._points):
            seen = k < touches
            if seen:
                point.position = tick["p_WC"][3 * k : 3 * k + 3]
            if point.visible != seen:
                point.visible = seen
