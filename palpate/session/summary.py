"""Summary of a run, for the terminal, for `--json` and for the report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from palpate.base.arrays.peaks import SustainedPeak
from palpate.record.lag import Lags
from palpate.record.ticks import STATUS, Ticks
from palpate.record.withheld import Withheld
from palpate.session.samples import Samples

_FAST = STATUS["too_fast"][0]
_PASSIVITY = STATUS["passivity"][0]
_CAPPED = STATUS["force_capped"][0] | STATUS["rate_capped"][0]
_TOGETHER = 100  # ticks that are counted at once: counting one takes as long as counting a hundred


@dataclass(frozen=True)
class Summary:
    """Results of a run. The names contain the units; docs/json.md describes every field."""

    duration_s: float  # simulated time; on a device by its clock, missed ticks included
    ticks: int
    realtime: bool  # false: lockstep
    realtime_factor: float  # simulated time per real time; 0 if unknown
    interrupted: bool  # stopped by the user before its end
    peak_force_N: float  # maximum force commanded on the hand
    peak_50ms_N: float  # the same without noise and single ticks: largest mean over 50 ms
    mean_force_N: float  # mean force commanded on the hand during contact
    max_penetration_m: float
    contact_s: float  # time in contact
    capped_s: float  # time during which a cap reduced the force
    passivity_s: float  # time during which the passivity controller reduced the force
    peak_speed_m_s: float  # maximum speed of the handle
    fast_s: float  # time during which the hand felt noticeable uncompensated inertia (status too_fast)
    withheld: dict[str, dict[str, float]]  # by element: peak_N, mean_N, time_s of the force that it withheld
    shift_m: float  # shift of the tool against the hand by pauses after faults, at the end
    energy_J: float  # energy absorbed by the rendered force; negative: the force generated energy
    energy_min_J: float  # minimum of energy_J during the run
    energy_lent_J: float  # largest credit for fixtures that were switched on, which the hand's work had not repaid
    cycle_p50_us: float  # compute time of a haptic cycle
    cycle_p99_us: float
    cycle_p999_us: float
    cycle_max_us: float
    missed_ticks: int
    lag_ms: dict[str, dict[str, float]] = field(default_factory=dict)  # by filter: mean_ms, max_ms of its delay
    instrument: str = ""  # model of the follower with its instrument
    scheduler: str = ""  # scheduling granted to the real-time thread, in words; empty in lockstep
    faults: tuple[str, ...] = ()  # messages
    record: str | None = None  # path
    report: str | None = None  # path
    record_sha256: str | None = None
    remote: dict[str, Any] | None = None  # the link to a follower across a network; None: there was none


class Totals:
    """Accumulates the summary of a run, in bounded memory.

    The percentiles of the compute time are those of `palpate.session.samples.Samples`.
    """

    SIGNALS = tuple(
        dict.fromkeys(  # each once
            [
                *(
                    "t",
                    "F_H_L",
                    "contacts",
                    "F_touch_W",
                    "status",
                    "depth",
                    "energy_port",
                    "energy_lent",
                    "v_LH",
                    "cycle_us",
                ),
                *Withheld.SIGNALS,
                *Lags.SIGNALS,
            ]
        )
    )
    """Signals that the ticks must have."""

    def __init__(self, rate: float) -> None:
        self._dt = 1.0 / rate
        self._withheld, self._lags = Withheld(self._dt), Lags()
        self._held = SustainedPeak(self._dt)
        self._first, self._last = np.inf, -np.inf  # times of the first and of the newest tick [s]
        self._ticks = self._touching = self._capped = self._passivity = self._fast = 0
        self._peak = self._sum = self._depth = self._energy = self._lowest = self._lent = self._speed = 0.0
        self._cycle_us = Samples()
        self._waiting: list[bytes] = []  # ticks not counted yet, as bytes: numpy copies structures slowly

    def add(self, ticks: Ticks) -> None:
        """Add further ticks (n,), in order of time."""
        if not len(ticks):
            return
        if len(ticks) >= _TOGETHER:
            self._count_waiting()
            self._count(ticks)
            return
        self._dtype = ticks.dtype
        self._waiting.append(ticks.tobytes())
        if sum(map(len, self._waiting)) >= _TOGETHER * ticks.dtype.itemsize:
            self._count_waiting()

    def _count_waiting(self) -> None:
        if self._waiting:
            waiting, self._waiting = b"".join(self._waiting), []
            self._count(np.frombuffer(waiting, self._dtype))

    def _count(self, ticks: Ticks) -> None:
        force = np.linalg.norm(ticks["F_H_L"], axis=1)
        touching = (ticks["contacts"] > 0) | ticks["F_touch_W"].any(axis=1)
        for some in np.split(np.where(touching, force, 0.0), range(-self._ticks % _TOGETHER, len(ticks), _TOGETHER)):
            self._sum += float(some.sum())  # by hundreds of the run: the result does not depend on the blocks
        self._ticks += len(ticks)
        self._first, self._last = min(self._first, float(ticks["t"][0])), float(ticks["t"][-1])
        self._touching += int(touching.sum())
        status = ticks["status"].astype(np.int64)
        self._capped += int(((status & _CAPPED) != 0).sum())
        self._passivity += int(((status & _PASSIVITY) != 0).sum())
        self._fast += int(((status & _FAST) != 0).sum())
        self._peak = max(self._peak, float(force.max()))
        self._held.add(force)
        self._depth = max(self._depth, float(ticks["depth"].max()))
        self._energy = float(ticks["energy_port"][-1])
        self._lent = max(self._lent, float(ticks["energy_lent"].max()))
        self._lowest = min(self._lowest, float(ticks["energy_port"].min()))
        self._speed = max(self._speed, float(np.linalg.norm(ticks["v_LH"], axis=1).max()))
        self._withheld.add(ticks)
        self._lags.add(ticks)
        self._cycle_us.add(ticks["cycle_us"])

    @property
    def ticks(self) -> int:
        """Number of ticks added."""
        self._count_waiting()
        return self._ticks

    def summary(self, timing: Mapping[str, Any] | None = None, **known: Any) -> Summary:
        """The summary of all ticks so far.

        Args:
            timing: result of `Simulation.timing()`, for missed ticks.
            known: fields of `Summary` that the ticks do not contain: realtime, faults, record, ...
        """
        self._count_waiting()
        us = self._cycle_us.values if len(self._cycle_us.values) else np.zeros(1)
        rank = np.array([0.5, 0.99, 0.999]) * (len(us) - 1)  # np.percentile would import numpy.ma
        p50, p99, p999 = np.interp(rank, np.arange(len(us)), np.sort(us)).tolist()
        summary = Summary(
            duration_s=round(max(self._ticks * self._dt, self._last - self._first + self._dt), 9),
            ticks=self._ticks,
            realtime=False,
            realtime_factor=0.0,
            interrupted=False,
            peak_force_N=self._peak,
            peak_50ms_N=self._held.value,
            mean_force_N=self._sum / self._touching if self._touching else 0.0,
            max_penetration_m=self._depth,
            contact_s=round(self._touching * self._dt, 9),
            capped_s=round(self._capped * self._dt, 9),
            passivity_s=round(self._passivity * self._dt, 9),
            withheld=self._withheld.figures(),
            lag_ms=self._lags.figures(),
            shift_m=self._withheld.shift,
            peak_speed_m_s=self._speed,
            fast_s=round(self._fast * self._dt, 9),
            energy_J=self._energy,
            energy_min_J=self._lowest,
            energy_lent_J=self._lent,
            cycle_p50_us=p50,
            cycle_p99_us=p99,
            cycle_p999_us=p999,
            cycle_max_us=self._cycle_us.largest,
            missed_ticks=int((timing or {}).get("missed_ticks", 0)),
            scheduler=str((timing or {}).get("scheduler", "")) if known.get("realtime") else "",
        )
        return replace(summary, **known)


def summarise(ticks: Ticks, rate: float, **known: Any) -> Summary:
    """The summary of recorded ticks (n,) at `rate` [Hz]; `known` as in `Totals.summary`."""
    totals = Totals(rate)
    totals.add(ticks)
    return totals.summary(**known)
