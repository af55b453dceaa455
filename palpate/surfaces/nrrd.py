"""NRRD files of distances, with attached header, raw or gzip data, and axes parallel to those of space."""

from __future__ import annotations

import math
import re
import zlib
from pathlib import Path

import numpy as np
import numpy.typing as npt

from palpate import limits
from palpate.arrays import Array
from palpate.errors import SurfaceError
from palpate.values.units import FILE_UNITS

_TYPES = {"float": "f4", "double": "f8", "short": "i2", "int16": "i2", "int": "i4", "int32": "i4"}
_VECTOR = re.compile(r"\(([^)]*)\)")


def read(path: Path, unit: str) -> tuple[npt.NDArray[np.float32], Array, Array]:
    """Read values (nx, ny, nz), origin (3,) and spacing (3,), all in metres.

    Raises:
        SurfaceError: the file is not NRRD, has an unsupported encoding or type, or less data than its header states.
    """
    try:
        head, _, data = limits.read_bytes(path).partition(b"\n\n")
        if not head.startswith(b"NRRD"):
            raise ValueError("it does not begin with NRRD")
        lines = (line.partition(":") for line in head.decode("ascii").splitlines()[1:] if not line.startswith("#"))
        field = {key.strip().lower(): value.strip() for key, colon, value in lines if colon}
        sizes = tuple(int(n) for n in field["sizes"].split())
        origin, spacing = _space(field)
        scale = FILE_UNITS[_unit(field, unit)]
        count, kind = math.prod(sizes), _dtype(field)
        limits.require_unpacked(count * kind.itemsize)
        values = np.frombuffer(_decoded(field, data, count * kind.itemsize), kind, count)
    except KeyError as error:
        raise SurfaceError(f"the header lacks {error}", where=str(path), mend="write it again") from None
    except (OSError, ValueError, zlib.error, EOFError) as error:
        raise SurfaceError(
            "the NRRD file cannot be read", where=str(path), why=str(error), mend="write it again, raw or gzip"
        ) from None
    return (values.reshape(sizes, order="F") * scale).astype(np.float32), scale * origin, scale * spacing


def is_segmentation(path: Path) -> bool:
    """Whether the file is NRRD with values without a sign, which are labels and no distances."""
    try:
        limits.require_file(path)
        with path.open("rb") as file:
            head = file.read(4096)
    except OSError:
        return False
    return head.startswith(b"NRRD") and re.search(rb"\ntype:\s*(u|unsigned )", head) is not None


def _space(field: dict[str, str]) -> tuple[Array, Array]:
    if "space directions" in field:
        rows = np.array([[float(x) for x in v.split(",")] for v in _VECTOR.findall(field["space directions"])])
        spacing = np.diag(rows) if rows.shape == (3, 3) else np.zeros(3)
        if rows.shape != (3, 3) or (rows != np.diag(spacing)).any() or (spacing <= 0).any():
            raise ValueError("its axes are not parallel to those of space; resample it along x, y, z")
    else:
        spacing = np.array([float(x) for x in field["spacings"].split()])
    found = _VECTOR.search(field.get("space origin", "(0, 0, 0)"))
    return np.array([float(x) for x in found[1].split(",")]) if found else np.zeros(3), spacing


def _unit(field: dict[str, str], unit: str) -> str:
    named = re.findall(r'"([^"]+)"', field.get("space units", ""))
    return named[0] if named and named[0] in FILE_UNITS else unit


def _dtype(field: dict[str, str]) -> np.dtype[np.generic]:
    if field["type"] not in _TYPES:
        why = (
            "a segmentation is read as a surface, mesh: FILE"
            if "char" in field["type"] or "uint" in field["type"]
            else ""
        )
        raise ValueError(
            f"values of type {field['type']} are no distances; float, double, short and int are read. {why}"
        )
    return np.dtype(("<" if field.get("endian", "little") == "little" else ">") + _TYPES[field["type"]])


def _decoded(field: dict[str, str], data: bytes, size: int) -> bytes:
    if field["encoding"] == "raw":
        return data
    if field["encoding"] in ("gzip", "gz"):
        return limits.gunzip(data, size)
    raise ValueError(f"encoding {field['encoding']}; raw and gzip are read")
