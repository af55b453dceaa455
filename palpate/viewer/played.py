"""The ticks that a replay shows: those of a record are read when they are shown, so that its length does not matter."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np

from palpate.record.reader import BLOCK, Record
from palpate.record.ticks import Ticks
from palpate.viewer.gauges import WINDOW
from palpate.viewer.words import follows

_NEAR = 100  # ticks about the place that a steady rate gives


class Played:
    """Ticks by their number and their time.

    Args:
        run: a record, or ticks (n,) in memory, n >= 1.
    """

    def __init__(self, run: Record | Ticks) -> None:
        self._run, self._count = run, len(run)
        if isinstance(run, Record):
            run.remember(1.5 * WINDOW)
        self.span = self.time(0), self.time(self._count - 1)
        """Time of the first and of the last tick [s]."""

    def __len__(self) -> int:
        """Number of ticks."""
        return self._count

    def time(self, k: int) -> float:
        """Time of tick k [s]."""
        return float(self.read(["t"], k, k + 1)["t"][0])

    def number(self, t: float) -> int:
        """Number of the newest tick that is not later than t [s]; 0 before the first one."""
        return max(0, self._later(t) - 1)

    def tick(self, k: int) -> Ticks:
        """Tick k with all signals."""
        found: Ticks = self.read(None, k, k + 1)[0]
        return found

    def window(self, signals: Sequence[str], k: int, seconds: float, most: int) -> Ticks:
        """Some signals of about `most` ticks that lie evenly in the last `seconds` up to tick k."""
        start = min(self._later(self.time(k) - seconds), k)
        return self.read(signals, start, k + 1, max(1, (k + 1 - start) // most))

    def _later(self, t: float) -> int:
        """Number of the first tick later than t [s], found near the place that a steady rate gives."""
        (first, last), n = self.span, self._count
        guess = round((t - first) / max(last - first, 1e-9) * (n - 1))
        low, high = (min(max(guess + step, 0), n) for step in (-_NEAR, _NEAR))
        if (low > 0 and self.time(low - 1) > t) or (high < n and self.time(high) <= t):
            low, high = 0, n
        return bisect_right(range(n), t, low, high, key=self.time)

    def end(self) -> int:
        """Number of the tick in which the run ends: from there on nothing follows any more; `len(self)` without."""
        for stop in range(self._count, 0, -BLOCK):
            start = max(0, stop - BLOCK)
            found = np.flatnonzero(follows(self.read(["status"], start, stop)))
            if len(found):
                return start + int(found[-1]) + 1
        return self._count

    def read(self, signals: Sequence[str] | None, start: int, stop: int, every: int = 1) -> Ticks:
        """As `Record.read`."""
        if isinstance(self._run, Record):
            return self._run.read(signals, start, stop, every)
        found: Ticks = self._run[start:stop:every]
        return found
