"""Write NetCDF-3 files with common conventions: coordinates, ``units``, ``long_name``, texts as characters."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.io import netcdf_file

from palpate.base.errors import OutputError, SweepError
from palpate.base.sweep.grid import Grid


def write(
    file: Path,
    grid: Grid,
    arrays: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, str | int],
    labels: Mapping[str, tuple[str, str]],
) -> None:
    """Write arrays over a grid with labels (unit, words) by name. The file is replaced atomically.

    Raises:
        SweepError: an array has the name of an axis.
        OutputError: the file cannot be written.
    """
    if clash := sorted(arrays.keys() & grid.axes.keys()):
        raise SweepError(f"{clash} name both an axis and a value", mend="rename the value that fn returns")
    draft = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        with netcdf_file(draft, "w", version=2) as out:
            for name, value in {"title": f"{attributes['fn']} over its grid", **attributes}.items():
                setattr(out, name, value if isinstance(value, str) or abs(value) < 2**31 else str(value))
            dimensions = tuple(map(safe, grid.axes))
            for name, axis in grid.axes.items():
                out.createDimension(safe(name), len(axis.values))
                _variable(out, name, np.array(axis.values), (safe(name),), axis.unit, axis.words)
            for name, array in arrays.items():
                _variable(out, name, array, dimensions, *labels.get(name, ()))
        os.replace(draft, file)
    except OSError as error:
        raise OutputError("the file cannot be written", where=str(file), why=error.strerror or str(error)) from None
    finally:
        draft.unlink(missing_ok=True)


def safe(name: str) -> str:
    """The name with all characters replaced that NetCDF does not allow."""
    clean = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return clean if clean[:1].isalpha() else f"v{clean}"


def _variable(
    out: netcdf_file, name: str, array: NDArray[Any], dimensions: tuple[str, ...], unit: str = "", words: str = ""
) -> None:
    name = safe(name)
    if array.dtype.kind == "U":
        array = np.char.encode(array, "utf-8")
        array = array[..., None].view("S1") if array.dtype.itemsize > 1 else array.astype("S1")[..., None]
    elif array.dtype.kind in "bi":
        array = array.astype("i4" if np.abs(array).max(initial=0) < 2**31 else "f8")
    extra = array.shape[len(dimensions) :]
    for k, length in enumerate(extra):
        dimension = f"{name}_{'length' if array.dtype.kind == 'S' and k == len(extra) - 1 else k}"
        out.createDimension(dimension, length)
        dimensions = (*dimensions, dimension)
    variable = out.createVariable(name, array.dtype, dimensions)
    variable[...] = array
    encoding = "utf-8" if array.dtype.kind == "S" else ""  # xarray and netCDF4 read this attribute
    for key, text in (("units", unit), ("long_name", words), ("_Encoding", encoding)):
        if text:
            setattr(variable, key, text)
