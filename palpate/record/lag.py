"""How late does a filter make the force? The lag of each element of the stage `stability`, by the signal `lag_ms`.

Coupling and low-pass state the delay that they add to a ramp of the force; the coupling leads, so its lag is negative.
Passivity controller and caps add none until they withhold force: then it is the time in which the rate cap would give
that force.
"""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.record.ticks import Ticks

NAMES = ("coupling", "low_pass", "passivity", "caps")
"""Elements in the order of the signal `lag_ms`."""
WORDS = {"coupling": "virtual coupling", "low_pass": "low-pass", "passivity": "passivity", "caps": "caps"}
LEAST = 0.005
"""Smallest lag that is told [ms]."""


def in_words(lag_ms: Array) -> str:
    """The lags (4,) [ms] of the elements that have one; ``none`` if no element has."""
    found = [
        f"{WORDS[name]} {x:.2g} ms" for name, x in zip(NAMES, np.nan_to_num(lag_ms), strict=True) if abs(x) >= LEAST
    ]
    return ", ".join(found) or "none"


class Lags:
    """Accumulates the lags of the ticks in which a force was asked of the hand."""

    SIGNALS = ("lag_ms", "F_asked")
    """Signals that the ticks must have."""

    def __init__(self) -> None:
        self._sum, self._largest, self._ticks = np.zeros(len(NAMES)), np.zeros(len(NAMES)), 0

    def add(self, ticks: Ticks) -> None:
        """Add further ticks (n,)."""
        lags = np.nan_to_num(ticks["lag_ms"][np.nan_to_num(ticks["F_asked"][:, 0]) > 0.0])
        if not len(lags):
            return
        self._ticks += len(lags)
        self._sum += lags.sum(axis=0)
        rows = np.abs(lags).argmax(axis=0)
        found = lags[rows, np.arange(len(NAMES))]
        self._largest = np.where(np.abs(found) > np.abs(self._largest), found, self._largest)

    def figures(self) -> dict[str, dict[str, float]]:
        """By element: mean and largest lag [ms], of those with one; negative where the force leads."""
        return {
            name: {"mean_ms": float(self._sum[k] / self._ticks), "max_ms": float(self._largest[k])}
            for k, name in enumerate(NAMES) if abs(self._largest[k]) >= LEAST
        }  # fmt: skip
