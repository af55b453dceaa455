"""Runs a batch on all cores of this machine, or on a Dask cluster."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import partial
from typing import Literal

from threadpoolctl import threadpool_limits

from palpate.base.errors import PalpateError
from palpate.base.sweep import Axis, sweep
from palpate.base.sweep.grid import Point
from palpate.base.sweep.local import cores
from palpate.session.batch.one import BatchOptions, SharedSurfaces, simulate_one
from palpate.session.batch.result import Outcome, Simulated, stack_outcomes
from palpate.session.batch.variation import Runs, Variation, variations


def simulate(
    runs: Runs,
    duration: float | None = None,
    *,
    signals: Sequence[str] = (),
    signal_rate: float = 100.0,
    workers: int | None = None,
    executor: Literal["threads", "local", "dask"] = "threads",
    address: str | None = None,
    on_progress: Callable[[int], None] | None = None,
) -> Simulated:
    """Simulate many runs in lockstep. Each run equals that of a session with the same scene and seed.

    Nothing is recorded on disk. Apart from the keys in ``palpate.session.batch.MEASURED``, the results depend only on
    scenes, overrides and seeds, and not on the order of the runs, the executor or the number of workers.

    Args:
        runs: one or several scenes, paths of scene files or `Variation` objects.
        duration: simulated time of every run [s]; each scene's own when left out. All must be equal if signals are
            requested.
        signals: names of recorded signals to keep (`palpate.record.SIGNALS`), e.g. ``F_T_W``.
        signal_rate: samples per simulated time, each taken from the nearest tick [Hz].
        workers: number of threads or processes; one per core when left out. An existing cluster uses all its workers.
        executor: ``threads`` in this process, ``local`` processes, or a ``dask`` cluster (docs/studies.md).
        address: of an existing Dask scheduler; without one, ``dask`` starts a cluster on this machine.
        on_progress: called with the number of finished runs after each run (``threads`` only).

    Returns:
        Summaries and signals as arrays; their first axis is the run.

    Raises:
        SceneError, MeshError: a run cannot be set up; the message names the run.
        PalpateError: no runs, an unknown signal, different durations, or fewer than one worker.
        SweepError, MissingExtraError: as `palpate.base.sweep.sweep`.
    """
    options = BatchOptions(duration, tuple(signals), signal_rate)
    listed = variations(runs)
    if workers is not None and workers < 1:
        raise PalpateError(f"workers = {workers}: must be at least 1")
    t = options.times(listed)
    if executor == "threads":
        outcomes = _run_in_threads(listed, options, workers or cores(), on_progress)
    else:
        outcomes = _run_in_sweep(listed, options, workers, executor, address)
    return stack_outcomes(outcomes, t)


def _run_in_threads(
    listed: Sequence[Variation], options: BatchOptions, workers: int, on_progress: Callable[[int], None] | None
) -> list[Outcome]:
    shared, stop = SharedSurfaces(), threading.Event()
    with threadpool_limits(1), ThreadPoolExecutor(min(workers, len(listed)), "palpate-run") as pool:
        futures = [pool.submit(simulate_one, shared, index, one, options, stop) for index, one in enumerate(listed)]
        try:
            for count, future in enumerate(as_completed(futures), 1):
                future.result()
                if on_progress is not None:
                    on_progress(count)
        except BaseException:  # a run failed, or Ctrl-C: the other runs end after their current batch
            stop.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        return [future.result() for future in futures]


def _run_in_sweep(
    listed: Sequence[Variation],
    options: BatchOptions,
    workers: int | None,
    executor: Literal["local", "dask"],
    address: str | None,
) -> list[Outcome]:
    fn = partial(_point, listed=tuple(listed), options=options)
    swept = sweep(fn, {"run": Axis(range(len(listed)))}, executor=executor, workers=workers, address=address)
    return [Outcome.of(swept.values[index]) for index in range(len(listed))]


_WORKER_SURFACES = SharedSurfaces()
"""Surfaces shared by the runs of this worker process of a sweep."""


def _point(point: Point, seed: int, *, listed: tuple[Variation, ...], options: BatchOptions) -> Outcome:
    """Simulate one run on a worker. The seed of the sweep is unused, because the run has its own."""
    index = int(point["run"])
    return simulate_one(_WORKER_SURFACES, index, listed[index], options)
