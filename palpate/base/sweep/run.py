"""The function that runs every sweep."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import closing, nullcontext
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, Literal, TypeAlias

from rich.console import Console
from threadpoolctl import threadpool_limits

from palpate.base.errors import SweepError
from palpate.base.sweep import local
from palpate.base.sweep.grid import Axis, Grid, Point
from palpate.base.sweep.journal import Fingerprint, Journal, name_of
from palpate.base.sweep.progress import Bar
from palpate.base.sweep.result import Label, Swept
from palpate.base.sweep.work import Function, PointResult, Work, identity, seed_of

Executed: TypeAlias = Callable[[Work, list[int]], Generator[list[PointResult], None, None]]
"""Evaluates the points with these indices and yields batches of answers in order of completion."""
FAILURES = 20
"""Number of failed points after which a sweep stops, because the fault is probably in the function."""
MAX_LISTED = 5
"""Number of failed points that an error message lists."""


def sweep(
    fn: Function,
    grid: Mapping[str, Axis | Iterable[Any]],
    seed: int = 0,
    executor: Literal["local", "dask", "serial"] = "local",
    *,
    workers: int | None = None,
    address: str | None = None,
    resume: Path | str | None = None,
    where: Callable[[Point], bool] | None = None,
    labels: Mapping[str, Label] | None = None,
    on_error: Literal["raise", "keep"] = "raise",
    console: Console | None = None,
    title: str = "",
) -> Swept:
    """Call ``fn(point, seed)`` at every point of a grid. All executors return bit-identical results.

    The seed of a point depends only on ``seed`` and the index of the point (numpy's ``SeedSequence``). The points of a
    killed worker are computed again.

    Args:
        fn: maps ``{axis: value}`` and a seed below 2^63 to a dictionary or dataclass of numbers, texts and lists. The
            workers import it from the top level of a module. Its result must depend only on its arguments.
        grid: values by axis; the points are the product of the axes, and the last axis varies fastest.
        seed: seed of the whole sweep.
        executor: ``local`` (processes of this machine), ``dask`` (a Dask cluster) or ``serial`` (the calling process).
        workers: number of processes; default: one per core. On an existing cluster all its workers are used.
        address: existing Dask scheduler, e.g. ``tcp://node7:8786``; default: start a local cluster.
        resume: journal file; created if missing, otherwise the sweep continues from it.
        where: points for which this function is false are left out and are blank in the result.
        labels: unit and description of the values that ``fn`` returns.
        on_error: ``keep`` leaves failed points blank and stores their errors in ``Swept.errors``.
        console: console for the progress; default: a bar if the standard error is a terminal.
        title: title of the bar; default: the name of the function.

    Raises:
        SweepError: points failed (the journal contains all others), or the workers cannot run.
        JournalError: the journal belongs to another sweep, or the file is not a journal.
        MissingExtraError: ``dask`` without the extra ``palpate[dask]``.
    """
    work = Work(fn, Grid.of(grid), seed, identity())
    indices = work.grid.points(where)
    executed = _executor(executor, workers, address)
    journal = Journal(Path(resume), Fingerprint.of(work, indices)) if resume else None
    with journal or nullcontext(), Bar(console, title or name_of(fn), len(indices)) as bar:
        found = _compute(work, indices, executed, journal, bar, FAILURES if on_error == "raise" else None)
    swept = _collect(work, indices, found, labels or {})
    if swept.errors and on_error == "raise":
        raise _failure(work, swept.errors, len(indices) - len(found), resume)
    return swept


def _compute(
    work: Work, indices: list[int], executed: Executed, journal: Journal | None, bar: Bar, most: int | None
) -> dict[int, PointResult]:
    """Answers by the index of the point, those of the journal included; incomplete after ``most`` failed points."""
    found = dict(journal.done) if journal else {}
    bar.advance(len(found), taken_up=True)
    failed = 0
    with closing(executed(work, [index for index in indices if index not in found])) as answers:
        for some in answers:
            found.update((answer.point, answer) for answer in some)
            if journal:
                journal.keep(some)
            bar.advance(len(some))
            failed += sum(answer.values is None for answer in some)
            if most is not None and failed >= most:
                break
    return found


def _collect(work: Work, indices: list[int], found: dict[int, PointResult], labels: Mapping[str, Label]) -> Swept:
    answers = {index: found[index] for index in indices if index in found}
    values = {index: answer.values for index, answer in answers.items() if answer.values is not None}
    errors = {index: answer.error for index, answer in answers.items() if answer.values is None}
    attributes: dict[str, str | int] = {
        "fn": name_of(work.fn),
        "seed": work.seed,
        "version": f"palpate {work.version}",
    }
    return Swept(work.grid, values, attributes, dict(labels), errors)


def _executor(name: str, workers: int | None, address: str | None) -> Executed:
    if address and name != "dask":
        what = f"address {address} does not apply to executor {name!r}"
        raise SweepError(what, mend="use executor='dask' (--executor dask)")
    if workers is not None and workers < 1:
        raise SweepError(f"workers must be at least 1, got {workers}")
    if name == "serial":
        return _serial
    if multiprocessing.parent_process() or getattr(multiprocessing.current_process(), "_inheriting", False):
        why = "this process is itself a worker; importing fn from a script without a guard runs the whole script"
        raise SweepError("sweep() was called inside a worker process", why=why, mend=local.MEND)
    if name == "local":
        return partial(local.run, workers=workers)
    if name == "dask":
        from palpate.base.sweep import cluster

        return partial(cluster.run, workers=workers, address=address)
    raise SweepError(f"unknown executor {name!r}", mend="use local, dask or serial")


def _serial(work: Work, todo: list[int]) -> Generator[list[PointResult], None, None]:
    with threadpool_limits(1):
        for answer in work.answers(todo):
            yield [answer]


def _failure(work: Work, errors: dict[int, str], left: int, resume: Path | str | None) -> SweepError:
    listed = [
        f"at {', '.join(f'{name} = {value}' for name, value in work.grid.point(index).items())} "
        f"(seed {seed_of(work.seed, index)}): {error}"
        for index, error in islice(errors.items(), MAX_LISTED)
    ]
    more = [f"and {len(errors) - MAX_LISTED} more"] if len(errors) > MAX_LISTED else []
    undone = f", {left} not tried" if left else ""
    return SweepError(
        f"{len(errors)} of {len(work.grid)} points failed{undone}",
        where=name_of(work.fn),
        why="\n    ".join([*listed, *more]),
        mend=f"the successful points are kept in {resume}" if resume else "",
    )
