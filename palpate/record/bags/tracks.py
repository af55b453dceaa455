"""Contents of a bag of a CRTK session: tracks of its arms, events, and statistics of its topics."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from palpate.base.arrays import Array


@dataclass(frozen=True)
class Track:
    """Values over time."""

    t: Array
    """(n,) reception times since the start of the bag [s]; ascending."""
    values: Array
    """(n, k), in the unit of the topic."""
    stamps: Array = field(default_factory=lambda: np.empty(0))
    """(n,) times of the messages' stamps since the start of the bag [s]; NaN without one."""

    def at(self, t: Array) -> Array:
        """Values (m, k) received last before each time t (m,) [s]; NaN before the first."""
        if not len(self.t):
            return np.full((len(t), self.values.shape[1]), np.nan)
        k = np.searchsorted(self.t, t, side="right") - 1
        return np.where((k >= 0)[:, None], self.values[np.maximum(k, 0)], np.nan)


def nothing(width: int) -> Track:
    """The empty track of a topic that is not in the bag."""
    return Track(np.empty(0), np.empty((0, width)))


@dataclass
class ArmTracks:
    """Tracks of one arm, empty if not in the bag, in the frames of their CRTK topics."""

    name: str
    q: Track = field(default_factory=lambda: nothing(0))
    """measured_js: positions (n, joints) [rad, m]."""
    v: Track = field(default_factory=lambda: nothing(0))
    """measured_js: velocities (n, joints) [rad/s, m/s]."""
    tau: Track = field(default_factory=lambda: nothing(0))
    """measured_js: efforts (n, joints) [N m, N]."""
    pose: Track = field(default_factory=lambda: nothing(7))
    """measured_cp: x y z [m] and quaternion w x y z, in the arm's base frame M."""
    twist: Track = field(default_factory=lambda: nothing(6))
    """measured_cv, in M [m/s, rad/s]."""
    goal: Track = field(default_factory=lambda: nothing(7))
    """servo_cp, setpoint_cp or servo_cs, in the format of `pose`."""
    wrench: Track = field(default_factory=lambda: nothing(6))
    """Commanded by body/servo_cf, spatial/servo_cf or the teleoperation [N, N m], in the axes given by `absolute`."""
    absolute: Track = field(default_factory=lambda: nothing(1))
    """Axes of each wrench of `wrench`: 1 for those of M, 0 for those of the tip."""
    gripper: Track = field(default_factory=lambda: nothing(1))
    """Angle of gripper or jaw [rad]."""


@dataclass(frozen=True)
class Event:
    """A state, a pedal event or a text message."""

    t: float
    """Reception time since the start of the bag [s]."""
    topic: str
    text: str


@dataclass(frozen=True)
class Topic:
    """Statistics of one topic."""

    name: str
    type: str
    count: int
    rate: float
    """Median rate [Hz]; 0 for fewer than three messages."""
    gap: float
    """Longest time between two messages [s]."""
    silent: int
    """Number of messages with a zero stamp, by which the sender marks them as invalid."""
    bad: int
    """Number of messages with values that are not finite."""
    offset: float | None = None
    """Median of stamp minus time of reception [s]; None without stamps."""


@dataclass
class Contents:
    """Everything read from a bag."""

    path: Path
    duration: float
    """Time from the start to the last message [s]."""
    arms: dict[str, ArmTracks]
    """Arms by name, e.g. ``MTMR``."""
    events: list[Event]
    topics: list[Topic]
    scene: str = ""
    """The scene (YAML), if a Palpate node published it."""
    notes: list[str] = field(default_factory=list)
    """Messages about topics that could not be decoded."""
    begin: float = 0.0
    """Wall-clock time of the start, in seconds since 1970 [s]."""
