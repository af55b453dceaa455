"""The targets of all live objects of a loop, of which trackers and sensors set a part each."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.record import live
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig

PERIOD = 0.01
"""Period at which trackers are read, and the frames that follow them are moved [s]."""


class _Loop(Protocol):
    def set_live(self, targets: _core.LiveTargets, /) -> None:
        """Set the poses that live objects shall reach."""
        ...


@dataclass(frozen=True)
class Target:
    """The pose that a live object shall reach."""

    t: float  #: time at which it is valid [s]
    X_WO: Array  #: pose (4, 4) [m]
    V_WO: Array = field(default_factory=lambda: np.zeros(6))  #: velocity of O and angular velocity (6,) [m/s, rad/s]
    lost: bool = False  #: True: the pose is no longer trusted


@dataclass(frozen=True)
class FrameState:
    """The state of a tracked frame, for the record."""

    X_WF: Array  #: last good pose (4, 4) [m]
    t_seen: float  #: its time; -inf: none was seen [s]
    lost: bool  #: True if it is too old


class SharedTargets:
    """Targets of the live objects of a rig. Each source sets its own objects; the loop is given all of them at once.

    Args:
        rig: the rig, whose live objects start where its snapshot places them.
        loop: the loop that renders them.
    """

    def __init__(self, rig: Rig, loop: _Loop) -> None:
        self._loop, self._lock = loop, threading.Lock()
        self._targets = {obj.name: Target(0.0, obj.X_WO) for obj in rig.snapshot.objects if obj.is_live}
        self._frames: Sequence[FrameState] = ()

    def slot(self, name: str) -> int:
        """Number of an object among the live ones, which is that of its pose in a tick."""
        return list(self._targets).index(name)

    def set(self, targets: Mapping[str, Target], frames: Sequence[FrameState] | None = None) -> None:
        """Set the targets of some objects by name; frames: states of all tracked frames, None: as before."""
        with self._lock:
            self._targets.update(targets)
            self._frames = self._frames if frames is None else frames
            made = _core.LiveTargets()
            for one in self._targets.values():
                made.add(one.t, one.X_WO, one.V_WO, one.lost)
            for frame in self._frames:
                made.add_frame(frame.X_WF, frame.t_seen, frame.lost)
            self._loop.set_live(made)


def object_poses(rig: Rig, tick: Ticks) -> dict[str, Array]:
    """X_WO (4, 4) [m] of every object at a tick, as the loop renders it."""
    t, found, slot = float(tick["t"]), {}, 0
    for obj in rig.snapshot.objects:
        X_WO = live.object_pose(tick, slot) if obj.is_live else None
        found[obj.name] = obj.pose(t) if X_WO is None else X_WO
        slot += obj.is_live
    return found
