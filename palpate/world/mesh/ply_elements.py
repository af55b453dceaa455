"""Elements of PLY files, ascii and both binary forms, with properties that are lists, in any order.

Clouds are read by this alone. Meshes are read by trimesh, but those whose vertices have lists, which it does not read.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base import limits
from palpate.base.arrays import Array
from palpate.world.mesh.off_file import cut

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": "<"}
_FACES = ("vertex_indices", "vertex_index")


@dataclass
class Content:
    """Elements of a file."""

    unit: str | None  #: of a comment, as Palpate writes it
    numbers: dict[str, dict[str, Any]] = field(default_factory=dict)  #: by element and property, (n,) each
    faces: list[list[int]] = field(default_factory=list)  #: corners of each face


def read(data: bytes, wanted: Sequence[str], require_count: Callable[[int], None] = lambda n: None) -> Content:
    """The elements `wanted`, without their lists but those of corners of faces.

    Args:
        data: bytes of the file.
        wanted: names of elements; those after the last of them are not read.
        require_count: called with the number of vertices before they are read.

    Raises:
        ValueError, KeyError, IndexError, struct.error: the file is damaged, or of an unknown format.
    """
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise ValueError("it has no PLY header")
    lines = [line.split() for line in data[:end].decode("ascii", "replace").splitlines()]
    form = next(line[1] for line in lines if line[:1] == ["format"])
    if form not in _ORDERS:
        raise ValueError(f"format {form}; {', '.join(_ORDERS)} are read")
    body = data[data.index(b"\n", end) + 1 :]
    rest: Any = [line for line in body.split(b"\n") if line.strip()] if form == "ascii" else body
    content = Content(next((line[2] for line in lines if line[:2] == ["comment", "unit"]), None))
    left = set(wanted)
    for element in _elements(lines):
        if element.name == "vertex":
            require_count(element.count)
        found, faces, rest = _ascii(element, rest) if form == "ascii" else _binary(element, rest, _ORDERS[form])
        if element.name in left:
            content.numbers[element.name] = found
            content.faces += faces
            left.remove(element.name)
        if not left:
            break
    return content


def has_vertex_lists(data: bytes) -> bool:
    """Whether the header gives a list to each vertex."""
    head = data[: data.find(b"end_header")].decode("ascii", "replace")
    return any(
        one.name == "vertex" and one.has_lists for one in _elements([line.split() for line in head.splitlines()])
    )


def mesh(data: bytes) -> tuple[Array, npt.NDArray[np.int64]]:
    """Vertices (n, 3) and triangles (m, 3) of a file. Errors as in `read`."""
    content = read(data, ("vertex", "face"))
    table = content.numbers["vertex"]
    vertices = np.stack([np.asarray(table[axis], dtype=np.float64) for axis in "xyz"], axis=1)
    triangles = [triangle for face in content.faces for triangle in cut(vertices, face)]
    found = np.array(triangles, dtype=np.int64).reshape(-1, 3)
    if len(found) and not 0 <= found.min() <= found.max() < len(vertices):
        raise ValueError(f"a face names vertex {found.max()}, there are {len(vertices):,}")
    return vertices, found


@dataclass
class _Element:
    """An element of the header."""

    name: str
    count: int
    fields: list[tuple[str, str, str]] = field(default_factory=list)
    """name, type, and type of the length of a list; empty for one number"""

    @property
    def has_lists(self) -> bool:
        """Whether rows have different lengths."""
        return any(length for *_, length in self.fields)


def _elements(lines: list[list[str]]) -> list[_Element]:
    found: list[_Element] = []
    for line in lines:
        if line[:1] == ["element"]:
            found.append(_Element(line[1], int(line[2])))
        elif line[:2] == ["property", "list"]:
            found[-1].fields.append((line[4], _TYPES[line[3]], _TYPES[line[2]]))
        elif line[:1] == ["property"]:
            found[-1].fields.append((line[2], _TYPES[line[1]], ""))
    return found


def _ascii(element: _Element, lines: list[bytes]) -> tuple[dict[str, Any], list[list[int]], list[bytes]]:
    """Numbers of an element by name, the corners of its faces, and the lines after it; one row is one line."""
    rows: list[list[bytes] | None] = [line.split() for line in lines[: element.count]]
    faces: list[list[int]] = []
    if element.has_lists:
        rows = [_without_lists(element, row or [], faces) for row in rows]
    names = [name for name, _, length in element.fields if not length]
    good = [row[: len(names)] for row in rows if row is not None and len(row) >= len(names)]
    if len(good) < element.count:
        raise ValueError(f"{element.count:,} rows of {element.name} are promised, {len(good):,} are whole")
    numbers = np.array(good, dtype=np.float64).reshape(element.count, len(names))
    return {name: numbers[:, i] for i, name in enumerate(names)}, faces, lines[element.count :]


def _without_lists(element: _Element, row: list[bytes], faces: list[list[int]]) -> list[bytes] | None:
    found, at = [], 0
    for name, _, length in element.fields:
        if at >= len(row):
            return None
        if length:
            count = max(int(row[at]), 0)
            if name in _FACES:
                faces.append([int(word) for word in row[at + 1 : at + 1 + count]])
            at += 1 + count
        else:
            found.append(row[at])
            at += 1
    return found if at <= len(row) else None


def _binary(element: _Element, body: bytes, order: str) -> tuple[dict[str, Any], list[list[int]], bytes]:
    """As `_ascii`, of binary data."""
    if not element.has_lists:
        dtype = np.dtype([(name, order + kind) for name, kind, _ in element.fields])
        size = element.count * dtype.itemsize
        if len(body) < size:
            n, width = element.count, dtype.itemsize
            raise ValueError(f"{n:,} points of {width} bytes are promised, {len(body):,} bytes are present")
        rows = np.frombuffer(body, dtype, element.count) if dtype.itemsize else np.zeros(element.count, dtype)
        return {name: rows[name] for name in dtype.names or ()}, [], body[size:]
    places, faces, end = _places(element, body, order)
    data = np.frombuffer(body, np.uint8)
    table = {}
    for k, (name, kind, length) in enumerate(element.fields):
        if not length:
            width = np.dtype(kind).itemsize
            table[name] = data[places[:, k, None] + np.arange(width)].copy().view(order + kind)[:, 0]
    return table, faces, body[end:]


_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}


def _places(element: _Element, body: bytes, order: str) -> tuple[npt.NDArray[np.int64], list[list[int]], int]:
    """Position (n, fields) of each property, the corners of faces, and the end; lists make rows of other lengths."""
    widths = [np.dtype(kind).itemsize for _, kind, _ in element.fields]
    reads = [struct.Struct(order + _CODES[length]) if length else None for *_, length in element.fields]
    least = sum(width if read is None else read.size for width, read in zip(widths, reads, strict=True))
    limits.require_present(element.count, least, len(body), "rows with lists")
    places, at, faces = np.empty((element.count, len(widths)), np.int64), 0, []
    for i in range(element.count):
        for k, (width, read) in enumerate(zip(widths, reads, strict=True)):
            places[i, k] = at
            if read is None:
                at += width
                continue
            if at + read.size > len(body):
                at = len(body) + 1
                break
            count = max(int(read.unpack_from(body, at)[0]), 0)
            name, kind, _ = element.fields[k]
            if name in _FACES and at + read.size + width * count <= len(body):
                corners = struct.unpack_from(f"{order}{count}{_CODES[kind]}", body, at + read.size)
                faces.append([int(corner) for corner in corners])
            at += read.size + width * count
        if at > len(body):
            raise ValueError(f"{element.count:,} rows of {element.name} are promised, the data end in row {i:,}")
    return places, faces, at
