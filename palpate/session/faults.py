"""Faults of a run on a device: which conditions removed its force, when first and for how many ticks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.record.ticks import STATUS, Ticks

NO_FAULTS = frozenset({
    "not_following", "clutched", "force_capped", "rate_capped", "passivity", "ik_failed", "guided", "goal_corrected",
})  # fmt: skip
"""Status bits of ordinary operation."""


@dataclass
class Seen:
    """Time of the first tick with a fault [s], and the number of such ticks."""

    first: float
    ticks: int = 0


class SeenFaults:
    """The faults in the status of ticks.

    Args:
        ordinary: names of status bits that are no faults.
    """

    def __init__(self, ordinary: frozenset[str] = NO_FAULTS) -> None:
        self._bits = {name: (bit, words) for name, (bit, words) in STATUS.items() if name not in ordinary}
        self.seen: dict[str, Seen] = {}  #: by the name of the status bit

    def take(self, ticks: Ticks) -> None:
        """Count the faults of ticks."""
        status, t = ticks["status"].astype(np.int64), ticks["t"]
        for name, (bit, _) in self._bits.items():
            hits = np.flatnonzero(status & bit)
            if len(hits):
                self.seen.setdefault(name, Seen(float(t[hits[0]]))).ticks += len(hits)

    def words(self) -> list[str]:
        """A sentence for each fault."""
        return [
            f"{self._bits[name][1]} (first at t = {one.first:.3f} s, {one.ticks} ticks)"
            for name, one in self.seen.items()
        ]
