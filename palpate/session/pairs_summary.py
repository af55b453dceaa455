"""Summary of a run of several pairs: that of each pair, and how their instruments and handles met."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays.peaks import SustainedPeak
from palpate.record.ticks import Ticks
from palpate.session.summary import Summary


@dataclass(frozen=True)
class MeetingSummary:
    """How the instruments and the handles of different pairs met."""

    closest_m: float | None  # smallest distance between two instruments, negative in contact; None: unknown
    contact_s: float  # time in contact
    peak_force_N: float  # maximum force on an instrument, by other instruments and by rigid bodies
    peak_50ms_N: float  # the same without noise and single ticks: largest mean over 50 ms
    impulse_N_s: float  # integral of the force on each instrument, added over the instruments
    momentum_error_N_s: float | None  # of the sum of all impulses: zero in lockstep; None: bodies take their part
    handles_closest_m: float | None  # smallest distance between two handles; None: unknown
    handles_close_s: float  # time in which two handles were closer than instruments.handle_distance


@dataclass(frozen=True)
class PairsSummary:
    """Results of a run of several pairs; docs/json.md describes every field."""

    pairs: dict[str, Summary]
    instruments: MeetingSummary
    duration_s: float
    realtime: bool
    realtime_factor: float
    interrupted: bool
    missed_ticks: int  # of all pairs
    faults: tuple[str, ...] = ()  # of all pairs, each with the name of its pair
    record: str | None = None  # folder with one record per pair
    report: str | None = None

    @classmethod
    def of(cls, pairs: dict[str, Summary], instruments: MeetingSummary, record: str | None) -> PairsSummary:
        """The summary of all pairs."""
        each = list(pairs.values())
        return cls(
            pairs=pairs,
            instruments=instruments,
            duration_s=max(one.duration_s for one in each),
            realtime=each[0].realtime,
            realtime_factor=min(one.realtime_factor for one in each),
            interrupted=any(one.interrupted for one in each),
            missed_ticks=sum(one.missed_ticks for one in each),
            faults=tuple(f"{name}: {fault}" for name, one in pairs.items() for fault in one.faults),
            record=record,
        )


class Met:
    """Accumulates how the instrument and the handle of one pair met those of the others.

    Args:
        rate: ticks per second [Hz].
        handle_distance: distance of two handles below which they are close [m].
    """

    def __init__(self, rate: float, handle_distance: float) -> None:
        self._dt, self._near = 1.0 / rate, handle_distance
        self.closest = self.handles_closest = np.inf  #: [m]
        self.contact_s = self.handles_close_s = 0.0
        self.peak = self.impulse = 0.0  #: of the force [N], of its magnitude over time [N s]
        self.held = SustainedPeak(self._dt)
        self.momentum = np.zeros(3)  #: integral of the force (3,), in W [N s]

    def add(self, ticks: Ticks) -> None:
        """Add further ticks (n,)."""
        if not len(ticks):
            return
        sizes = np.linalg.norm(ticks["F_instrument_W"], axis=1)
        self.closest = min(self.closest, float(ticks["instrument_gap"].min()))
        self.handles_closest = min(self.handles_closest, float(ticks["handle_gap"].min()))
        self.contact_s += self._dt * float((ticks["instrument_gap"] < 0.0).sum())
        self.handles_close_s += self._dt * float((ticks["handle_gap"] < self._near).sum())
        self.peak = max(self.peak, float(sizes.max()))
        self.held.add(sizes)
        self.impulse += self._dt * float(sizes.sum())
        self.momentum += self._dt * ticks["F_instrument_W"].sum(axis=0)


def meeting(met: Sequence[Met], bodies: bool = False) -> MeetingSummary:
    """How all pairs met; `bodies`: rigid bodies push their instruments, too."""
    closest, handles = min(one.closest for one in met), min(one.handles_closest for one in met)
    return MeetingSummary(
        closest_m=closest if np.isfinite(closest) else None,
        contact_s=round(max(one.contact_s for one in met), 9),
        peak_force_N=max(one.peak for one in met),
        peak_50ms_N=max(one.held.value for one in met),
        impulse_N_s=sum(one.impulse for one in met),
        momentum_error_N_s=None if bodies else float(np.linalg.norm(sum(one.momentum for one in met))),
        handles_closest_m=handles if np.isfinite(handles) else None,
        handles_close_s=round(max(one.handles_close_s for one in met), 9),
    )
