"""Processes of this machine. Each is started once, works chunk after chunk, and may be killed at any moment."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import time
from collections.abc import Generator, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from palpate.errors import SweepError
from palpate.sweep.queue import PATIENCE, Queue
from palpate.sweep.work import Answer, Work, limit_threads

#: What most often is to be done when processes cannot import the function.
MEND = "define fn at the top of a file, and call sweep() below: if __name__ == '__main__':"
FLUSH_SECONDS = 0.02
"""A worker hands over what it has after this time: what a kill can make be done again."""


def cores() -> int:
    """That this process may use."""
    return len(os.sched_getaffinity(0))


def run(work: Work, todo: list[int], workers: int | None = None) -> Generator[list[Answer], None, None]:
    """Answers as they come, some at a time, in any order.

    Args:
        work: what is to be done.
        todo: numbers of the points.
        workers: processes; one for each core when left out.

    Raises:
        SweepError: the function cannot be sent to a process, or the processes cannot start.
    """
    count = max(1, min(workers or cores(), len(todo)))
    packed, queue = _pack(work), Queue(todo, count)
    crew = [_Worker(packed) for _ in range(count)]
    stillborn = 0
    try:
        while queue or any(worker.chunk for worker in crew):
            for worker in crew:
                worker.feed(queue)
            for connection in wait([worker.connection for worker in crew if worker.chunk or not worker.ready]):
                worker = next(w for w in crew if w.connection is connection)
                try:
                    yield worker.hear(queue)
                except (EOFError, OSError):  # it is dead, and its connection with it
                    stillborn = 0 if worker.ready else stillborn + 1
                    if stillborn >= PATIENCE:
                        why = f"each {worker.fate()} while it was starting; see above what it said"
                        raise SweepError("the worker processes do not start", why=why, mend=MEND) from None
                    yield queue.lost(worker.chunk, worker.fate())
                    crew[crew.index(worker)] = _Worker(packed)
    finally:
        for worker in crew:
            worker.stop()


def _pack(work: Work) -> bytes:
    try:
        return pickle.dumps(work)
    except Exception as error:  # pickle raises whatever it likes
        raise SweepError("fn cannot be sent to worker processes", why=str(error), mend=MEND) from None


@dataclass
class _Worker:
    """The parent's end of one process."""

    packed: bytes
    ready: bool = False
    chunk: list[int] = field(default_factory=list)
    """given to it and not yet answered."""

    def __post_init__(self) -> None:
        spawn = multiprocessing.get_context("spawn")
        ours, theirs = spawn.Pipe()
        self.connection: Connection = ours
        self.process: BaseProcess = spawn.Process(target=_serve, args=(theirs, self.packed), daemon=True)
        self.process.start()
        theirs.close()

    def feed(self, queue: Queue) -> None:
        """Give it a chunk when it has none."""
        if self.chunk or not self.ready:
            return
        self.chunk = queue.take()
        self._size, self._since = len(self.chunk), time.perf_counter()
        if self.chunk:
            with suppress(OSError):  # it is dead: hear() will say so
                self.connection.send(self.chunk)

    def hear(self, queue: Queue) -> list[Answer]:
        """What it says. Raises EOFError or OSError when it is dead, SweepError when it cannot begin."""
        said = self.connection.recv()
        if isinstance(said, str):
            if said:
                raise SweepError("the worker processes cannot import fn", why=said, mend=MEND)
            self.ready = True
            return []
        answers = [Answer(*answer) for answer in said]
        self.chunk = self.chunk[len(answers) :]  # they come in order
        if not self.chunk:
            queue.took(self._size, time.perf_counter() - self._since)
        return answers

    def fate(self) -> str:
        """How it ended, in words."""
        self.process.join(5.0)
        code = self.process.exitcode or 0
        return f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"

    def stop(self) -> None:
        """End it: whatever it is doing is not wanted any more."""
        self.process.kill()
        self.process.join()
        self.connection.close()


def _serve(connection: Connection, packed: bytes) -> None:
    """In the process: chunks in, answers out; ends with the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's affair
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
    except (EOFError, OSError):  # the parent has gone
        return


def _batches(work: Work, chunk: list[int]) -> Iterator[list[tuple[Any, ...]]]:
    """Answers as they are, no older than ``FLUSH_SECONDS``."""
    batch: list[tuple[Any, ...]] = []
    since = time.perf_counter()
    for answer in work.answers(chunk):
        batch.append(tuple(answer))
        if time.perf_counter() - since > FLUSH_SECONDS:
            yield batch
            batch, since = [], time.perf_counter()
    if batch:
        yield batch
