"""A campaign of many cases on all cores, with a journal from which it continues."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path

from palpate import __version__
from palpate.base.arrays.plain import Content
from palpate.base.errors import OutputError
from palpate_lab.verify.fuzz import MOST_FAULTS, Outcome, run

_BLOCKS, _LEAST = 64, 100  # blocks of a campaign, and least number of cases in a block


def run_on_cores(
    target: str,
    runs: int,
    seed: int = 0,
    on_progress: Callable[[Outcome], None] | None = None,
    most: int = MOST_FAULTS,
    workers: int | None = None,
    journal: Path | None = None,
) -> Outcome:
    """Run the cases as `fuzz.run` does, in blocks on several processes; the outcome does not depend on their number.

    Args:
        target, runs, seed, most: as for `fuzz.run`.
        on_progress: called after each block, with the sum of the finished ones.
        workers: number of processes; one per core when left out.
        journal: file of the finished blocks. If it exists, their results are taken from it.

    Raises:
        OutputError: the journal is of another campaign, or cannot be written.
    """
    start, size = time.monotonic(), max(_LEAST, -(-runs // _BLOCKS))
    head = {"target": target, "runs": runs, "seed": seed, "most": most, "version": __version__}
    done = {} if journal is None else _opened(journal, head)
    firsts = [first for first in range(seed, seed + runs, size) if first not in done]
    before = sum(block.seconds for block in done.values())
    with ThreadPoolExecutor(workers or os.cpu_count()) as pool:
        waiting = {
            pool.submit(run, target, min(size, seed + runs - first), first, None, most): first for first in firsts
        }
        for future in as_completed(waiting):
            done[waiting[future]] = block = future.result()
            if journal is not None:
                _append(journal, asdict(block))
            total, ended = _sum(head, done, most)
            if on_progress is not None:
                on_progress(total)
            if ended:
                for other in waiting:
                    other.cancel()
                break
    total, _ = _sum(head, done, most)
    total.seconds = before + time.monotonic() - start
    return total


def _sum(head: Content, done: dict[int, Outcome], most: int) -> tuple[Outcome, bool]:
    """The sum of the finished blocks up to the one with fault number `most`, and whether that one is certain."""
    total, ended, expected = Outcome(head["target"], 0, head["seed"]), False, head["seed"]
    for first in sorted(done):
        block = done[first]
        total.add(block.counts, block.faults)
        total.runs += block.runs
        ended = first == expected and len(total.faults) >= most
        expected = first + block.runs
        if ended:
            break
    return total, ended


def _opened(journal: Path, head: Content) -> dict[int, Outcome]:
    """The blocks of a journal by their first seed; a new journal with its head."""
    if not journal.exists():
        _append(journal, head)
        return {}
    lines = journal.read_text().splitlines(keepends=True)
    if lines and not lines[-1].endswith("\n"):  # the process was killed while it wrote
        journal.write_text("".join(lines[:-1]))
        lines = lines[:-1]
    try:
        rows = [json.loads(line) for line in lines]
    except ValueError as error:
        what = f"{journal} is no journal of palpate fuzz"
        raise OutputError(what, why=str(error), mend="name another file") from None
    if not rows or rows[0] != head:
        what = f"{journal} is the journal of another campaign"
        mend = "name another file, or remove this one"
        raise OutputError(what, why=f"{rows[0] if rows else 'empty'}; expected {head}", mend=mend)
    return {row["seed"]: Outcome(**row) for row in rows[1:]}


def _append(journal: Path, row: Content) -> None:
    try:
        with journal.open("a") as file:
            file.write(json.dumps(row) + "\n")
    except OSError as error:
        raise OutputError(f"{journal} cannot be written", why=str(error), mend="name another file") from None
