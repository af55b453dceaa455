"""Tables of every tick, for formats that hold one file for each arm of a run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from palpate.base.errors import PalpateError, RecordError
from palpate.export.bag_ticks import BagTicks
from palpate.export.demonstration import Demonstration, free_name
from palpate.export.frames import SIGNALS as OF_BAGS
from palpate.export.options import Options
from palpate.record.frame import column_names
from palpate.record.reader import BLOCK, Record
from palpate.record.ticks import SIGNALS, Signal, Ticks


@dataclass(frozen=True)
class Table:
    """Ticks of one arm."""

    name: str
    """Name of the file, without its ending."""
    ticks: Record | BagTicks
    signals: tuple[Signal, ...]
    """The signals of the table; the time comes first."""
    every: int
    """Each n-th tick is kept."""

    def facts(self) -> dict[str, str]:
        """What is true of the whole table."""
        made = self.ticks
        facts = {"rate_Hz": f"{made.rate / self.every:g}"}
        if isinstance(made, Record):
            facts |= {"palpate_version": made.version, "scene": made.scene}
            facts |= {"started": made.started.isoformat()} if made.started else {}
        return facts

    def blocks(self) -> Iterator[Ticks]:
        """The ticks, about a thousand at a time."""
        names = [signal.name for signal in self.signals]
        span = max(1, BLOCK // self.every) * self.every
        for start in range(0, len(self.ticks), span):
            yield self.ticks.read(names, start, min(start + span, len(self.ticks)))[:: self.every]

    def whole(self) -> dict[str, NDArray[np.generic]]:
        """All ticks by signal: (n,) or (n, size)."""
        parts = list(self.blocks())
        return {signal.name: np.concatenate([part[signal.name] for part in parts]) for signal in self.signals}


def columns_of(ticks: Ticks, signals: Sequence[Signal]) -> dict[str, NDArray[np.generic]]:
    """The numbers of ticks (n,) by the name of their column, such as ``F_T_W.x [N]``."""
    found: dict[str, NDArray[np.generic]] = {}
    for signal in signals:
        values = ticks[signal.name].reshape(len(ticks), -1)
        found |= dict(zip(column_names(signal), np.ascontiguousarray(values.T), strict=True))
    return found


def tables(runs: Sequence[Demonstration], options: Options) -> list[Table]:
    """The tables of runs, one for each arm.

    Raises:
        PalpateError: an option has no meaning. RecordError: a record does not hold a signal.
    """
    if options.every < 1:
        raise PalpateError(f"every = {options.every}: must be at least 1")
    found: dict[str, Table] = {}
    for run in runs:
        for arm in run.arms:
            known = dict(arm.ticks.signals) if isinstance(arm.ticks, Record) else {n: SIGNALS[n] for n in OF_BAGS}
            names = list(dict.fromkeys(["t", *(options.signals or known)]))
            missing = [name for name in names if name not in known]
            if missing:
                what = f"the record does not hold {', '.join(missing)}"
                raise RecordError(what, where=str(run.path), mend=f"it holds {', '.join(known)}")
            name = free_name(run.name if len(run.arms) == 1 else f"{run.name}-{arm.name}", found)
            found[name] = Table(name, arm.ticks, tuple(known[one] for one in names), options.every)
    return list(found.values())


def told(written: Sequence[tuple[Table, Path, int]]) -> dict[str, object]:
    """Facts for the user about written tables: table, file, number of rows."""
    return {"files": [file.name for _, file, _ in written], "rows": [rows for *_, rows in written]}
