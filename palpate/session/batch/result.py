"""Results of a batch: one array for each key of a session's summary, and one for each requested signal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.sweep.work import Values
from palpate.session.summary import Summary

Column = npt.NDArray[Any]

MEASURED = ("realtime_factor", "cycle_p50_us", "cycle_p99_us", "cycle_p999_us", "cycle_max_us")
"""Keys of the summary that depend on the machine; all others depend neither on it nor on the order of the runs."""

KEYS = tuple(f.name for f in fields(Summary) if f.type in ("float", "int", "bool"))
"""Numeric keys of a session's summary."""


@dataclass(frozen=True)
class Outcome:
    """Result of one run."""

    summary: dict[str, float | int | bool]
    faults: tuple[str, ...]
    signals: dict[str, Column]
    """Samples by signal name, (k,) or (k, size)."""

    @staticmethod
    def of(values: Values) -> Outcome:
        """The outcome from the plain values stored by a sweep."""
        signals = {name: np.array(rows) for name, rows in values["signals"].items()}
        return Outcome(values["summary"], tuple(values["faults"]), signals)


@dataclass(frozen=True)
class Simulated:
    """Results of n runs, in the order in which the runs were given."""

    summary: dict[str, Column]
    """Arrays (n,) by key of docs/json.md (`palpate run`); the keys name the units."""
    faults: tuple[tuple[str, ...], ...]
    """Fault messages of each run; empty if the run had none."""
    t: npt.NDArray[np.float64]
    """Times (k,) of the samples in `signals` [s]."""
    signals: dict[str, Column]
    """Arrays (n, k) or (n, k, size) by signal name, in the signal's unit (`palpate.record.SIGNALS`)."""

    def __len__(self) -> int:
        """Number of runs."""
        return len(self.faults)


def stack_outcomes(outcomes: Sequence[Outcome], t: npt.NDArray[np.float64]) -> Simulated:
    """Stack the outcomes of n runs into arrays."""
    return Simulated(
        summary={key: np.array([one.summary[key] for one in outcomes]) for key in KEYS},
        faults=tuple(one.faults for one in outcomes),
        t=t,
        signals={name: np.stack([one.signals[name] for one in outcomes]) for name in outcomes[0].signals},
    )
