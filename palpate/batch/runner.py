"""Many runs on all cores of this machine, or on a Dask cluster."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import partial
from typing import Any, Literal

from threadpoolctl import threadpool_limits

from palpate.batch.one import Asked, World, outcome
from palpate.batch.result import Outcome, Simulated, collected
from palpate.batch.variation import Runs, Variation, variations
from palpate.errors import PalpateError
from palpate.sweep import Axis, sweep
from palpate.sweep.grid import Point
from palpate.sweep.local import cores


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
    """Simulate many runs in lockstep; each is the run that a session of the same scene and seed makes.

    Nothing is recorded on disk. Meshes and their indices are shared between the runs. Apart from the keys in
    ``palpate.batch.MEASURED``, the results depend on scenes, overrides and seeds alone: not on the order of the runs,
    on the executor or on the number of workers.

    Args:
        runs: scenes, paths of scene files or `Variation` objects; or one of them.
        duration: simulated time of every run [s]; each scene's own when left out (then all must agree if signals are
            asked for).
        signals: names of recorded signals to keep (`palpate.record.SIGNALS`), e.g. ``F_T_W``.
        signal_rate: samples of the signals per simulated second, each the nearest tick [Hz].
        workers: threads or processes; one per core when left out. On an existing cluster all its workers are used.
        executor: ``threads`` of this process, ``local`` processes, or a ``dask`` cluster (docs/studies.md).
        address: of an existing Dask scheduler; without one, ``dask`` starts a cluster on this machine.
        on_progress: receives the number of finished runs after each run (``threads`` only).

    Returns:
        The summaries and signals as arrays, first axis: the run.

    Raises:
        SceneError, MeshError: a run cannot be set up; the message names the run.
        PalpateError: no runs, an unknown signal, or a rate that no scene has.
        SweepError, MissingExtraError: as `palpate.sweep.sweep`.
    """
    asked = Asked(duration, tuple(signals), signal_rate)
    listed = variations(runs)
    if workers is not None and workers < 1:
        raise PalpateError(f"workers = {workers}: must be at least 1")
    t = asked.times(listed)
    if executor == "threads":
        outcomes = _in_threads(listed, asked, workers or cores(), on_progress)
    else:
        outcomes = _swept(listed, asked, workers, executor, address)
    return collected(outcomes, t)


def _in_threads(
    listed: Sequence[Variation], asked: Asked, workers: int, on_progress: Callable[[int], None] | None
) -> list[Outcome]:
    world, stop = World(), threading.Event()
    with threadpool_limits(1), ThreadPoolExecutor(min(workers, len(listed)), "palpate-run") as pool:
        futures = [pool.submit(outcome, world, index, one, asked, stop) for index, one in enumerate(listed)]
        try:
            for count, future in enumerate(as_completed(futures), 1):
                future.result()
                if on_progress is not None:
                    on_progress(count)
        except BaseException:  # a run that failed, or Ctrl-C: the others end at their next batch of ticks
            stop.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        return [future.result() for future in futures]


def _swept(
    listed: Sequence[Variation],
    asked: Asked,
    workers: int | None,
    executor: Literal["local", "dask"],
    address: str | None,
) -> list[Outcome]:
    fn = partial(_point, listed=tuple(listed), asked=asked)
    swept = sweep(fn, {"run": Axis(range(len(listed)))}, executor=executor, workers=workers, address=address)
    return [Outcome.of(swept.values[index]) for index in range(len(listed))]


_HERE = World()
"""Of this process when it is a worker of a sweep: its runs share meshes, too."""


def _point(point: Point, seed: int, *, listed: tuple[Variation, ...], asked: Asked) -> dict[str, Any]:
    """One run on a worker. The sweep's own seed is not used: the run has one."""
    index = int(point["run"])
    return outcome(_HERE, index, listed[index], asked)._asdict()
