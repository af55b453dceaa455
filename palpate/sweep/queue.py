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
        patience: how often a point may take down its worker before it is given up.
    """

    def __init__(self, todo: Iterable[int], workers: int, patience: int = PATIENCE) -> None:
        self._todo = deque(todo)
        self._alone: deque[int] = deque()  # were with a worker that died
        self.workers, self._patience = workers, patience
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

    def again(self, chunk: list[int]) -> None:
        """These are done again, before all others, one at a time."""
        self._alone.extend(chunk)

    def lost(self, chunk: list[int], why: str) -> list[Answer]:
        """A worker died over these points: they are done again, one at a time, so that it shows over which one.

        Returns:
            The answer in words when it was one, and that one has done so too often.
        """
        if len(chunk) == 1:
            self._killed[chunk[0]] += 1
            if self._killed[chunk[0]] >= self._patience:
                return [Answer(chunk[0], None, f"its worker process died, again and again ({why})")]
        self.again(chunk)
        return []
