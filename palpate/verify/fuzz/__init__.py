"""``palpate fuzz``: random input, the same for the same seed, against what must hold whatever comes in."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from importlib import import_module
from typing import Any, TypedDict

#: What can be fuzzed: a file here with ``case(seed)``, which returns counts and raises ``FaultError``.
TARGETS = ("contact", "files")
PATIENCE = 20.0
"""A case that takes longer than this hangs [s]."""


class FaultError(Exception):
    """Something that must never happen did."""


class Fault(TypedDict):
    """A case that went wrong."""

    seed: int
    what: str


@dataclass
class Outcome:
    """What a campaign came to. The keys are the documented contract of ``--json``."""

    target: str
    runs: int  #: cases done
    seed: int  #: of the first case; the others follow one by one
    faults: list[Fault] = field(default_factory=list)  #: ``seed`` and ``what``
    counts: dict[str, int] = field(default_factory=dict)  #: what the cases were made of
    seconds: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """As plain JSON values."""
        return asdict(self)


def run(target: str, runs: int, seed: int = 0, on_progress: Callable[[Outcome], None] | None = None) -> Outcome:
    """Cases ``seed`` to ``seed + runs - 1`` in a process of their own: crashes and endless loops are faults as well.

    Args:
        target: one of ``TARGETS``, or a module of one's own with ``case(seed)``.
        runs: how many cases; gives up after twenty faults.
        seed: of the first.
        on_progress: hears of each case.
    """
    outcome, start = Outcome(target, 0, seed), time.monotonic()
    while outcome.runs < runs and len(outcome.faults) < 20:
        _campaign(outcome, seed + outcome.runs, seed + runs, on_progress)
        outcome.seconds = time.monotonic() - start
    return outcome


def _campaign(outcome: Outcome, first: int, end: int, on_progress: Callable[[Outcome], None] | None) -> None:
    """Until all is done, or the process died or hung and the next one must go on after that case."""
    spawn = multiprocessing.get_context("spawn")
    receive, send = spawn.Pipe(duplex=False)
    process = spawn.Process(target=_work, args=(outcome.target, first, end, send), daemon=True)
    process.start()
    send.close()
    try:
        while True:
            if not receive.poll(PATIENCE + 60.0 * (outcome.runs == first - outcome.seed)):  # imports may take long
                return _lost(outcome, f"endless: no answer within {PATIENCE:g} s")
            try:
                done, counts, fault = receive.recv()
            except EOFError:
                process.join()
                if outcome.runs < end - outcome.seed:
                    _lost(outcome, f"the process died with exit code {process.exitcode}")
                return None
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
        except Exception as error:  # whatever else is raised is a fault, too
            fault = f"{type(error).__name__}: {error}"
        send.send((seed, counts, fault))
    send.close()
