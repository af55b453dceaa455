"""PLY files of points: ascii and both binary forms; faces are ignored."""

from __future__ import annotations

from typing import Any

import numpy as np

from palpate.clouds.table import Table, columns, stacked

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
    "double": "f8", "float64": "f8",
}  # fmt: skip
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": "<"}


def decode(data: bytes, require_count: Any) -> Table:
    """The vertices of a PLY file with their normals and colours.

    Args:
        data: bytes of the file.
        require_count: called with the number of points before they are read.

    Raises:
        ValueError, KeyError, IndexError: the file is damaged, or has no x, y, z.
    """
    end = data.find(b"end_header")
    if not data.startswith(b"ply") or end < 0:
        raise ValueError("it has no PLY header")
    lines = [line.split() for line in data[:end].decode("ascii", "replace").splitlines()]
    body = data[data.index(b"\n", end) + 1 :]
    form = next(line[1] for line in lines if line[:1] == ["format"])
    unit = next((line[2] for line in lines if line[:2] == ["comment", "unit"]), None)
    n, fields = _vertices(lines)
    require_count(n)
    dtype = np.dtype([(name, _ORDERS[form] + _TYPES[kind]) for kind, name in fields])
    if form == "ascii":
        words = body.split()[: n * len(fields)]
        if len(words) < n * len(fields):
            raise ValueError(f"{n:,} points of {len(fields)} numbers are promised, {len(words):,} numbers are present")
        numbers = np.array(words, dtype=np.float64).reshape(n, len(fields))
        table = {name: numbers[:, i] for i, (_, name) in enumerate(fields)}
    else:
        if len(body) < n * dtype.itemsize:
            raise ValueError(f"{n:,} points of {dtype.itemsize} bytes are promised, {len(body):,} bytes are present")
        rows = np.frombuffer(body, dtype, n)
        table = {name: rows[name] for name in dtype.names or ()}
    return Table(
        points=columns(table, "x", "y", "z"),
        normals=columns(table, "nx", "ny", "nz") if "nx" in table else None,
        colors=columns(table, "red", "green", "blue").astype(np.uint8) if "red" in table else None,
        unit=unit,
    )


def _vertices(lines: list[list[str]]) -> tuple[int, list[tuple[str, str]]]:
    """Number of vertices, and type and name of each of their properties; the vertices must come first."""
    starts = [i for i, line in enumerate(lines) if line[:1] == ["element"]]
    if not starts or lines[starts[0]][1] != "vertex":
        raise ValueError("its first element is not 'vertex'")
    fields = []
    for line in lines[starts[0] + 1 : starts[1] if len(starts) > 1 else None]:
        if line[:1] == ["property"]:
            if line[1] == "list":
                raise ValueError("its vertices have lists as properties")
            fields.append((line[1], line[2]))
    return int(lines[starts[0]][2]), fields


def encode(table: Table) -> bytes:
    """Bytes of a binary PLY file in metres."""
    parts: list[tuple[str, str, Any]] = [
        ("float", axis, table.points[:, i].astype("<f4")) for i, axis in enumerate("xyz")
    ]
    if table.normals is not None:
        parts += [("float", f"n{axis}", table.normals[:, i].astype("<f4")) for i, axis in enumerate("xyz")]
    if table.colors is not None:
        parts += [("uchar", name, table.colors[:, i]) for i, name in enumerate(("red", "green", "blue"))]
    rows = stacked({name: values for _, name, values in parts})
    head = ["ply", "format binary_little_endian 1.0", "comment unit m", f"element vertex {len(rows)}"]
    head += [f"property {kind} {name}" for kind, name, _ in parts]
    return "\n".join([*head, "end_header"]).encode() + b"\n" + rows.tobytes()
