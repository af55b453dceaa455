"""``palpate fuzz``: checks of invariants with random input that is reproducible from a seed."""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, TypedDict

from palpate.base.arrays.plain import Content

#: Targets: modules of this package with ``case(seed)``, which returns counts and raises ``FaultError``.
TARGETS = (
    *("contact", "datagrams", "files", "grids", "haply", "loops", "models", "packets", "ports", "records", "scenes"),
    "tables",
)
MOST_FAULTS = 20
"""Number of faults after which a campaign stops."""
TIMEOUT = 60.0
"""Time after which a case counts as an endless loop, if it is again as late in a process of its own [s]."""
_PATIENCE = 10  # times that a process is waited for which had no processor for most of that time


class FaultError(Exception):
    """An invariant is violated.

    Args:
        what: description.
        counts: counts of the case, as `case` returns them.
        details: values that describe the fault.
    """

    def __init__(self, what: str, counts: dict[str, int] | None = None, details: Content | None = None) -> None:
        super().__init__(what)
        self.counts, self.details = counts or {}, details or {}


class Fault(TypedDict):
    """A failed case."""

    seed: int
    what: str  #: description
    details: Content  #: values that describe the fault


@dataclass
class Outcome:
    """Result of a campaign. The keys are the documented contract of ``--json``."""

    target: str
    runs: int  #: number of finished cases
    seed: int  #: seed of the first case; each further case increments it
    faults: list[Fault] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)  #: number of cases by property
    seconds: float = 0.0

    def add(self, counts: dict[str, int], faults: list[Fault]) -> None:
        """Add the counts and faults of further cases."""
        for name, n in counts.items():
            self.counts[name] = self.counts.get(name, 0) + n
        self.faults += faults


def run(
    target: str,
    runs: int,
    seed: int = 0,
    on_progress: Callable[[Outcome], None] | None = None,
    most: int = MOST_FAULTS,
) -> Outcome:
    """Run the cases ``seed`` to ``seed + runs - 1`` in a separate process; crashes and endless loops are faults.

    Args:
        target: one of ``TARGETS``, or the name of another module with ``case(seed)``; after a colon the argument `kind`
            of its cases.
        runs: number of cases.
        seed: seed of the first case.
        on_progress: called after each case.
        most: number of faults after which the campaign stops.
    """
    outcome, start, late = Outcome(target, 0, seed), time.monotonic(), None
    while outcome.runs < runs and len(outcome.faults) < most:
        if _campaign(outcome, seed + outcome.runs, seed + runs, on_progress):
            if late != outcome.runs:
                late = outcome.runs  # the machine may have been busy: this case runs once more
            else:
                _lost(outcome, f"endless: no answer within {TIMEOUT:g} s, twice")
        outcome.seconds = time.monotonic() - start
    return outcome


def _campaign(outcome: Outcome, first: int, end: int, on_progress: Callable[[Outcome], None] | None) -> bool:
    """Run cases in one process until all are done or the process dies; True if it gave no answer in time."""
    spawn = multiprocessing.get_context("spawn")
    receive, send = spawn.Pipe(duplex=False)
    process = spawn.Process(target=_work, args=(outcome.target, first, end, send), daemon=True)
    process.start()
    send.close()
    try:
        while True:
            spent, waited = _processor_time(process), 0
            while not receive.poll(TIMEOUT + 60.0 * (outcome.runs == first - outcome.seed)):  # imports may take long
                waited += 1
                if _processor_time(process) - spent > 0.5 * TIMEOUT or waited == _PATIENCE:
                    return True
            try:
                done, counts, fault = receive.recv()
            except EOFError:
                process.join()
                if outcome.runs < end - outcome.seed:
                    _lost(outcome, f"the process died with exit code {process.exitcode}")
                return False
            outcome.runs = done + 1 - outcome.seed
            outcome.add(counts, [fault] if fault else [])
            if on_progress:
                on_progress(outcome)
    finally:
        process.kill()
        process.join()


def _processor_time(process: Any) -> float:
    """Processor time of a process so far; infinity where the system does not tell it [s]."""
    try:
        fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except OSError:
        return float("inf")


def _lost(outcome: Outcome, what: str) -> None:
    outcome.faults.append({"seed": outcome.seed + outcome.runs, "what": what, "details": {}})
    outcome.runs += 1


def _work(target: str, first: int, end: int, send: Any) -> None:
    name, _, kind = target.partition(":")
    case: Callable[..., dict[str, int]] = import_module(
        f"palpate_lab.verify.fuzz.{name}" if name in TARGETS else name
    ).case
    if kind:
        case = partial(case, kind=kind)
    for seed in range(first, end):
        fault, counts = None, {}
        try:
            counts = case(seed)
        except FaultError as error:
            counts, fault = error.counts, Fault(seed=seed, what=str(error), details=error.details)
        except Exception as error:  # any other exception is also a fault
            fault = Fault(seed=seed, what=f"{type(error).__name__}: {error}", details={})
        send.send((seed, counts, fault))
    send.close()
