"""The points still to be done, handed out in chunks, and taken back when a worker dies."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable

from palpate.sweep.work import Answer

CHUNK_SECONDS = 0.25
"""Work in one chunk: long beside the way to a worker and back, short beside the sweep."""
PATIENCE = 3
"""Workers that a point may take down before it is given up."""


class Queue:
    """Chunks of points; their size follows the time that points have taken.

    Args:
        todo: numbers of the points.
        workers: that share them.
    """

    def __init__(self, todo: Iterable[int], workers: int) -> None:
        self._todo = deque(todo)
        self._alone: deque[int] = deque()  # were with a worker that died
        self.workers = workers
        self._killed: Counter[int] = Counter()
        self._done, self._seconds = 0, 0.0

    def __bool__(self) -> bool:
        """Whether points wait."""
        return bool(self._todo or self._alone)

    def take(self) -> list[int]:
        """The next chunk; empty when no point waits."""
        if self._alone:
            return [self._alone.popleft()]
        size = round(CHUNK_SECONDS * self._done / max(self._seconds, 1e-9)) if self._done else 1
        fair = len(self._todo) // (2 * max(self.workers, 1))  # towards the end smaller, so that all end together
        return [self._todo.popleft() for _ in range(min(len(self._todo), max(1, min(size, fair))))]

    def took(self, points: int, seconds: float) -> None:
        """Learn from a chunk that was done."""
        self._done += points
        self._seconds += seconds

    def alone(self, chunk: list[int]) -> None:
        """These are done again, one at a time, before all others."""
        self._alone.extend(chunk)

    def lost(self, chunk: list[int], why: str) -> list[Answer]:
        """A worker died over the first of these points: all are done again.

        Returns:
            The answer in words when that first point has taken down ``PATIENCE`` workers.
        """
        if not chunk:
            return []
        first, *others = chunk
        self._killed[first] += 1
        given_up = self._killed[first] >= PATIENCE
        self.alone(others if given_up else chunk)
        return [Answer(first, None, f"{PATIENCE} worker processes died over it ({why})")] if given_up else []
