"""The queue of pending points: it hands out chunks and takes them back when a worker dies."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable

from palpate.base.sweep.work import PointResult

CHUNK_SECONDS = 0.25
"""Target duration of one chunk [s]: long compared with the communication, short compared with the sweep."""
MAX_DEATHS = 3
"""Number of workers that may die at a point before it is reported as failed."""


class Queue:
    """Chunks of points, sized by the measured time per point.

    Args:
        todo: indices of the points.
        workers: number of workers that share the points.
        max_deaths: number of workers that may die at a point before it is reported as failed.
    """

    def __init__(self, todo: Iterable[int], workers: int, max_deaths: int = MAX_DEATHS) -> None:
        self._todo = deque(todo)
        self._alone: deque[int] = deque()  # points of dead workers, handed out one at a time
        self.workers, self._max_deaths = workers, max_deaths
        self._killed: Counter[int] = Counter()
        self._done, self._seconds = 0, 0.0

    def __bool__(self) -> bool:
        """True if points are pending."""
        return bool(self._todo or self._alone)

    def take(self) -> list[int]:
        """The next chunk; empty if no point is pending."""
        if self._alone:
            return [self._alone.popleft()]
        size = round(CHUNK_SECONDS * self._done / max(self._seconds, 1e-9)) if self._done else 1
        fair = len(self._todo) // (2 * max(self.workers, 1))  # chunks shrink so that all workers finish together
        return [self._todo.popleft() for _ in range(min(len(self._todo), max(1, min(size, fair))))]

    def took(self, points: int, seconds: float) -> None:
        """Update the mean time per point with a finished chunk of ``points`` that took ``seconds`` [s]."""
        self._done += points
        self._seconds += seconds

    def again(self, chunk: list[int]) -> None:
        """Queue these points again, before all others and one at a time."""
        self._alone.extend(chunk)

    def lost(self, chunk: list[int], why: str) -> list[PointResult]:
        """Queue the points of a dead worker again, one at a time, to find the point that killed it.

        Returns:
            A failed answer if the chunk is a single point that has killed too many workers; otherwise nothing.
        """
        if len(chunk) == 1:
            self._killed[chunk[0]] += 1
            if self._killed[chunk[0]] >= self._max_deaths:
                return [PointResult(chunk[0], None, f"its worker process died in each attempt ({why})")]
        self.again(chunk)
        return []
