"""MetaImage files (.mha, .mhd), as ITK, 3D Slicer and PLUS write them: lengths in mm, axes of the frame LPS."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base import limits
from palpate.base.arrays import Array

_TYPES = {
    "MET_CHAR": "i1", "MET_UCHAR": "u1", "MET_SHORT": "i2", "MET_USHORT": "u2", "MET_INT": "i4", "MET_UINT": "u4",
    "MET_LONG_LONG": "i8", "MET_ULONG_LONG": "u8", "MET_FLOAT": "f4", "MET_DOUBLE": "f8",
}  # fmt: skip
_LONG = {"MET_LONG": "i", "MET_ULONG": "u"}  # four or eight bytes: the data decide
_MOST_LINES = 100_000  # a PLUS sequence has some ten lines per frame
_POSITION = ("offset", "position", "origin")
_TURN = ("transformmatrix", "rotation", "orientation")

Header = dict[str, list[str]]


def read(path: Path) -> tuple[Header, npt.NDArray[Any]]:
    """Header (words by key in lower case) and values, the fastest axis first; channels are an axis before all others.

    Raises:
        ValueError, KeyError, OSError, zlib.error, EOFError: the file is damaged or uses what is not read.
    """
    header, rest = _header(limits.read_bytes(path))
    sizes = [int(n) for n in header["dimsize"]]
    channels = int(header.get("elementnumberofchannels", ["1"])[0])
    sizes = [channels, *sizes] if channels > 1 else sizes
    if min(sizes) < 1 or len(sizes) > 8:
        raise ValueError(f"sizes {sizes}")
    count, kind = math.prod(sizes), header["elementtype"][0].upper()
    if kind not in _TYPES and kind not in _LONG:
        raise ValueError(f"values of type {kind} are not read")
    limits.require_unpacked(count * (np.dtype(_TYPES[kind]).itemsize if kind in _TYPES else 4))
    data = _data(path, header, rest)
    if _is_true(header, "compresseddata"):
        data = limits.gunzip(data, count * (np.dtype(_TYPES[kind]).itemsize if kind in _TYPES else 8))
    if header.get("binarydata", ["true"])[0].lower() == "false":
        values = np.array(data.split()[:count], dtype=np.float64)
    else:
        width = 8 if kind in _LONG and len(data) >= 8 * count else 4
        order = ">" if _is_true(header, "binarydatabyteordermsb", "elementbyteordermsb") else "<"
        dtype = np.dtype(order + (_TYPES[kind] if kind in _TYPES else f"{_LONG[kind]}{width}"))
        limits.require_present(count, dtype.itemsize, len(data), "values")
        values = np.frombuffer(data, dtype, count).astype(dtype.newbyteorder("="))
    if len(values) < count:
        raise ValueError(f"{count:,} values are announced, and {len(values):,} are there")
    return header, values.reshape(sizes, order="F")


def pose(header: Header) -> tuple[Array, tuple[str, ...]]:
    """Voxel indices to LPS (4, 4) [mm], and what the header leaves out.

    Raises:
        ValueError: it has no three axes.
    """
    n = int(header.get("ndims", ["3"])[0])
    spacing = _numbers(header, ("elementspacing", "elementsize"), n, np.ones(n))
    turn = _numbers(header, _TURN, n * n, np.eye(n).ravel()).reshape(n, n)  # one row for each index
    place = _numbers(header, _POSITION, n, np.zeros(n))
    missing = [
        name
        for name, keys in (("TransformMatrix", _TURN), ("Offset", _POSITION))
        if not any(key in header for key in keys)
    ]
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = (turn * spacing[:, None])[:3, :3].T, place[:3]
    if not missing:
        return X, ()
    return X, (f"the header has no {' and no '.join(missing)}: place or turn in the patient are not stated",)


def _header(data: bytes) -> tuple[Header, bytes]:
    header: Header = {}
    at = 0
    for _ in range(_MOST_LINES):
        end = data.find(b"\n", at)
        line = data[at : end if end >= 0 else len(data)].decode("latin-1")
        key, sign, value = line.partition("=")
        if not sign:
            raise ValueError(f"its header has the line {line[:40]!r}, which is no KEY = VALUE")
        header[key.strip().lower()] = value.split()
        at = end + 1
        if key.strip().lower() == "elementdatafile":
            return header, data[at:] if end >= 0 else b""
        if end < 0:
            break
    raise ValueError("its header has no ElementDataFile")


def _data(path: Path, header: Header, rest: bytes) -> bytes:
    name = " ".join(header["elementdatafile"])
    if name.upper() == "LOCAL":
        return rest
    if name.upper().startswith("LIST") or "%" in name or not name:
        raise ValueError("its data lie in several files; write it again into one, e.g. by SimpleITK.WriteImage")
    data = limits.read_bytes(path.parent / name)
    skip = int(header.get("headersize", ["0"])[0])
    if skip >= 0:
        return data[skip:]
    count = math.prod(int(n) for n in header["dimsize"]) * int(header.get("elementnumberofchannels", ["1"])[0])
    return data[-count * np.dtype(_TYPES[header["elementtype"][0].upper()]).itemsize :]


def _numbers(header: Header, keys: tuple[str, ...], count: int, default: Array) -> Array:
    key = next((key for key in keys if key in header), None)
    found = default if key is None else np.array([float(x) for x in header[key]])
    if found.shape != (count,) or count < 3:
        raise ValueError(f"{key or 'NDims'} has {len(found)} numbers")
    return found


def _is_true(header: Header, *keys: str) -> bool:
    return any(header.get(key, ["false"])[:1] == ["True"] or header.get(key, [""])[0].lower() == "true" for key in keys)
