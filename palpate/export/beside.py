"""Forces of a record of Palpate's node beside a ROS 2 bag of the same time, put together by the wall clock."""

from __future__ import annotations

import os
from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import RecordError
from palpate.export.bag_ticks import BagTicks
from palpate.export.demonstration import Demonstration
from palpate.record.reader import Record
from palpate.session.recorded import recorded_scene

_IN_WORLD = ("F_T_W", "t_T_W", "normal")
_OTHERS = ("depth", "contacts", "F_H_L", "t_H_L")


class Beside:
    """Forces and contacts of a record at times of a bag; NaN while the record did not run.

    Args:
        record: a record of a run in real time.
        begin: wall-clock time of the start of the bag, in seconds since 1970 [s].

    Raises:
        RecordError: the record has no wall-clock time. SceneError: its scene cannot be read.
    """

    def __init__(self, record: Record, begin: float) -> None:
        if record.started is None:
            what, why = "the record does not know when it began", "it was made in lockstep, not in real time"
            raise RecordError(what, where=str(record.path), why=why, mend="give the record of the haptic node")
        base = recorded_scene(record).arms.follower.base
        self._record, self._R_WB = record, np.eye(3) if base is None else np.asarray(base.matrix())[:3, :3]
        self._t = np.asarray(record["t"])
        self._ahead = begin - record.started.timestamp()  # time of the record at the start of the bag [s]

    def at(self, t: Array) -> dict[str, Array]:
        """Signals (n, size) at times t (n,) of the bag [s], those in W turned into the base of the follower."""
        own = t + self._ahead
        k = np.searchsorted(self._t, own, side="right") - 1
        known = (k >= 0) & (own < self._t[-1] + 1.0 / self._record.rate)
        sizes = {**dict.fromkeys((*_IN_WORLD, "F_H_L", "t_H_L"), 3), "depth": 1, "contacts": 1}
        found = {name: np.full((len(t), sizes[name]), np.nan) for name in (*_IN_WORLD, *_OTHERS)}
        if not known.any():
            return found
        first = int(k[known].min())
        ticks = self._record.read((*_IN_WORLD, *_OTHERS), first, int(k[known].max()) + 1)
        for name, values in found.items():
            part = np.asarray(ticks[name], dtype=np.float64).reshape(len(ticks), -1)[k[known] - first]
            values[known] = part @ self._R_WB if name in _IN_WORLD else part
        return found

    def span(self) -> tuple[float, float]:
        """First and last time of the record, on the clock of the bag [s]."""
        return float(self._t[0] - self._ahead), float(self._t[-1] - self._ahead)


def with_forces(runs: Sequence[Demonstration], path: str | os.PathLike[str]) -> list[Demonstration]:
    """The bags of runs with the forces of a record that ran meanwhile.

    Raises:
        RecordError: a run is no bag, or the record did not run during a bag.
    """
    record = Record.open(os.fspath(path))
    return [_with(run, record) for run in runs]


def _with(run: Demonstration, record: Record) -> Demonstration:
    bag = run.arms[0].ticks
    if not isinstance(bag, BagTicks):
        mend = "leave --forces out: a record holds its own forces"
        raise RecordError("--forces is for ROS 2 bags, and this is a record", where=str(run.path), mend=mend)
    beside = Beside(record, bag.begin)
    (first, last), end = beside.span(), bag.start + len(bag) / bag.rate
    if last < bag.start or first > end:
        spans = [(bag.begin + bag.start, bag.begin + end), (bag.begin + first, bag.begin + last)]
        here, there = (" to ".join(f"{datetime.fromtimestamp(t, UTC):%Y-%m-%d %H:%M:%S}" for t in one) for one in spans)
        what = f"the record of the forces did not run during the bag: bag {here}, record {there} (UTC)"
        raise RecordError(
            what, where=str(record.path), mend="give the record of this bag, from a machine of equal clock"
        )
    bag.beside = beside
    return run
