"""What many runs leave: one array for each key of a session's summary, one for each signal that was asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from palpate.session.summary import Summary

Column = npt.NDArray[Any]

MEASURED = ("realtime_factor", "cycle_p50_us", "cycle_p99_us", "cycle_p999_us", "cycle_max_us")
"""Keys of the summary that depend on the machine; all others are the same wherever and in whatever order runs go."""

KEYS = tuple(f.name for f in fields(Summary) if f.type in ("float", "int", "bool"))
"""Keys of a session's summary that are numbers."""


class Outcome(NamedTuple):
    """What one run leaves."""

    summary: dict[str, float | int | bool]
    faults: tuple[str, ...]
    signals: dict[str, Column]
    """By name: (k,) or (k, size)."""

    @staticmethod
    def of(values: dict[str, Any]) -> Outcome:
        """From the plain values that a sweep keeps."""
        signals = {name: np.array(rows) for name, rows in values["signals"].items()}
        return Outcome(values["summary"], tuple(values["faults"]), signals)


@dataclass(frozen=True)
class Simulated:
    """Results of n runs, in the order in which the runs were given."""

    summary: dict[str, Column]
    """By key of docs/json.md (`palpate run`), shape (n,), units in the names."""
    faults: tuple[tuple[str, ...], ...]
    """Faults of each run, in words; empty when all was well."""
    t: npt.NDArray[np.float64]
    """(k,) times of the samples in `signals` [s]."""
    signals: dict[str, Column]
    """By name of the signal, shape (n, k) or (n, k, size), in the signal's unit (`palpate.record.SIGNALS`)."""

    def __len__(self) -> int:
        """Number of runs."""
        return len(self.faults)


def collected(outcomes: Sequence[Outcome], t: npt.NDArray[np.float64]) -> Simulated:
    """Outcomes as arrays."""
    return Simulated(
        summary={key: np.array([one.summary[key] for one in outcomes]) for key in KEYS},
        faults=tuple(one.faults for one in outcomes),
        t=t,
        signals={name: np.stack([one.signals[name] for one in outcomes]) for name in outcomes[0].signals},
    )
