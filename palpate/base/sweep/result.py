"""The result of a sweep as rows, numpy arrays, a NetCDF file, or a CSV table."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from palpate.base.errors import OutputError
from palpate.base.sweep.grid import Grid
from palpate.base.sweep.work import Values


class Label(NamedTuple):
    """Unit and description of a value that the function returns."""

    unit: str = ""
    words: str = ""


@dataclass(frozen=True)
class Swept:
    """Values over a grid. Points that were left out or have failed are absent from ``values``."""

    grid: Grid
    values: dict[int, Values]
    """Returned values in plain types by the index of the point, in ascending order."""
    attributes: dict[str, str | int]
    """Origin of the values: ``fn``, ``seed``, ``version``."""
    labels: Mapping[str, Label] = field(default_factory=dict)
    errors: dict[int, str] = field(default_factory=dict)
    """Error message by the index of the failed point (``on_error="keep"``)."""

    def rows(self) -> list[Values]:
        """Each point with its values, in the order of the grid."""
        return [self.grid.point(index) | values for index, values in self.values.items()]

    def array(self, name: str) -> NDArray[Any]:
        """One value over the whole grid, with the shape of the grid (lists add axes at the end).

        Numbers become floats, with NaN at absent points. Texts are empty at absent points. Keys of nested dictionaries
        are joined by ``_``.

        Raises:
            KeyError: no value has this name.
        """
        return self.arrays()[name]

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays of all values, by name (see ``array``)."""
        flat = {index: flatten(values) for index, values in self.values.items()}
        names = dict.fromkeys(name for values in flat.values() for name in values)
        return {name: self._array({i: v[name] for i, v in flat.items() if v.get(name) is not None}) for name in names}

    def _array(self, given: dict[int, Any]) -> NDArray[Any]:
        values = np.array(list(given.values())) if given else np.zeros(0)  # ValueError: lists of different lengths
        numbers = values.dtype.kind in "bif"
        out = np.full(
            (len(self.grid), *values.shape[1:]), np.nan if numbers else "", float if numbers else values.dtype
        )
        out[list(given)] = values
        return out.reshape(*self.grid.shape, *values.shape[1:])

    def to_netcdf(self, file: Path | str) -> None:
        """Write a NetCDF-3 file with labels and units; xarray, Matlab, Julia, R and ncdump can read it.

        Raises:
            SweepError: a value has the name of an axis.
            OutputError: the file cannot be written.
        """
        from palpate.base.sweep.netcdf import write

        write(Path(file), self.grid, self.arrays(), self.attributes, self.labels)

    def to_csv(self, file: Path | str) -> None:
        """Write a CSV table with one row per point; lists and dictionaries become columns.

        Raises:
            OutputError: the file cannot be written.
        """
        rows = [_columns(row) for row in self.rows()]
        try:
            with Path(file).open("w", newline="", encoding="utf-8") as stream:
                out = csv.DictWriter(stream, list(dict.fromkeys(name for row in rows for name in row)))
                out.writeheader()
                out.writerows(rows)
        except OSError as error:
            raise OutputError("the table cannot be written", where=str(file), why=error.strerror or "") from None


def flatten(values: Mapping[str, Any]) -> Values:
    """Values without nested dictionaries; nested keys become ``outer_inner``."""
    flat: Values = {}
    for name, value in values.items():
        inner = flatten({f"{name}_{k}": v for k, v in value.items()}) if isinstance(value, dict) else {name: value}
        flat.update(inner)
    return flat


def _columns(row: Mapping[str, Any]) -> Values:
    flat = flatten(row)
    while any(isinstance(value, list) for value in flat.values()):
        flat = flatten({n: dict(enumerate(v)) if isinstance(v, list) else v for n, v in flat.items()})
    return flat
