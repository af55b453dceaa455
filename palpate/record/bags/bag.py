"""What a bag of a CRTK session holds: the tracks of its arms, the events, how steadily each topic came."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from palpate.errors import RecordError

Array = NDArray[np.float64]


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
class Bag:
    """A CRTK session."""

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

    @classmethod
    def open(cls, path: str | Path) -> Bag:
        """Read a rosbag2: its folder, an ``.mcap`` or a ``.db3``.

        Raises:
            RecordError: there is none, it is damaged, or no arm in it speaks CRTK.
            MissingExtraError: the library is not installed.
        """
        from palpate.record.bags.reading import read

        bag = read(Path(path))
        if not any(len(a.pose.t) or len(a.q.t) for a in bag.arms.values()):
            names = ", ".join(t.name for t in bag.topics[:6]) or "none"
            raise RecordError(
                "no arm in this bag speaks CRTK: there is no measured_cp and no measured_js",
                where=str(bag.path),
                why=f"its topics: {names}{', ...' if len(bag.topics) > 6 else ''}",
                mend="record the arm's topics: ros2 bag record -a",
            )
        return bag

    @cached_property
    def pair(self) -> tuple[str, str | None]:
        """Names of the leader and its follower: as a teleop component pairs them, else by name, else by who is pushed.

        The leader is the arm that was commanded a wrench; a bag of one arm has no follower.
        """
        moved = [n for n, a in self.arms.items() if len(a.pose.t) or len(a.q.t)]
        for event in self.events:
            first, _, second = event.topic.strip("/").split("/")[0].partition("_")
            if first in moved and second in moved:
                return first, second
        leaders = sorted(moved, key=lambda n: (not len(self.arms[n].wrench.t), not n.startswith("MTM"), n))
        followers = [n for n in moved if n.startswith("PSM") and n != leaders[0]]
        return leaders[0], followers[0] if followers else None
