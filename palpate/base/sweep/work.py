"""The work of a worker: it evaluates points one after the other, each with an own seed, identically in any executor."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from palpate.base.arrays.plain import plain
from palpate.base.sweep.grid import Grid, Point

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Values: TypeAlias = dict[str, Any]
"""Values of one point by name, in plain types; each study knows the types of its own values."""
Function: TypeAlias = "Callable[[Point, int], Mapping[str, Any] | DataclassInstance]"
"""Maps a point and a seed to named values."""


class PointResult(NamedTuple):
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

    def answers(self, indices: list[int]) -> Iterator[PointResult]:
        """Evaluate the points with these indices, in this order."""
        other_version = identity() != self.version
        for index in indices:
            if other_version:
                why = f"the worker runs palpate {identity()}, the sweep was begun by {self.version}; install the same"
                yield PointResult(index, None, why)
            else:
                yield self._answer(index)

    def _answer(self, index: int) -> PointResult:
        try:
            return PointResult(index, _values(self.fn(self.grid.point(index), seed_of(self.seed, index))))
        except (Exception, SystemExit) as error:
            frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename not in _OWN_FILES]
            place = f" ({frames[-1].filename}:{frames[-1].lineno})" if frames else ""
            return PointResult(index, None, f"{type(error).__name__}: {error}{place}")


_OWN_FILES = (__file__, plain.__code__.co_filename)
"""Files that an error message does not name as the place of a fault in ``fn``."""


def _values(found: object) -> Values:
    values = plain(found)
    if not isinstance(values, dict):
        raise TypeError(f"fn returned a {type(found).__name__}; return a dictionary or a dataclass")
    return values


def seed_of(seed: int, index: int) -> int:
    """The seed of a point, below 2^63: independent of all other points' seeds and of the executor."""
    child = np.random.SeedSequence(seed, spawn_key=(index,))
    return int(child.generate_state(1, np.uint64)[0] >> np.uint64(1))


@cache
def identity() -> str:
    """Version of palpate with a fingerprint of its sources, the laboratory's included, and its compiled core."""
    from palpate import __version__, _core

    digest = sha256(Path(_core.__file__).read_bytes())
    for package in ("palpate", "palpate_lab"):
        spec = find_spec(package)
        if spec is None or spec.origin is None:
            continue
        folder = Path(spec.origin).parent
        for file in sorted(folder.rglob("*.py")):
            digest.update(f"{package}/{file.relative_to(folder)}\n".encode() + file.read_bytes())
    return f"{__version__} ({digest.hexdigest()[:12]})"


@cache
def limit_threads() -> None:
    """Limit BLAS in this process to one thread permanently, because several threads compete and round differently."""
    from threadpoolctl import threadpool_limits

    threadpool_limits(1)
