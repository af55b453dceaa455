"""The newest valid numbers of an arm's topics. Invalid messages are left out: a topic with nothing else grows old."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from palpate.base.arrays import Array

_UNIT = 0.01  # error of a quaternion's squared norm, as in the haptic cycle


class _Heard(NamedTuple):
    numbers: Array
    stamp: tuple[int, int]
    at: float


class Newest:
    """Keeps the numbers of the newest valid message of each topic.

    A message is invalid if a number is not finite, if its quaternion is no rotation, or if its stamp is zero (by which
    CRTK marks invalid values) or that of the message before (whatever measures has stopped).
    """

    def __init__(self) -> None:
        self._heard: dict[str, _Heard] = {}

    def keep(self, name: str, message: Any, now: float) -> None:
        """Take a message of the topic `name` that came at the time `now` [s]."""
        stamp, before = (message.header.stamp.sec, message.header.stamp.nanosec), self._heard.get(name)
        if not any(stamp) or (before is not None and before.stamp == stamp):
            return
        values = _numbers(message)
        if not values.size or not np.isfinite(values).all():
            return
        if hasattr(message, "pose") and abs(values[3:] @ values[3:] - 1.0) > _UNIT:
            return
        self._heard[name] = _Heard(values, stamp, now)

    def __contains__(self, name: str) -> bool:
        """True once a valid message of the topic has come."""
        return name in self._heard

    def __getitem__(self, name: str) -> Array:
        """The newest valid numbers of a topic."""
        return self._heard[name].numbers

    def age(self, name: str, now: float) -> float:
        """Time since the newest valid message came; infinite before the first [s]."""
        return now - self._heard[name].at if name in self._heard else math.inf


def _numbers(message: Any) -> Array:
    """Position [m] and quaternion w x y z (7,) of a pose; velocity or force (3,); positions of joints (n,)."""
    if hasattr(message, "pose"):
        p, o = message.pose.position, message.pose.orientation
        return np.array([p.x, p.y, p.z, o.w, o.x, o.y, o.z])
    if hasattr(message, "position"):
        return np.array(message.position, dtype=float)
    v = message.twist.linear if hasattr(message, "twist") else message.wrench.force
    return np.array([v.x, v.y, v.z])
