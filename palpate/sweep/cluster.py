"""A Dask cluster: one that is there, or processes of this machine, which then listen on its loopback alone."""

from __future__ import annotations

import time
from collections.abc import Generator
from contextlib import ExitStack
from typing import Any

from palpate.errors import MissingExtraError, SweepError
from palpate.sweep.local import MEND, cores
from palpate.sweep.queue import Queue
from palpate.sweep.work import Answer, Work, limit_threads

CONNECT_SECONDS, WORKERS_SECONDS = 20.0, 120.0
"""Patience with a scheduler that does not answer, and with one that has no worker yet."""


def run(
    work: Work, todo: list[int], workers: int | None = None, address: str | None = None
) -> Generator[list[Answer], None, None]:
    """Answers as they come, some at a time, in any order. Dask itself does a chunk again when its worker dies.

    Args:
        work: what is to be done.
        todo: numbers of the points.
        workers: of a cluster on this machine; one for each core when left out.
        address: of an existing scheduler.

    Raises:
        MissingExtraError: Dask is not installed.
        SweepError: no scheduler, no worker, or the function cannot be sent to them.
    """
    try:
        from distributed import Client, LocalCluster, as_completed
    except ImportError:
        raise MissingExtraError("the Dask executor", "dask") from None
    with ExitStack() as stack:
        if address is None:
            count, here = workers or cores(), "127.0.0.1"
            place: Any = LocalCluster(
                n_workers=count, threads_per_worker=1, host=here, dashboard_address=f"{here}:0"
            )  # nothing listens on another interface
            stack.enter_context(place)
        else:
            place = address
        client = stack.enter_context(_connected(Client, place, address))
        queue = Queue(todo, _threads(client), patience=1)  # Dask has its own
        flying: dict[Any, list[int]] = {}
        done = as_completed(loop=client.loop)
        while queue or flying:
            queue.workers = _threads(client)
            while queue and len(flying) < 2 * max(1, queue.workers):
                chunk = queue.take()
                future = client.submit(_chunk, work, chunk, pure=False)
                flying[future] = chunk
                done.add(future)
            future = next(done)
            yield _answers(future, flying.pop(future), queue)
            future.release()


def _connected(client: Any, place: Any, address: str | None) -> Any:
    try:
        found = client(place, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        mend = "start one (dask scheduler), or correct the address"
        raise SweepError(f"no Dask scheduler answers at {address}", why=str(error), mend=mend) from None
    try:
        found.wait_for_workers(1, timeout=WORKERS_SECONDS)
    except TimeoutError:
        found.close()
        why = f"none came within {WORKERS_SECONDS:g} s"
        raise SweepError(f"the Dask scheduler at {address} has no worker", why=why, mend="start dask worker") from None
    return found


def _threads(client: Any) -> int:
    return sum(client.nthreads().values())


def _answers(future: Any, chunk: list[int], queue: Queue) -> list[Answer]:
    if future.status == "finished":
        seconds, answers = future.result()
        queue.took(len(chunk), seconds)
        return [Answer(*answer) for answer in answers]
    if future.status == "cancelled":
        raise SweepError("the Dask cluster has forgotten the work", why="scheduler or connection is lost")
    error = future.exception()
    if type(error).__name__ != "KilledWorker":
        raise SweepError("the Dask workers cannot run fn", why=f"{type(error).__name__}: {error}", mend=MEND)
    return queue.lost(chunk, f"{error.allowed_failures + 1} workers by Dask's count")


def _chunk(work: Work, points: list[int]) -> tuple[float, list[tuple[Any, ...]]]:
    """On a worker."""
    limit_threads()
    start = time.perf_counter()
    answers = [tuple(answer) for answer in work.answers(points)]
    return time.perf_counter() - start, answers
