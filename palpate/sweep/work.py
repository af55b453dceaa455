"""What a worker does: one point after the other, each with a seed of its own. The same in every executor."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from palpate.sweep.grid import Grid, Point

Values = dict[str, Any]
Function = Callable[[Point, int], Mapping[str, Any]]


class Answer(NamedTuple):
    """What came of one point."""

    point: int
    """its number in the grid."""
    values: Values | None
    """as ``fn`` returned them, in plain types; None when it failed."""
    error: str = ""
    """why it failed, in words."""


@dataclass(frozen=True)
class Work:
    """A function over a grid, ready to be sent to a worker."""

    fn: Function
    grid: Grid
    seed: int
    version: str

    def answers(self, indices: list[int]) -> Iterator[Answer]:
        """Points one by one."""
        stranger = identity() != self.version
        for index in indices:
            if stranger:
                why = f"the worker runs palpate {identity()}, the sweep was begun by {self.version}; install the same"
                yield Answer(index, None, why)
            else:
                yield self._answer(index)

    def _answer(self, index: int) -> Answer:
        try:
            found = self.fn(self.grid.point(index), seed_of(self.seed, index))
            return Answer(index, {str(name): plain(value) for name, value in found.items()})
        except (Exception, SystemExit) as error:
            frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename != __file__]
            place = f" ({frames[-1].filename}:{frames[-1].lineno})" if frames else ""
            return Answer(index, None, f"{type(error).__name__}: {error}{place}")


def seed_of(seed: int, index: int) -> int:
    """The seed of a point: independent of all others', the same whoever computes it and when; below 2^63."""
    child = np.random.SeedSequence(seed, spawn_key=(index,))
    return int(child.generate_state(1, np.uint64)[0] >> np.uint64(1))


@cache
def identity() -> str:
    """Version of palpate with a fingerprint of its sources and its compiled core: the code that a number came from."""
    from palpate import __file__ as package
    from palpate import __version__, _core

    folder = Path(package).parent
    digest = sha256(Path(_core.__file__).read_bytes())
    for file in sorted(folder.rglob("*.py")):
        digest.update(f"{file.relative_to(folder)}\n".encode() + file.read_bytes())
    return f"{__version__} ({digest.hexdigest()[:12]})"


@cache
def limit_threads() -> None:
    """BLAS of this process on one thread, from now on: more would be in each other's way, and round differently."""
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)


def plain(value: Any) -> Any:
    """As JSON keeps it: numbers, texts, truths, None, and lists and dictionaries of them.

    Raises:
        TypeError: something else.
    """
    if isinstance(value, np.generic):
        return plain(value.item())
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(v) for v in value]
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    raise TypeError(f"fn returned a {type(value).__name__}; numbers, texts, lists and dictionaries can be kept")
