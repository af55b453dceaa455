"""What a report needs of a run of any length, gathered in one pass over its record in constant memory.

Numbers are those of all ticks. The figures of a long run draw a choice of its ticks: of each of some hundred intervals,
those in which a drawn quantity is smallest or largest, so that every peak remains.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.record.reader import Record
from palpate.record.ticks import STATUS, Ticks
from palpate.report.touches import Touched
from palpate.report.tracked import Tracked
from palpate.session.rates import Recorded
from palpate.session.samples import Samples
from palpate.session.summary import Totals

MOST = 20_000
"""Ticks of a run up to which its figures draw all of them."""
INTERVALS = 150
"""Intervals of a longer run: of each about a hundred ticks are drawn."""
_NORMS = ("F_H_L", "F_cell_L", "F_touch_W", "F_estimate_W", "F_instrument_W", "v_LH")
_LEDGER = tuple(f"energy_{what}" for what in ("port", "spring", "damping", "cut", "passivity", "low_pass", "coupling"))
_SINGLE = ("depth", "F_neglected", "jaw", "jaw_goal", *_LEDGER)
_EACH = ("tau_force", "tau_gravity", "tau_platform", "F_H_L", "F_H_H", "p_WT", "energy_source")
_TERMS = ("F_spring_W", "F_damping_W")
_DRAWN = (
    *("t", "q", "normal", "delta_x", "F_T_W", "p_WP", "quat_WT", "contacts", "touch_sphere", "touch_object"),
    *("touch_force", "instrument_gap", "handle_gap"),
)
_REMOTE = (
    *("p_WR", "F_remote_W", "remote_age", "remote_delay", "remote_link", "remote_received"),
    *("energy_model", "energy_tank"),
)
_TIMES = ("cycle_us", "lateness_us")


class Digest:
    """A record, digested.

    Args:
        record: the record.
        frames: number of tracked frames.
    """

    def __init__(self, record: Record, frames: int = 0) -> None:
        whole = len(record) <= MOST
        self.rate = record.rate  #: [Hz]
        self.totals = Totals(record.rate)
        self.touched, self.tracked = Touched(), Tracked(frames)
        self.rates = Recorded(frames)
        self.times = {name: Samples() for name in _TIMES}  #: compute time and lateness of the cycles [us]
        self.status = dict.fromkeys(STATUS, 0)  #: ticks in which each bit of the status is set
        self.first_fast: float | None = None  #: first time at which the hand was too fast [s]
        self.closest: dict[str, float] = {"instrument_gap": np.inf, "handle_gap": np.inf}  #: smallest distances [m]
        self.pushed = 0  #: ticks in which another instrument pushes
        self._springs = np.zeros(3)  # ticks in contact, sums of depth times force, and of depth squared
        self._open: int | None = None  # first tick of the touch that goes on
        self._touches: list[tuple[int, int]] = []
        self._marks: list[tuple[int, float]] = []  # number and time of some ticks
        self._known = set(record.signals)
        choice = _Choice(-(-len(record) // INTERVALS))
        kept: list[Ticks] = []
        at = 0
        for ticks in record.blocks(self._signals(frames)):
            self._add(ticks, at)
            kept += [ticks.copy()] if whole else choice.add(ticks)
            at += len(ticks)
        kept += [] if whole else choice.rest()
        if self._open is not None:
            self._touches.append((self._open, at))
        self.ticks: Ticks = np.concatenate([one.view(np.uint8).reshape(len(one), -1) for one in kept]).view(
            kept[0].dtype
        )[:, 0]
        """The ticks that figures draw, in the order of time."""
        self.touches = self._touches
        """Intervals in contact: (first tick, tick after the last)."""
        self.even = slice(None) if whole else choice.even
        """Those of `ticks` that are spread evenly over the run."""

    @property
    def stiffness(self) -> float | None:
        """Slope of the spring force over the penetration, both on the tool [N/m]; None without contact."""
        n, force, square = self._springs.tolist()
        return None if n < 10 else force / square

    def time(self, tick: int) -> float:
        """Time of a tick [s]; exact to the rate between two marks, which are about a thousand ticks apart."""
        numbers, times = zip(*self._marks, strict=True)
        return float(np.interp(tick, numbers, times))

    def _signals(self, frames: int) -> list[str]:
        tracked = Tracked.SIGNALS if frames else ()
        names = (*_DRAWN, *_REMOTE, *_NORMS, *_SINGLE, *_EACH, *_TERMS, *_TIMES, *Totals.SIGNALS, *tracked)
        return list(dict.fromkeys(names))

    def _add(self, ticks: Ticks, at: int) -> None:
        for name in ticks.dtype.names or ():
            if name not in self._known and name not in _TIMES:
                ticks[name] = 0  # a thinned record draws zeros where nothing was recorded
        self.totals.add(ticks)
        self.touched.add(ticks)
        self.tracked.add(ticks)
        self.rates.add(ticks)
        for name, samples in self.times.items():
            samples.add(ticks[name])
        status = ticks["status"].astype(np.int64)
        for name, (bit, _) in STATUS.items():
            self.status[name] += int(np.count_nonzero(status & bit))
        fast = (status & STATUS["too_fast"][0]) != 0
        if self.first_fast is None and fast.any():
            self.first_fast = float(ticks["t"][np.argmax(fast)])
        for name in self.closest:
            self.closest[name] = min(self.closest[name], float(ticks[name].min()))
        self.pushed += int(np.count_nonzero(ticks["F_instrument_W"].any(axis=1)))
        pressed = ticks["depth"] > 0
        depth = ticks["depth"][pressed]
        force = np.einsum("ij,ij->i", ticks["F_spring_W"][pressed], ticks["normal"][pressed])
        self._springs += (len(depth), float(depth @ force), float(depth @ depth))
        self._marks += [(at, float(ticks["t"][0])), (at + len(ticks) - 1, float(ticks["t"][-1]))]
        self._follow(ticks["contacts"] > 0, at)

    def _follow(self, touching: NDArray[np.bool_], at: int) -> None:
        """Add the touches of further ticks, of which the first has number `at`."""
        before = np.concatenate([[self._open is not None], touching])
        for k in np.flatnonzero(before[1:] != before[:-1]).tolist():
            if touching[k]:
                self._open = at + k
            elif self._open is not None:
                self._touches.append((self._open, at + k))
                self._open = None


class _Choice:
    """Chooses ticks so that the smallest and the largest of each drawn quantity remain in each interval.

    Args:
        interval: ticks of an interval.
    """

    def __init__(self, interval: int) -> None:
        self._interval = interval
        self._found: list[Ticks] = []
        self._seen = self._count = 0
        self.even = np.zeros(0, np.intp)  #: places of the first tick of each interval in the choice

    def add(self, ticks: Ticks) -> list[Ticks]:
        """Add further ticks; returns the choice of the intervals that end."""
        chosen: list[Ticks] = []
        while len(ticks):
            part, ticks = ticks[: self._interval - self._seen], ticks[self._interval - self._seen :]
            self._found.append(_extreme(part))
            self._seen += len(part)
            if self._seen == self._interval:
                chosen += self.rest()
        return chosen

    def rest(self) -> list[Ticks]:
        """The choice of the last interval."""
        if not self._found:
            return []
        chosen = _extreme(np.concatenate(self._found))
        self._found, self._seen = [], 0
        self.even = np.append(self.even, self._count)
        self._count += len(chosen)
        return [chosen]


def _extreme(ticks: Ticks) -> Ticks:
    """The first and the last tick, and those at which a drawn quantity is smallest or largest."""
    drawn = np.nan_to_num(np.concatenate(list(_drawn(ticks)), axis=1), copy=False)
    rows = np.unique([0, len(ticks) - 1, *drawn.argmin(axis=0), *drawn.argmax(axis=0)])
    found: Ticks = ticks[rows]
    return found


def _drawn(ticks: Ticks) -> Iterator[Array]:
    """The drawn quantities (n, k)."""
    n = len(ticks)
    for name in _NORMS:
        yield np.linalg.norm(ticks[name], axis=1)[:, None]
    for name in (*_SINGLE, *_EACH, "touch_force"):
        yield ticks[name].reshape(n, -1)
    for name in _TERMS:
        yield np.einsum("ij,ij->i", ticks[name], ticks["normal"])[:, None]
