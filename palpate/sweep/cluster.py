"""A Dask cluster: one that is there, or processes of this machine, which then listen on its loopback alone."""

from __future__ import annotations

import time
from collections.abc import Generator
from contextlib import ExitStack, suppress
from typing import Any

from palpate.errors import MissingExtraError, SweepError
from palpate.sweep.local import MEND, cores
from palpate.sweep.queue import Queue
from palpate.sweep.work import Answer, Work, limit_threads

CONNECT_SECONDS, WORKERS_SECONDS = 20.0, 120.0
"""Patience with a scheduler that does not answer, and with one that has no worker yet."""
POLL_SECONDS = 2.0
"""Between two looks at the cluster when nothing is heard from it."""
IDLE_POLLS = 3
"""Looks in which workers are there, work is, too, and none is doing it, before it is handed out anew: a scheduler may
forget work when several workers die at the same moment (seen with distributed 2026.8)."""


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
        from distributed import Client, LocalCluster, wait
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
        idle, since = 0, time.monotonic()
        while queue or flying:
            queue.workers = _threads(client)
            since = time.monotonic() if queue.workers else since
            if time.monotonic() - since > WORKERS_SECONDS:
                raise _no_worker(place, "the last one has gone, and none came")
            while queue and len(flying) < 2 * max(1, queue.workers):
                chunk = queue.take()
                flying[client.submit(_chunk, work, chunk, pure=False)] = chunk
            with suppress(TimeoutError), client.as_current():
                wait(list(flying), timeout=POLL_SECONDS, return_when="FIRST_COMPLETED")
            done = [future for future in flying if future.done()]
            for future in done:
                chunk = flying.pop(future)
                try:
                    yield _answers(future, chunk, queue)
                except TimeoutError:  # its worker died before it could hand it over
                    queue.again(chunk)
                future.release()
            idle = idle + 1 if not done and queue.workers and not any(client.processing().values()) else 0
            if idle >= IDLE_POLLS:
                client.cancel(list(flying))
                for chunk in flying.values():
                    queue.again(chunk)
                flying.clear()


def _no_worker(place: Any, why: str) -> SweepError:
    mend = "start dask worker, and sweep again: what is done is in the journal"
    where = getattr(place, "scheduler_address", place)
    return SweepError(
        f"the Dask scheduler at {where} has no worker", why=f"{why} within {WORKERS_SECONDS:g} s", mend=mend
    )


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
        raise _no_worker(place, "none came") from None
    return found


def _threads(client: Any) -> int:
    return sum(client.nthreads().values())


def _answers(future: Any, chunk: list[int], queue: Queue) -> list[Answer]:
    """Raises TimeoutError when it is not there after all."""
    from distributed import CancelledError, KilledWorker

    try:
        seconds, answers = future.result(timeout=POLL_SECONDS)
    except TimeoutError:
        raise
    except KilledWorker as error:
        return queue.lost(chunk, f"{error.allowed_failures + 1} workers by Dask's count")
    except CancelledError as error:
        raise SweepError("the Dask cluster has forgotten the work", why=str(error)) from None
    except Exception as error:  # from unpickling on the worker: of any kind
        raise SweepError("the Dask workers cannot run fn", why=f"{type(error).__name__}: {error}", mend=MEND) from None
    queue.took(len(chunk), seconds)
    return [Answer(*answer) for answer in answers]


def _chunk(work: Work, points: list[int]) -> tuple[float, list[tuple[Any, ...]]]:
    """On a worker."""
    limit_threads()
    start = time.perf_counter()
    answers = [tuple(answer) for answer in work.answers(points)]
    return time.perf_counter() - start, answers
