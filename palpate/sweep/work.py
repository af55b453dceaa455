"""The work of a worker: it evaluates points one after the other, each with an own seed, identically in any executor."""

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
    """Result of one point."""

    point: int
    """Index of the point in the grid."""
    values: Values | None
    """Values that ``fn`` returned, in plain types; None if it failed."""
    error: str = ""
    """Error message if ``fn`` failed."""


@dataclass(frozen=True)
class Work:
    """A function and its grid, which can be pickled and sent to a worker."""

    fn: Function
    grid: Grid
    seed: int
    version: str

    def answers(self, indices: list[int]) -> Iterator[Answer]:
        """Evaluate the points with these indices, in this order."""
        other_version = identity() != self.version
        for index in indices:
            if other_version:
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
    """The seed of a point, below 2^63: independent of all other points' seeds and of the executor."""
    child = np.random.SeedSequence(seed, spawn_key=(index,))
    return int(child.generate_state(1, np.uint64)[0] >> np.uint64(1))


@cache
def identity() -> str:
    """Version of palpate with a fingerprint of its sources and its compiled core."""
    from palpate import __file__ as package
    from palpate import __version__, _core

    folder = Path(package).parent
    digest = sha256(Path(_core.__file__).read_bytes())
    for file in sorted(folder.rglob("*.py")):
        digest.update(f"{file.relative_to(folder)}\n".encode() + file.read_bytes())
    return f"{__version__} ({digest.hexdigest()[:12]})"


@cache
def limit_threads() -> None:
    """Limit BLAS in this process to one thread permanently, because several threads compete and round differently."""
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)


def plain(value: Any) -> Any:
    """A value in JSON types: numbers, texts, booleans, None, and lists and dictionaries of these.

    Raises:
        TypeError: the value has another type.
    """
    if isinstance(value, np.generic):
        return plain(value.item())
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(v) for v in value]
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    raise TypeError(f"fn returned a {type(value).__name__}; return numbers, texts, lists and dictionaries only")
