"""Ticks of a lockstep run that a thread behind the loop counts and records, so that the loop need not wait."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager

import numpy as np

from palpate.base import switching
from palpate.record.snapshots import Snapshot
from palpate.record.ticks import Ticks, as_rows, as_ticks

Keep = Callable[[Ticks, list[Snapshot]], None]
MOST = 4
"""Blocks that may wait: memory stays bounded where the record is slower than the loop."""


_SWITCH = 1e-4  # [s]


@contextmanager
def loop_first() -> Iterator[None]:
    """Lets the thread of a lockstep loop have the interpreter soon when it comes back from the core.

    The thread that records would keep it for up to 5 ms, in which the loop simulates most of a second.
    """
    withdraw = switching.ask(_SWITCH)
    try:
        yield
    finally:
        withdraw()


class Backlog:
    """Gathers ticks into blocks, and hands each block to one thread, in order.

    After a block that failed, those that wait are dropped: a loop that keeps its ticks itself would not have come to
    them.

    Args:
        size: number of ticks from which on a block is handed over.
        keep: takes a block of ticks (n,), and the snapshots among them.
    """

    def __init__(self, size: int, keep: Keep) -> None:
        self._size, self._keep = size, keep
        self._lock = threading.Lock()  # never taken by the thread
        self._ticks: list[Ticks] = []
        self._snapshots: list[Snapshot] = []
        self._thread: ThreadPoolExecutor | None = None
        self._waiting: deque[Future[None]] = deque()

    def add(self, ticks: Ticks, snapshots: list[Snapshot]) -> None:
        """Add the next ticks (n,); waits while `MOST` blocks do.

        Raises:
            Exception: what `keep` raised for an earlier block.
        """
        with self._lock:
            self._ticks.append(ticks)
            self._snapshots += snapshots
            if sum(map(len, self._ticks)) >= self._size:
                self._hand_over()
            self._wait(MOST)

    def finish(self) -> None:
        """Hand over what is left, and wait until every block is taken.

        Raises:
            Exception: what `keep` raised for a block.
        """
        with self._lock:
            if self._ticks:
                self._hand_over()
            self._wait(0)

    def _hand_over(self) -> None:
        if self._thread is None:
            self._thread = ThreadPoolExecutor(1, "palpate-record")
        self._waiting.append(self._thread.submit(_keep, self._keep, self._ticks, self._snapshots))
        self._ticks, self._snapshots = [], []

    def _wait(self, most: int) -> None:
        while len(self._waiting) > most or (self._waiting and self._waiting[0].done()):
            try:
                self._waiting[0].result()
            except Exception:
                self._drop()
                raise
            self._waiting.popleft()

    def _drop(self) -> None:
        for block in self._waiting:
            block.cancel()
        wait(self._waiting)
        self._waiting.clear()
        self._ticks, self._snapshots = [], []


def _keep(keep: Keep, ticks: list[Ticks], snapshots: list[Snapshot]) -> None:
    keep(as_ticks(np.concatenate([as_rows(some) for some in ticks])), snapshots)
