"""A ROS 2 bag of a CRTK session as ticks at 1 kHz: each value is the newest message that had been received."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Protocol

import numpy as np

from palpate.base.arrays import Array, so3
from palpate.record.bags.bag import Bag
from palpate.record.bags.tracks import ArmTracks, Track
from palpate.record.ticks import SIGNALS, Ticks

RATE = 1000.0
"""Rate of the ticks [Hz]: that of the fastest topics of a dVRK."""


class Forces(Protocol):
    """Forces that were recorded beside a bag."""

    def at(self, t: Array) -> dict[str, Array]:
        """Signals (n, size) by their names in a record, at times t (n,) since the start of the bag [s]."""
        ...


class BagTicks:
    """Leader and follower of a bag, read as a `Record`. Poses are those of the topics, in the base of each arm."""

    rate = RATE

    def __init__(self, bag: Bag, leader: str, follower: str) -> None:
        self.leader = bag.arms.get(leader, ArmTracks(leader))
        self.follower = bag.arms[follower]
        known = self.follower.pose if len(self.follower.pose.t) else self.follower.q
        self.start = float(known.t[0])
        """First time with a measurement of the follower, since the start of the bag [s]."""
        self.begin = bag.begin
        """Wall-clock time of the start of the bag, in seconds since 1970 [s]."""
        self.started = datetime.fromtimestamp(bag.begin + self.start, UTC)
        self.beside: Forces | None = None
        """Forces that were recorded beside the bag."""
        self.scene = bag.scene
        """The scene (YAML) that a Palpate node published; empty without one."""
        self._count = int((float(known.t[-1]) - self.start) * RATE) + 1

    def __len__(self) -> int:
        """Number of ticks."""
        return self._count

    def joints(self, side: str) -> int:
        """Number of joints of ``leader`` or ``follower``, without gripper and jaw."""
        return int((self.leader if side == "leader" else self.follower).q.values.shape[1])

    def read(self, signals: Sequence[str], start: int = 0, stop: int | None = None) -> Ticks:
        """Signals by the names of a record; those that the bag does not hold are NaN."""
        t = self.start + np.arange(start, self._count if stop is None else min(stop, self._count)) / RATE
        known = [SIGNALS[name] for name in signals]
        ticks = np.empty(len(t), np.dtype([(s.name, s.format, (s.size,) if s.size > 1 else ()) for s in known]))
        values = self._values(t)
        for signal in known:
            ticks[signal.name] = np.nan
            found = values.get(signal.name)
            if found is not None:
                part = found[:, : signal.size]
                if signal.size == 1:
                    ticks[signal.name] = part[:, 0] if part.shape[1] else np.nan
                else:
                    ticks[signal.name][:, : part.shape[1]] = part
        return ticks

    def _values(self, t: Array) -> dict[str, Array]:
        pose, goal = self.follower.pose.at(t), self.follower.goal.at(t)
        force, torque = self._wrench_on_hand(t)
        return {
            "t": t[:, None] - self.start,
            "p_WT": pose[:, :3],
            "quat_WT": pose[:, 3:],
            "p_WT_goal": goal[:, :3],
            "quat_WT_asked": goal[:, 3:],
            "jaw": self.follower.gripper.at(t),
            "q_follower": self.follower.q.at(t),
            "q": self.leader.q.at(t),
            "gripper": self.leader.gripper.at(t),
            "F_H_L": force,
            "t_H_L": torque,
            **({} if self.beside is None else self.beside.at(t)),
        }

    def _wrench_on_hand(self, t: Array) -> tuple[Array, Array]:
        """Force and torque (n, 3) commanded on the hand, in the axes of the leader's base."""
        wrench, absolute = self.leader.wrench.at(t), self.leader.absolute.at(t)[:, :1]
        R = so3.matrices(_poses(self.leader.pose, t))
        turned = [np.einsum("nij,nj->ni", R, part) for part in (wrench[:, :3], wrench[:, 3:])]
        force, torque = (np.where(absolute == 1.0, part, other)
                         for part, other in zip((wrench[:, :3], wrench[:, 3:]), turned, strict=True))  # fmt: skip
        return force, torque


def _poses(pose: Track, t: Array) -> Array:
    """Quaternions (n, 4), w x y z, of a track of poses."""
    return pose.at(t)[:, 3:]
