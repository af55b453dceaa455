"""Samples of a quantity over a run of any length, for its percentiles."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array

MOST = 400_000
"""Number of samples that are kept [-]; even."""


class Samples:
    """All finite values up to 400,000, and then every second one, every fourth ...: a percentile of n values that come
    in no rhythm is off by at most a share of about 1 / sqrt(200,000) of the ranks."""

    def __init__(self) -> None:
        self._values = np.empty(0, np.float32)
        self._kept, self._stride, self._known = 0, 1, 0
        self.largest = 0.0
        """Largest of all values, at least zero."""

    def add(self, values: Array) -> None:
        """Add further values (n,)."""
        known = values.astype(np.float32)
        known = known[np.isfinite(known)]
        if not len(known):
            return
        if not len(self._values):
            self._values = np.empty(MOST, np.float32)  # pages are taken as they fill
        self.largest = max(self.largest, float(known.max(initial=0.0)))
        rest = known[-self._known % self._stride :: self._stride]
        self._known += len(known)
        while len(rest):
            if self._kept == len(self._values):
                self._kept, self._stride = self._kept // 2, 2 * self._stride
                self._values[: self._kept] = self._values[::2].copy()
                rest = rest[::2]
            fits = rest[: len(self._values) - self._kept]
            self._values[self._kept : self._kept + len(fits)] = fits
            self._kept += len(fits)
            rest = rest[len(fits) :]

    @property
    def values(self) -> np.ndarray[tuple[int], np.dtype[np.float32]]:
        """The samples, in order of time."""
        return self._values[: self._kept]
