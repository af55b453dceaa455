"""Reports about the force: each cause is told at once, and its repetitions are counted and told together."""

from __future__ import annotations

import threading
from dataclasses import dataclass

import numpy as np

from palpate.record.ticks import STATUS, Ticks
from palpate.session.faults import NO_FAULTS

WINDOW = 60.0
"""Interval of the reports of a cause that repeats [s]."""
LASTING = 0.5
"""Duration of a fault that is reported even if its cause was reported within the window [s]."""
PAUSE = 2.0
"""Interval of the reports of lasting faults of one cause [s]."""
CALM = 1.0
"""Time without any condition after which the force is reported as free [s]."""
_GATES = ("not_enabled", "no_operator", "not_following", "clutched")  # states of operation, changed by people
_SETTLING = STATUS["settling"][0]


@dataclass
class _Cause:
    bit: int
    words: str
    new: int = 0  # occurrences that are not yet reported
    since: float | None = None  # begin of the present occurrence [s]
    quiet_until: float = -np.inf  # no report before this time [s]
    lasting_after: float = -np.inf  # no report of a lasting fault before this time [s]


class ForceReports:
    """Turns the status of all ticks into few sentences; ticks come from one thread, questions from another."""

    def __init__(self) -> None:
        ordinary = NO_FAULTS | {*_GATES, "settling"}
        self._causes = [_Cause(bit, words) for name, (bit, words) in STATUS.items() if name not in ordinary]
        self._any = sum(cause.bit for cause in self._causes) | sum(STATUS[gate][0] for gate in _GATES) | _SETTLING
        self._gates: list[str] = []
        self._told_gates: list[str] | None = None
        self._held_at = -np.inf  # last tick whose force was held back [s]
        self._t = 0.0
        self._told_free = True
        self._last = 0
        self._lock = threading.Lock()

    def take(self, ticks: Ticks) -> None:
        """Count the occurrences of each cause in new ticks."""
        if not len(ticks):
            return
        status, t = ticks["status"].astype(np.int64), ticks["t"]
        before = np.append(self._last, status[:-1])
        with self._lock:
            for cause in self._causes:
                begins = np.flatnonzero(status & ~before & cause.bit)
                cause.new += len(begins)
                if len(begins):
                    cause.since = float(t[begins[-1]])
                if not status[-1] & cause.bit:
                    cause.since = None
            held = np.flatnonzero(status & self._any)
            if len(held):
                self._held_at = float(t[held[-1]])
            self._gates = [STATUS[gate][1] for gate in _GATES if status[-1] & STATUS[gate][0]]
            self._last, self._t = int(status[-1]), float(t[-1])

    def sentences(self) -> list[str]:
        """What is new since the last call, by the clock of the ticks."""
        with self._lock:
            out = [words for cause in self._causes if (words := self._about(cause))]
            if self._gates != self._told_gates:
                out += self._gates
                self._told_free = self._told_free and not self._gates
                self._told_gates = self._gates
            if out:
                self._told_free = False
            elif not self._told_free and self._t - self._held_at >= CALM:
                self._told_free = True
                out = ["free to push"]
            return out

    def _about(self, cause: _Cause) -> str:
        t = self._t
        lasts = cause.since is not None and t - cause.since >= LASTING and t >= cause.lasting_after
        if not (cause.new and (t >= cause.quiet_until or lasts)):
            return ""
        repeated = f" ({cause.new} times in the last {WINDOW:g} s)" if cause.new > 1 else ""
        cause.new, cause.quiet_until, cause.lasting_after = 0, t + WINDOW, t + PAUSE
        return cause.words + repeated
