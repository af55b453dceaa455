"""The grid of a sweep: named axes; points are numbered in row-major order (the last axis varies fastest)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import prod
from typing import Any, TypeAlias

import numpy as np

from palpate.base.errors import SweepError

Scalar = float | int | bool | str
Point: TypeAlias = dict[str, Any]
"""One value per axis by name; each study knows the types of its own axes."""


@dataclass(frozen=True)
class Axis:
    """Values of one parameter.

    Args:
        values: distinct values, all numbers or all texts; numpy scalars are converted to Python scalars.
        unit: unit of the values, e.g. ``N/m``; empty for pure numbers and names.
        words: description of the parameter for labels and data files.
    """

    values: tuple[Scalar, ...]
    unit: str = ""
    words: str = ""

    def __init__(self, values: Iterable[Any], unit: str = "", words: str = "") -> None:
        plain = tuple(v.item() if isinstance(v, np.generic) else v for v in values)
        for name, value in (("values", plain), ("unit", unit), ("words", words)):
            object.__setattr__(self, name, value)


@dataclass(frozen=True)
class Grid:
    """The product of named axes."""

    axes: dict[str, Axis]

    @staticmethod
    def of(axes: Mapping[str, Axis | Iterable[Any]]) -> Grid:
        """Build a grid from axes by name and check their values.

        Raises:
            SweepError: an axis has no value, a duplicate value, or a value that is neither a number nor a text.
        """
        grid = Grid({name: a if isinstance(a, Axis) else Axis(a) for name, a in axes.items()})
        for name, axis in grid.axes.items():
            _check(name, axis.values)
        return grid

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(axis.values) for axis in self.axes.values())

    def __len__(self) -> int:
        """Number of points."""
        return prod(self.shape)

    def point(self, index: int) -> Point:
        """The point with this index, as one value per axis."""
        places = np.unravel_index(index, self.shape) if self.axes else ()
        return {name: axis.values[int(k)] for (name, axis), k in zip(self.axes.items(), places, strict=True)}

    def points(self, where: Callable[[Point], bool] | None) -> list[int]:
        """Indices of the points for which ``where`` is true; of all points without ``where``."""
        return [k for k in range(len(self)) if where is None or where(self.point(k))]


def _check(name: str, values: tuple[Scalar, ...]) -> None:
    for value in values:
        if not isinstance(value, (bool, int, float, str)) or value != value:
            raise SweepError(f"axis {name!r} has the value {value!r}", mend="use numbers or texts")
    if not values or len(set(values)) < len(values):
        why = "it has no value" if not values else "it contains a value twice"
        raise SweepError(f"axis {name!r} cannot be swept", why=why, mend="give each value once")
    if len({isinstance(v, str) for v in values}) > 1:
        raise SweepError(f"axis {name!r} mixes numbers and texts", mend="use one kind for all its values")
