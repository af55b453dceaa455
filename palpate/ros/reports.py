"""Reports about the force: each cause is told at once with its value, and what withholds a force for half a second.

A cause is told at the begin of each of its episodes. A source that flickers is counted after a few of them, and its
repetitions are told once a minute.
"""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from palpate.record import withheld
from palpate.record.ticks import STATUS, Ticks
from palpate.ros import causes
from palpate.session.faults import NO_FAULTS

WINDOW = 60.0
"""Interval of the reports of a cause that repeats [s]."""
SEVERAL = 4
"""Number of reports of a cause within `WINDOW`, after which its repetitions are counted."""
LASTING = withheld.LASTING
"""Duration of a fault that is reported even if its repetitions are counted [s]."""
PAUSE = 2.0
"""Interval of the reports of lasting faults of one cause [s]."""
CALM = 1.0
"""Time without any condition after which an episode ends, and the force is reported as free [s]."""
TAKE_BACK = "tap the clutch pedal, or call the service ~/take_back; clutching chooses a new relation"
_GATES = ("not_enabled", "no_operator", "not_following", "clutched")  # states of operation, changed by people
_SETTLING = STATUS["settling"][0]
_UNPOWERED = {"bad_stamp": STATUS["not_enabled"][0]}
"""Causes that are the ordinary reports of an arm without power, while this bit is set: it marks its data as invalid."""


@dataclass
class _Cause:
    name: str
    bit: int
    words: str = ""  # of the newest episode, with its value
    now: str = ""  # of the present occurrence
    new: int = 0  # episodes that are not yet reported
    since: float | None = None  # begin of the present occurrence [s]
    told_at: float = -np.inf  # time of the last report [s]
    last: float = -np.inf  # last tick with the bit [s]
    told: deque[float] = field(default_factory=lambda: deque(maxlen=SEVERAL))  # times of the last reports [s]
    lasting_after: float = -np.inf  # no report of a lasting fault before this time [s]


class ForceReports:
    """Turns the ticks into few sentences; ticks come from one thread, questions from another."""

    def __init__(self) -> None:
        ordinary = NO_FAULTS | {*_GATES, "settling"}
        self._causes = [_Cause(name, bit) for name, (bit, _) in STATUS.items() if name not in ordinary]
        self._any = sum(cause.bit for cause in self._causes) | sum(STATUS[gate][0] for gate in _GATES) | _SETTLING
        self._gates: list[str] = []
        self._told_gates: list[str] | None = None
        self._held_at = -np.inf  # last tick whose force was held back [s]
        self._t = 0.0
        self._told_free = True
        self._last = 0
        self._less: dict[str, float] = {}  # what withholds a force: begin [s]
        self._less_words, self._told_less = "", frozenset[str]()
        self._shift, self._told_shift = np.zeros(3), 0.0
        self._lock = threading.Lock()

    def take(self, ticks: Ticks) -> None:
        """Count the occurrences of each cause in new ticks."""
        if not len(ticks):
            return
        status, t = ticks["status"].astype(np.int64), ticks["t"]
        before = np.append(self._last, status[:-1])
        with self._lock:
            for cause in self._causes:
                ordinary = _UNPOWERED.get(cause.name, 0)
                powered, was = np.where(status & ordinary, 0, status), np.where(before & ordinary, 0, before)
                self._occur(cause, np.flatnonzero(powered & ~was & cause.bit), powered, ticks)
            held = np.flatnonzero(status & self._any)
            if len(held):
                self._held_at = float(t[held[-1]])
            self._gates = [STATUS[gate][1] for gate in _GATES if status[-1] & STATUS[gate][0]]
            self._last, self._t = int(status[-1]), float(t[-1])
            self._weigh(ticks)

    def sentences(self) -> list[str]:
        """What is new since the last call, by the clock of the ticks."""
        with self._lock:
            out = [words for cause in self._causes if (words := self._about(cause))]
            if self._gates != self._told_gates:
                out += self._gates
                self._told_free = self._told_free and not self._gates
                self._told_gates = self._gates
            out += [words for words in (self._about_less(), self._about_shift()) if words]
            if out:
                self._told_free = False
            elif not self._told_free and self._t - self._held_at >= CALM:
                self._told_free = True
                out = ["free to push"]
            return out

    def _occur(self, cause: _Cause, begins: np.ndarray, status: np.ndarray, ticks: Ticks) -> None:
        t = ticks["t"]
        if len(begins):
            first = float(t[begins[0]])
            if first - cause.last >= CALM:
                cause.new += 1
                cause.words = _words(cause, ticks[begins[0]])
            cause.since, cause.now = float(t[begins[-1]]), _words(cause, ticks[begins[-1]])
        if not status[-1] & cause.bit:
            cause.since = None
        present = np.flatnonzero(status & cause.bit)
        if len(present):
            cause.last = float(t[present[-1]])

    def _weigh(self, ticks: Ticks) -> None:
        """Find the elements that withhold a force, and since when."""
        asked, F = np.nan_to_num(ticks["F_asked"]).mean(axis=0), np.nan_to_num(ticks["F_withheld"]).mean(axis=0)
        found = withheld.parts(F, float(asked[0]))
        self._less = {name: self._less.get(name, float(ticks["t"][0])) for name in found}
        lasting = [name for name, since in self._less.items() if self._t - since >= LASTING]
        self._less_words = withheld.sentence(asked, F, self._last) if lasting else ""
        if lasting:
            self._held_at = self._t
        self._shift = np.nan_to_num(ticks["p_shift_W"][-1])

    def _about_less(self) -> str:
        lasting = frozenset(name for name, since in self._less.items() if self._t - since >= LASTING)
        new = lasting - self._told_less
        self._told_less = lasting
        return self._less_words if new else ""

    def _about_shift(self) -> str:
        size = float(np.linalg.norm(self._shift))
        if abs(size - self._told_shift) < withheld.SHIFT:
            return ""
        before, self._told_shift = self._told_shift, size
        if size < withheld.SHIFT:
            return "the tool is where the hand was at the start again: no shift is left"
        return withheld.shift_sentence(self._shift, TAKE_BACK) if size > before else ""

    def _about(self, cause: _Cause) -> str:
        t = self._t
        lasts = cause.since is not None and t - cause.since >= LASTING and t >= cause.lasting_after
        crowded = len(cause.told) == SEVERAL and t < cause.told[0] + WINDOW
        stays = lasts and cause.since is not None and cause.told_at < cause.since  # also without a new episode
        if not stays and (not cause.new or (crowded and not lasts)):
            return ""
        words = cause.words if cause.new else cause.now
        repeated = f" ({cause.new} times in the last {WINDOW:g} s)" if cause.new > 1 else ""
        cause.new, cause.lasting_after, cause.told_at = 0, t + PAUSE, t
        cause.told.extend([t] * (SEVERAL if crowded or len(cause.told) == SEVERAL else 1))
        return words + repeated


def _words(cause: _Cause, tick: Ticks) -> str:
    number, value, other = (float(x) for x in tick["cause"])
    known = number > 0.0 and 1 << int(number) == cause.bit
    return causes.sentence(cause.name, value if known else float("nan"), other)
