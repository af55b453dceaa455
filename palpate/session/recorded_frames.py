"""Frames, models and meshes of a scene that a record holds for 3-D viewers (`palpate.record.extra`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays import Array, so3
from palpate.record.extra import (
    MARKERS,
    TEXT,
    TF,
    WORLD,
    Marker,
    marker_message,
    text_message,
    transform_message,
)
from palpate.record.snapshots import BODY, CAMERA, JOINTS, POINTS, SHAPE, cloud_topic, topic_of
from palpate.record.ticks import Ticks
from palpate.scene.live_targets import object_poses
from palpate.scene.rig import Rig
from palpate.session.snapshots import soft_objects

if TYPE_CHECKING:
    from palpate.world.bodies.shapes import Solid

MOST_TRIANGLES = 8_000
"""Limit above which an object is stored with a coarser mesh."""
_TISSUE, _TOOL = (0.62, 0.25, 0.2, 0.8), (0.35, 0.67, 1.0, 1.0)
_KINDS = {"box": 1, "sphere": 2, "cylinder": 3}


class RecordedFrames:
    """The frames of a run: palpate_world > ARM_base > ARM/LINK, follower_tool, palpate_object_NAME, palpate_body_NAME.

    ARM is leader or follower; the names are those that Palpate's ROS 2 nodes publish.

    Args:
        rig: the built scene. It gets arms of its own, because an arm cannot be shared between threads.
    """

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._arms = {side: rig.scene.arm(side) for side in ("leader", "follower")}
        self._models = {f"/{side}/robot_description": arm.urdf for side, arm in self._arms.items() if arm.urdf}
        self.topics = {"/tf_static": TF, "/scene/arms": MARKERS, "/scene/objects": MARKERS}
        self.topics |= dict.fromkeys(self._models, TEXT)
        self.topics |= {topic_of(name): SHAPE for name in soft_objects(rig).values()}
        if rig.scene.record.sensors:
            seen = [obj.name for obj in rig.scene.objects if obj.cloud is not None and obj.cloud.sensor is not None]
            self.topics |= {cloud_topic(name): POINTS for name in seen}
        if rig.ecm is not None:
            self.topics[CAMERA] = JOINTS
        self._solids = _solids(rig)
        if self._solids:
            self.topics["/scene/bodies"] = MARKERS

    def first(self) -> list[tuple[str, bytes]]:
        """As `Extra.first`."""
        arms = self._rig.arms
        bases = {(WORLD, "leader_base"): arms.X_WL, (WORLD, "follower_base"): arms.X_WB}
        bases |= {(WORLD, BODY + solid.name): solid.X_WO for solid in self._solids if not solid.moves}
        bodies = self._bodies()
        drawn = [marker for side, arm in self._arms.items() for marker in _arm_markers(side, arm)]
        tip = Marker("follower_tool", "tool sphere", 2, _TOOL, scale=(2.0 * self._rig.scene.contact.radius,) * 3)
        return [
            ("/tf_static", transform_message(bases)),
            ("/scene/arms", marker_message([*drawn, tip])),
            ("/scene/objects", marker_message(self._objects())),
            *([("/scene/bodies", marker_message(bodies))] if bodies else []),
            *((topic, text_message(urdf)) for topic, urdf in self._models.items()),
        ]

    def transforms(self, ticks: Ticks) -> dict[tuple[str, str], Array]:
        """As `Extra.transforms`."""
        found: dict[tuple[str, str], Array] = {}
        for (side, arm), joints, pinch in zip(self._arms.items(), ("q", "q_follower"), ("gripper", "jaw"), strict=True):
            q = np.nan_to_num(ticks[joints][:, : arm.n])
            links = arm.link_poses(q, np.nan_to_num(ticks[pinch]))
            found |= {(f"{side}_base", f"{side}/{link}"): X for link, X in links.items()}
        found[WORLD, "follower_tool"] = so3.pose(ticks["p_WT"], ticks["quat_WT"])
        objects = [object_poses(self._rig, tick) for tick in ticks]
        for name in objects[0]:
            found[WORLD, f"palpate_object_{name}"] = np.array([poses[name] for poses in objects])
        return found

    def _bodies(self) -> list[Marker]:
        if not self._solids:
            return []
        from palpate.session.recorded_bodies import markers

        return [marker for solid in self._solids for marker in markers(solid)]

    def _objects(self) -> list[Marker]:
        found = []
        for obj, placed in zip(self._rig.scene.objects, self._rig.surfaces, strict=True):
            vertices, triangles = placed.drawable(MOST_TRIANGLES)
            points = vertices[triangles.reshape(-1)]
            found.append(Marker(f"palpate_object_{obj.name}", obj.name, 11, _TISSUE, points=points))
        return found


def _solids(rig: Rig) -> list[Solid]:
    """The rigid bodies of a scene."""
    if not rig.scene.bodies:
        return []
    from palpate.scene import held

    return held.solids(rig.scene)


def _arm_markers(side: str, arm: Arm) -> list[Marker]:
    """The primitives of an arm's links."""
    found = []
    for visual in arm.visuals:
        size = visual.size
        lengths = {"box": size, "sphere": (2.0 * size[0],) * 3, "cylinder": (2.0 * size[0], 2.0 * size[0], size[-1])}
        x, y, z = lengths[visual.shape]
        frame, kind = f"{side}/{visual.link}", _KINDS[visual.shape]
        found.append(Marker(frame, side, kind, visual.colour, visual.X_link_visual, (x, y, z)))
    return found
