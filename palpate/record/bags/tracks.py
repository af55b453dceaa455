"""The contents of a bag of a CRTK session: tracks of its arms, events, and how steadily each topic came."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from palpate.arrays import Array


@dataclass(frozen=True)
class Track:
    """Numbers over time."""

    t: Array
    """(n,) when the message was received, since the bag began [s]; ascending."""
    values: Array
    """(n, k), in the unit of the topic."""

    def at(self, t: Array) -> Array:
        """The last values that had been received at each time (m,): (m, k); NaN before the first."""
        if not len(self.t):
            return np.full((len(t), self.values.shape[1]), np.nan)
        k = np.searchsorted(self.t, t, side="right") - 1
        return np.where((k >= 0)[:, None], self.values[np.maximum(k, 0)], np.nan)


def nothing(width: int) -> Track:
    """A track of a topic that is not in the bag."""
    return Track(np.empty(0), np.empty((0, width)))


@dataclass
class Arm:
    """The tracks of one arm; those that are not in the bag are empty. Frames as the CRTK topic says."""

    name: str
    q: Track = field(default_factory=lambda: nothing(0))
    """measured_js: (n, joints) [rad, m]."""
    v: Track = field(default_factory=lambda: nothing(0))
    """Its velocities [rad/s, m/s]."""
    tau: Track = field(default_factory=lambda: nothing(0))
    """Its efforts [N m, N]."""
    pose: Track = field(default_factory=lambda: nothing(7))
    """measured_cp: x y z [m] and quaternion w x y z, in the arm's base frame M."""
    twist: Track = field(default_factory=lambda: nothing(6))
    """measured_cv, in M [m/s, rad/s]."""
    goal: Track = field(default_factory=lambda: nothing(7))
    """servo_cp, setpoint_cp or servo_cs: as `pose`."""
    wrench: Track = field(default_factory=lambda: nothing(6))
    """Commanded: body/servo_cf, spatial/servo_cf or the teleop's hook [N, N m], in the frame that `absolute` tells."""
    absolute: Track = field(default_factory=lambda: nothing(1))
    """Each wrench of `wrench`: 1 in the axes of M, 0 in the axes of the tip."""
    gripper: Track = field(default_factory=lambda: nothing(1))
    """Gripper or jaw [rad]."""


@dataclass(frozen=True)
class Event:
    """A state, a pedal, a message in words."""

    t: float
    """[s]."""
    topic: str
    text: str


@dataclass(frozen=True)
class Topic:
    """How one topic came."""

    name: str
    type: str
    count: int
    rate: float
    """Median [Hz]; 0 below three messages."""
    gap: float
    """Longest time between two messages [s]."""
    silent: int
    """Messages with a stamp of zero: the sender said that they are invalid."""
    bad: int
    """Messages with a number that is not finite."""


@dataclass
class Contents:
    """What was read of a CRTK session."""

    path: Path
    duration: float
    """[s]."""
    arms: dict[str, Arm]
    """By name, e.g. ``MTMR``."""
    events: list[Event]
    topics: list[Topic]
    scene: str = ""
    """The scene, where a Palpate node was on the bus and published it (YAML)."""
    notes: list[str] = field(default_factory=list)
    """What could not be read, in words."""
