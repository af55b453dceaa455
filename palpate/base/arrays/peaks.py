"""A peak that noise does not raise: the largest mean over a short window."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array

WINDOW = 0.05
"""Length of the window [s]: a hand feels forces up to about 20 Hz as forces, faster ones as vibration."""
_PIECE = 1000  # values that are counted at once


class SustainedPeak:
    """Largest mean over `WINDOW` of a signal that comes in pieces.

    The largest sample of a noisy signal grows with the length of the recording, by 3 to 4 standard deviations of the
    noise; this mean grows by that over the root of the number of samples in the window.

    Args:
        dt: time between samples [s].
    """

    def __init__(self, dt: float) -> None:
        self._n = max(1, round(WINDOW / dt))
        self._last = np.zeros(0)
        self.value, self._whole = 0.0, False

    def add(self, values: Array) -> None:
        """Add further samples (n,); while fewer than a window are known, their mean counts."""
        x = np.concatenate([self._last, values])
        n = min(self._n, len(x))
        if n:  # each window is summed by itself: the result does not depend on the pieces
            found = float(np.lib.stride_tricks.sliding_window_view(x, n).sum(axis=1).max()) / n
            self.value = max(self.value, found) if self._whole else found
            self._whole = self._whole or n == self._n
        self._last = x[max(0, len(x) - self._n + 1) :]


def sustained_held(t: Array, values: Array, end: float) -> float:
    """Largest mean over `WINDOW` of a value that holds from each of its times (n,) [s] to the next, the last to `end`.

    The mean is largest where the window begins or ends at a change. Shorter signals count as a whole.
    """
    ends = np.append(t, max(end, float(t[-1]))) if len(t) else np.zeros(1)
    length = float(ends[-1] - ends[0])
    if length <= 0.0:
        return float(values.max(initial=0.0))
    total = np.concatenate([[0.0], np.cumsum(values * np.diff(ends))])
    window = min(WINDOW, length)
    first = np.clip(np.concatenate([ends, ends - window]), ends[0], ends[-1] - window)
    means = (np.interp(first + window, ends, total) - np.interp(first, ends, total)) / window
    return float(means.max(initial=0.0))


class HeldPeak:
    """Largest value, and largest mean over `WINDOW`, of a value that comes at times of its own and holds until the next
    one.
    """

    def __init__(self) -> None:
        self._largest = self._mean = 0.0
        self._newest: list[tuple[float, float]] = []

    def add(self, t: float, value: float) -> None:
        """Add a value at a time [s], later than those before."""
        self._newest.append((t, value))
        if len(self._newest) >= _PIECE:
            self.values()

    def values(self) -> tuple[float, float]:
        """The largest value so far, and the largest mean."""
        if self._newest:
            t, x = np.array(self._newest).T
            self._largest = max(self._largest, float(x.max()))
            self._mean = max(self._mean, sustained_held(t, x, float(t[-1])))
            self._newest = [one for one in self._newest if one[0] >= t[-1] - WINDOW]
        return self._largest, self._mean


def sustained(values: Array, dt: float) -> float:
    """Largest mean over `WINDOW` of samples (n,) that are `dt` [s] apart."""
    peak = SustainedPeak(dt)
    peak.add(values)
    return peak.value
