"""``palpate fuzz``: checks of invariants with random input that is reproducible from a seed."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, TypedDict

from palpate.renamed import RenamedMethod

#: Targets: modules of this package with ``case(seed)``, which returns counts and raises ``FaultError``.
TARGETS = ("contact", "files", "grids", "models", "packets", "records", "scenes", "tables")
TIMEOUT = 20.0
"""Time after which a case counts as an endless loop, if it is again as late in a process of its own [s]."""


class FaultError(Exception):
    """An invariant is violated."""


class Fault(TypedDict):
    """Seed and description of a failed case."""

    seed: int
    what: str


@dataclass
class Outcome:
    """Result of a campaign. The keys are the documented contract of ``--json``."""

    target: str
    runs: int  #: number of finished cases
    seed: int  #: seed of the first case; each further case increments it
    faults: list[Fault] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)  #: number of cases by property
    seconds: float = 0.0

    to_json = RenamedMethod("palpate.arrays.plain.plain(outcome)")


def run(target: str, runs: int, seed: int = 0, on_progress: Callable[[Outcome], None] | None = None) -> Outcome:
    """Run the cases ``seed`` to ``seed + runs - 1`` in a separate process; crashes and endless loops are faults.

    Args:
        target: one of ``TARGETS``, or the name of another module with ``case(seed)``.
        runs: number of cases; the campaign stops after twenty faults.
        seed: seed of the first case.
        on_progress: called after each case.
    """
    outcome, start, late = Outcome(target, 0, seed), time.monotonic(), None
    while outcome.runs < runs and len(outcome.faults) < 20:
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
            if not receive.poll(TIMEOUT + 60.0 * (outcome.runs == first - outcome.seed)):  # imports may take long
                return True
            try:
                done, counts, fault = receive.recv()
            except EOFError:
                process.join()
                if outcome.runs < end - outcome.seed:
                    _lost(outcome, f"the process died with exit code {process.exitcode}")
                return False
            outcome.runs = done + 1 - outcome.seed
            for name, n in counts.items():
                outcome.counts[name] = outcome.counts.get(name, 0) + n
            if fault:
                outcome.faults.append({"seed": done, "what": fault})
            if on_progress:
                on_progress(outcome)
    finally:
        process.kill()
        process.join()


def _lost(outcome: Outcome, what: str) -> None:
    outcome.faults.append({"seed": outcome.seed + outcome.runs, "what": what})
    outcome.runs += 1


def _work(target: str, first: int, end: int, send: Any) -> None:
    module = f"palpate.verify.fuzz.{target}" if target in TARGETS else target
    case: Callable[[int], dict[str, int]] = import_module(module).case
    for seed in range(first, end):
        fault, counts = "", {}
        try:
            counts = case(seed)
        except FaultError as error:
            fault = str(error)
        except Exception as error:  # any other exception is also a fault
            fault = f"{type(error).__name__}: {error}"
        send.send((seed, counts, fault))
    send.close()
