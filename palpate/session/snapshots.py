"""Takes snapshots of a running session for its record: soft objects, the endoscope arm, rigid bodies, sensors."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from palpate.base.arrays import Array, so3
from palpate.base.errors import CloudError
from palpate.record.extra import WORLD, transform_message
from palpate.record.snapshots import (
    BODY,
    CAMERA,
    CLOUD_QUANTUM,
    FRAMES,
    RATE,
    SENSOR,
    Snapshot,
    cloud_message,
    cloud_topic,
    joints_message,
    shape_message,
    topic_of,
)
from palpate.scene.rig import Rig
from palpate.scene.soft import is_soft, rest_shape

if TYPE_CHECKING:
    from palpate.sensing.source import CloudFrame

_LATEST = 2.0**31 - 1.0  # a stamp has 32 bits [s]
ECM_JOINTS = ("yaw", "pitch", "insertion", "roll")


def soft_objects(rig: Rig) -> dict[int, str]:
    """Names of the soft objects of a scene by their number."""
    objects = zip(rig.scene.objects, rig.snapshot.objects, strict=True)
    return {k: section.name for k, (section, felt) in enumerate(objects) if is_soft(felt)}


class Snapshots:
    """Collects snapshots at `RATE`, until the record takes them.

    Args:
        rig: the scene.
        shape: deformed vertices (n, 3) of a soft object by its number, in O [m].
        joints: joints (4,) of the endoscope arm [rad, m]; None if this session has no camera.
        bodies: position [m] and quaternion w x y z (7,) of the rigid bodies that move, by name.
    """

    def __init__(
        self,
        rig: Rig,
        shape: Callable[[int], Array],
        joints: Callable[[], Array | None],
        bodies: Callable[[], Mapping[str, Array]],
    ) -> None:
        self._shape, self._joints, self._bodies = shape, joints, bodies
        self._topics = [topic_of(section.name) for section in rig.scene.objects]
        shapes = [rest_shape(felt) for felt in rig.snapshot.objects]
        self._rest = {k: np.array(shape[0]) for k, shape in enumerate(shapes) if shape is not None}
        anything = self._rest or rig.ecm or rig.scene.bodies
        self.needed = bool(anything)  #: False: there is nothing to record
        self._due = -np.inf
        self._kept: list[Snapshot] = []

    def take(self, t: float, shapes: bool = True) -> None:
        """Take a snapshot at the time of the newest tick [s], unless the last one is younger than a period.

        shapes: False leaves out soft objects and rigid bodies, which another record of the run holds.
        """
        if t < self._due and t > self._due - 2.0 / RATE:  # a clock that went back begins anew
            return
        self._due = t + 1.0 / RATE - 1e-9
        for k, rest in self._rest.items() if shapes else ():
            self._kept.append(Snapshot(t, self._topics[k], shape_message(self._shape(k) - rest)))
        places = self._bodies() if shapes else {}
        if places:
            poses = {(WORLD, BODY + name): so3.pose(place[:3], place[3:]) for name, place in places.items()}
            self._kept.append(Snapshot(t, FRAMES, transform_message(poses, round(1e9 * t))))
        q = self._joints()
        if q is not None:
            self._kept.append(Snapshot(t, CAMERA, joints_message(t, ECM_JOINTS, q)))

    def take_cloud(self, name: str, frame: CloudFrame, now: float) -> None:
        """Take a frame of an object's sensor, with the pose of the camera; now: the session's time [s].

        What is no frame is left out: the stream counts and tells it.
        """
        from palpate.sensing.gate import points_of
        from palpate.sensing.messages import fields_of

        try:
            points = points_of(frame).astype(np.float64)
        except CloudError:
            return
        if not abs(frame.t) < _LATEST:
            return
        shape, child = np.shape(frame.points), SENSOR + name
        size = (shape[0], shape[1]) if len(shape) == 3 else (1, shape[0])
        colors = frame.colors if frame.colors is not None and np.size(frame.colors) == points.size else None
        fields, step, data = fields_of(np.rint(points / CLOUD_QUANTUM) * CLOUD_QUANTUM, colors)
        X_WC = np.asarray(frame.X_WC, dtype=np.float64)
        self._kept.append(Snapshot(now, FRAMES, transform_message({(WORLD, child): X_WC}, round(1e9 * frame.t))))
        self._kept.append(Snapshot(now, cloud_topic(name), cloud_message(frame.t, child, size, fields, step, data)))

    def idle_periods(self, t: float, period: float) -> float:
        """Number of periods from a time on [s] at whose begin no snapshot is due."""
        return max(0.0, math.ceil((self._due - t) / period - 1e-6)) if math.isfinite(self._due - t) else 0.0

    def collect(self) -> list[Snapshot]:
        """The snapshots since the last call."""
        kept, self._kept = self._kept, []
        return kept
