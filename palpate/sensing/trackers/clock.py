"""Times of measurement in the session's time, from the stamps of a tracker whose clock may be any."""

from __future__ import annotations

import math
from collections import deque

_MEMORY = 10.0  # interval in which the fastest message is looked for [s]
_SLACK = 2e-3  # difference of clocks that is none [s]
_JITTER, _RATE = 0.1, 0.05  # difference of two intervals on both clocks that late messages explain [s], and drift [-]


class MeasurementClock:
    """Time of measurement of the poses of one tool.

    Stamps of this machine's clock, or of the session's, say how old a pose is. Those of another clock say it up to a
    constant: the pose that arrived fastest in the last 10 s has no age then. Stamps that run at another rate, or make
    a pose older than `max_age`, are not used; the time of arrival then takes their place.

    Args:
        delay: time from a measurement to its stamp, or to its arrival where stamps do not tell it [s].
        max_age: age above which a stamp is not believed [s].
    """

    def __init__(self, delay: float = 0.0, max_age: float = 0.2) -> None:
        self._given, self._max_age = delay, max_age
        self._seen: deque[tuple[float, float]] = deque()  # times of arrival, and stamps
        self._t = -math.inf
        self.delay = delay  #: time from the newest measurement to its arrival [s]
        self.arrival = False  #: True while times of arrival are used, because the stamps are wrong

    def time(self, stamp: float, now: float, wall: float) -> float:
        """Session's time of a measurement [s]; later than that of the one before.

        Args:
            stamp: stamp of the pose [s].
            now: session's time of arrival [s].
            wall: the same in seconds since 1970.
        """
        self._seen.append((now, stamp))
        while now - self._seen[0][0] > _MEMORY:
            self._seen.popleft()
        age = self._age(stamp, now, wall)
        self.arrival = age is None
        self.delay = self._given + (age or 0.0)
        self._t = max(now - self.delay, self._t + 1e-4)
        return self._t

    def _age(self, stamp: float, now: float, wall: float) -> float | None:
        """Time from stamp to arrival [s]; None: the stamps are wrong."""
        first, first_stamp = self._seen[0]
        if abs(stamp - first_stamp - (now - first)) > max(_JITTER, _RATE * (now - first)):
            return None
        for clock in (now, wall):
            if -_SLACK <= clock - stamp <= self._max_age:
                return max(clock - stamp, 0.0)
        age = now - stamp - min(there - sent for there, sent in self._seen)
        return age if age <= self._max_age else None
