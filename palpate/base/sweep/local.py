"""Worker processes of this machine. Each one computes chunk after chunk and may be killed at any time."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections.abc import Generator, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from palpate.base.errors import SweepError
from palpate.base.sweep.queue import MAX_DEATHS, Queue
from palpate.base.sweep.work import PointResult, Work, limit_threads

#: Remedy for the most frequent cause when processes cannot import the function.
MEND = "define fn at the top of a file, and call sweep() below: if __name__ == '__main__':"
FLUSH_SECONDS = 0.02
"""Time between two transfers of results [s]; a killed worker loses at most this time of work, or one point."""


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0))


def run(work: Work, todo: list[int], workers: int | None = None) -> Generator[list[PointResult], None, None]:
    """Yield batches of answers in order of completion.

    Args:
        work: function and grid.
        todo: indices of the points.
        workers: number of processes; default: one per core.

    Raises:
        SweepError: the function cannot be sent to a process, or the processes cannot start.
    """
    count = max(1, min(workers or cores(), len(todo)))
    packed, queue = _pack(work), Queue(todo, count)
    crew = [_Worker(packed) for _ in range(count)]
    failed_starts = 0
    try:
        while queue or any(worker.chunk for worker in crew):
            for worker in crew:
                worker.feed(queue)
            for connection in wait([worker.connection for worker in crew if worker.chunk or not worker.ready]):
                worker = next(w for w in crew if w.connection is connection)
                try:
                    yield worker.receive(queue)
                except (EOFError, OSError):  # the worker has died and its connection is closed
                    failed_starts = 0 if worker.ready else failed_starts + 1
                    if failed_starts >= MAX_DEATHS:
                        why = f"each {worker.exit_cause()} while it was starting; see its output above"
                        raise SweepError("the worker processes do not start", why=why, mend=MEND) from None
                    yield queue.lost(worker.chunk, worker.exit_cause())
                    crew[crew.index(worker)] = _Worker(packed)
    finally:
        for worker in crew:
            worker.stop()


def _pack(work: Work) -> bytes:
    try:
        return pickle.dumps(work)
    except Exception as error:  # pickle may raise any exception
        raise SweepError("fn cannot be sent to worker processes", why=str(error), mend=MEND) from None


@dataclass
class _Worker:
    """The parent's side of one worker process."""

    packed: bytes
    ready: bool = False
    chunk: list[int] = field(default_factory=list)
    """points that were sent to the worker and not yet answered."""

    def __post_init__(self) -> None:
        spawn = multiprocessing.get_context("spawn")
        ours, theirs = spawn.Pipe()
        self.connection: Connection = ours
        self.process: BaseProcess = spawn.Process(target=_serve, args=(theirs, self.packed), daemon=True)
        self.process.start()
        theirs.close()

    def feed(self, queue: Queue) -> None:
        """Send a chunk to the worker if it is idle."""
        if self.chunk or not self.ready:
            return
        self.chunk = queue.take()
        self._size, self._since = len(self.chunk), time.perf_counter()
        if self.chunk:
            with suppress(OSError):  # a dead worker is detected by receive()
                self.connection.send(self.chunk)

    def receive(self, queue: Queue) -> list[PointResult]:
        """The worker's next answers; empty for its start message.

        Raises:
            EOFError, OSError: the worker is dead.
            SweepError: the worker cannot import the function.
        """
        message = self.connection.recv()
        if isinstance(message, str):
            if message:
                raise SweepError("the worker processes cannot import fn", why=message, mend=MEND)
            self.ready = True
            return []
        answers = [PointResult(*answer) for answer in message]
        self.chunk = self.chunk[len(answers) :]  # answers arrive in the order of the chunk
        if not self.chunk:
            queue.took(self._size, time.perf_counter() - self._since)
        return answers

    def exit_cause(self) -> str:
        """The cause of the process's end in words."""
        self.process.join(5.0)
        code = self.process.exitcode or 0
        return f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"

    def stop(self) -> None:
        """Kill the process and discard its work."""
        self.process.kill()
        self.process.join()
        self.connection.close()


def _serve(connection: Connection, packed: bytes) -> None:
    """Main function of a worker process: receive chunks and send answers until the parent ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Ctrl-C
    threading.Thread(target=_end_with_parent, name="palpate-parent", daemon=True).start()
    try:
        work: Work = pickle.loads(packed)
        limit_threads()
    except Exception as error:
        connection.send(f"{type(error).__name__}: {error}")
        return
    try:
        connection.send("")
        while True:
            for batch in _batches(work, connection.recv()):
                connection.send(batch)
    except (EOFError, OSError):  # the parent has ended
        return


def _end_with_parent() -> None:
    """End this process at once when its parent has ended, also by a kill: a point may take long, and hold a lock."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _batches(work: Work, chunk: list[int]) -> Iterator[list[tuple[Any, ...]]]:
    """Batches of answers as plain tuples; each batch spans about ``FLUSH_SECONDS``."""
    batch: list[tuple[Any, ...]] = []
    since = time.perf_counter()
    for answer in work.answers(chunk):
        batch.append(tuple(answer))
        if time.perf_counter() - since > FLUSH_SECONDS:
            yield batch
            batch, since = [], time.perf_counter()
    if batch:
        yield batch
