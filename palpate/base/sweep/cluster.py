"""Run a sweep on an existing Dask cluster, or on a local one that listens on the loopback interface only."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator
from contextlib import ExitStack, suppress
from typing import Any

from palpate.base.errors import MissingExtraError, SweepError
from palpate.base.sweep.local import MEND, cores
from palpate.base.sweep.queue import Queue
from palpate.base.sweep.work import PointResult, Work, limit_threads

CONNECT_SECONDS, WORKERS_SECONDS = 20.0, 120.0
"""Timeouts for the connection to a scheduler, and for its first worker [s]."""
POLL_SECONDS = 2.0
"""Time between two polls of the cluster [s]."""
IDLE_POLLS = 3
"""Consecutive polls with pending work but idle workers before the work is submitted again. A scheduler may lose work
when several workers die at the same moment (seen with distributed 2026.8)."""


def run(
    work: Work, todo: list[int], workers: int | None = None, address: str | None = None
) -> Generator[list[PointResult], None, None]:
    """Yield batches of answers in order of completion. Dask itself repeats a chunk when its worker dies.

    Args:
        work: function and grid.
        todo: indices of the points.
        workers: number of workers of a local cluster; default: one per core.
        address: address of an existing scheduler; default: start a local cluster.

    Raises:
        MissingExtraError: Dask is not installed.
        SweepError: there is no scheduler or no worker, or the function cannot be sent to the workers.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError:
        raise MissingExtraError("the Dask executor", "dask") from None
    with ExitStack() as stack:
        place: Any = address
        if address is None:  # nothing listens on another interface than the loopback
            options = {"n_workers": workers or cores(), "threads_per_worker": 1}
            place = stack.enter_context(LocalCluster(host="127.0.0.1", dashboard_address="127.0.0.1:0", **options))
        client = stack.enter_context(_connected(Client, place, address))
        queue = Queue(todo, _threads(client), max_deaths=1)  # Dask itself retries a chunk that kills its worker
        yield from _Submitted(client, work, queue, place).answers()


class _Submitted:
    """The chunks that a Dask client has submitted and that are not yet answered."""

    def __init__(self, client: Any, work: Work, queue: Queue, place: Any) -> None:
        self._client, self._work, self._queue, self._place = client, work, queue, place
        self._chunks: dict[Any, list[int]] = {}  # by future
        self._had_worker = time.monotonic()  # last time at which the cluster had a worker [s]

    def answers(self) -> Generator[list[PointResult], None, None]:
        """Submit all chunks, and yield their answers in order of completion."""
        idle = 0
        while self._queue or self._chunks:
            self._require_worker()
            self._submit()
            self._wait()
            done = [future for future in self._chunks if future.done()]
            for future in done:
                yield from self._take(future)
            busy = done or not self._queue.workers or any(self._client.processing().values())
            idle = 0 if busy else idle + 1
            if idle >= IDLE_POLLS:
                self._take_back()

    def _require_worker(self) -> None:
        self._queue.workers = _threads(self._client)
        now = time.monotonic()
        if self._queue.workers:
            self._had_worker = now
        elif now - self._had_worker > WORKERS_SECONDS:
            raise _no_worker(self._place, "the last worker has left and no new worker joined")

    def _submit(self) -> None:
        """Keep two chunks per worker submitted."""
        while self._queue and len(self._chunks) < 2 * max(1, self._queue.workers):
            chunk = self._queue.take()
            self._chunks[self._client.submit(_chunk, self._work, chunk, pure=False)] = chunk

    def _wait(self) -> None:
        from distributed import wait

        with suppress(TimeoutError), self._client.as_current():
            wait(list(self._chunks), timeout=POLL_SECONDS, return_when="FIRST_COMPLETED")

    def _take(self, future: Any) -> Iterator[list[PointResult]]:
        chunk = self._chunks.pop(future)
        try:
            yield _answers(future, chunk, self._queue)
        except TimeoutError:  # the worker died before it transferred the result
            self._queue.again(chunk)
        future.release()

    def _take_back(self) -> None:
        """Cancel all submitted chunks and return them to the queue."""
        self._client.cancel(list(self._chunks))
        for chunk in self._chunks.values():
            self._queue.again(chunk)
        self._chunks.clear()


def _no_worker(place: Any, why: str) -> SweepError:
    mend = "start dask worker, and sweep again: the journal contains the finished points"
    where = getattr(place, "scheduler_address", place)
    return SweepError(
        f"the Dask scheduler at {where} has no worker", why=f"{why} within {WORKERS_SECONDS:g} s", mend=mend
    )


def _connected(client: Any, place: Any, address: str | None) -> Any:
    try:
        found = client(place, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        mend = "start a scheduler (dask scheduler), or correct the address"
        raise SweepError(f"no Dask scheduler answers at {address}", why=str(error), mend=mend) from None
    try:
        found.wait_for_workers(1, timeout=WORKERS_SECONDS)
    except TimeoutError:
        found.close()
        raise _no_worker(place, "no worker joined") from None
    return found


def _threads(client: Any) -> int:
    return sum(client.nthreads().values())


def _answers(future: Any, chunk: list[int], queue: Queue) -> list[PointResult]:
    """Result of a finished future; raises TimeoutError if the result is lost."""
    from distributed import CancelledError, KilledWorker

    try:
        seconds, answers = future.result(timeout=POLL_SECONDS)
    except TimeoutError:
        raise
    except KilledWorker as error:
        return queue.lost(chunk, f"{error.allowed_failures + 1} workers by Dask's count")
    except CancelledError as error:
        raise SweepError("the Dask cluster has lost the work", why=str(error)) from None
    except Exception as error:  # unpickling on the worker may raise any exception
        raise SweepError("the Dask workers cannot run fn", why=f"{type(error).__name__}: {error}", mend=MEND) from None
    queue.took(len(chunk), seconds)
    return [PointResult(*answer) for answer in answers]


def _chunk(work: Work, points: list[int]) -> tuple[float, list[tuple[Any, ...]]]:
    """Evaluate points on a worker: elapsed time [s], and answers as plain tuples."""
    limit_threads()
    start = time.perf_counter()
    answers = [tuple(answer) for answer in work.answers(points)]
    return time.perf_counter() - start, answers
