"""A peak that noise does not raise: the largest mean over a short window."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array

WINDOW = 0.05
"""Length of the window [s]: a hand feels forces up to about 20 Hz as forces, faster ones as vibration."""


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


def sustained(values: Array, dt: float) -> float:
    """Largest mean over `WINDOW` of samples (n,) that are `dt` [s] apart."""
    peak = SustainedPeak(dt)
    peak.add(values)
    return peak.value
