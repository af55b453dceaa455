"""PCD files, the point clouds of PCL: ascii, binary, and binary_compressed (LZF)."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from palpate.base import limits
from palpate.world.clouds.table import Table, colours_of_packed, columns, stacked

_TYPES = {"F": "f", "I": "i", "U": "u"}


def decode(data: bytes, require_count: Any) -> Table:
    """The points of a PCD file, and its viewpoint where the header states one.

    Args:
        data: bytes of the file.
        require_count: called with the number of points before they are read.

    Raises:
        ValueError, KeyError, IndexError, struct.error: the file is damaged, or has no x, y, z.
    """
    head, body, unit = _header(data)
    dtype = np.dtype([
        (name, f"<{_TYPES[kind]}{size}", (int(count),))
        for name, kind, size, count in zip(_names(head), head["TYPE"], head["SIZE"], head["COUNT"], strict=True)
    ])  # fmt: skip
    n = int(head["POINTS"][0])
    require_count(n)
    limits.require_unpacked(n * dtype.itemsize)
    rows = _decoded(head["DATA"][0], body, dtype, n)
    table = {name: rows[name][:, 0] for name in dtype.names or ()}
    packed = table.get("rgb", table.get("rgba"))
    pose = [float(x) for x in head.get("VIEWPOINT", [])]
    # PCL writes a rotation of zero length where it does not know the viewpoint; the points are in the sensor's frame.
    viewpoint = np.array(pose[:3]) if len(pose) == 7 else None
    return Table(
        points=columns(table, "x", "y", "z"),
        normals=columns(table, "normal_x", "normal_y", "normal_z") if "normal_x" in table else None,
        colors=None if packed is None else colours_of_packed(packed),
        viewpoint=viewpoint,
        unit=unit,
    )


def _names(head: dict[str, list[str]]) -> list[str]:
    """Names of the fields; PCL names its padding ``_``, each time again."""
    return [f"_{k}" if name == "_" else name for k, name in enumerate(head["FIELDS"])]


def encode(table: Table) -> bytes:
    """Bytes of a binary PCD file in metres."""
    parts: list[tuple[str, Any]] = [(axis, table.points[:, i].astype("<f4")) for i, axis in enumerate("xyz")]
    if table.normals is not None:
        parts += [(f"normal_{axis}", table.normals[:, i].astype("<f4")) for i, axis in enumerate("xyz")]
    if table.colors is not None:
        r, g, b = table.colors.astype("<u4").T
        parts.append(("rgb", (r << 16 | g << 8 | b).astype("<u4")))
    rows = stacked(dict(parts))
    view = table.viewpoint if table.viewpoint is not None else np.zeros(3)
    lines = [
        "# .PCD v0.7 - Point Cloud Data file format",
        "# unit m",
        "VERSION 0.7",
        f"FIELDS {' '.join(name for name, _ in parts)}",
        f"SIZE {' '.join('4' for _ in parts)}",
        f"TYPE {' '.join('U' if name == 'rgb' else 'F' for name, _ in parts)}",
        f"COUNT {' '.join('1' for _ in parts)}",
        f"WIDTH {len(rows)}",
        "HEIGHT 1",
        *([f"VIEWPOINT {view[0]:.9g} {view[1]:.9g} {view[2]:.9g} 1 0 0 0"] if table.viewpoint is not None else []),
        f"POINTS {len(rows)}",
        "DATA binary",
    ]
    return "\n".join(lines).encode() + b"\n" + rows.tobytes()


def _header(data: bytes) -> tuple[dict[str, list[str]], bytes, str | None]:
    head: dict[str, list[str]] = {}
    at, unit = 0, None
    while "DATA" not in head:
        end = data.find(b"\n", at)
        if end < 0:
            raise ValueError("the header of a PCD file has no line DATA")
        key, *values = data[at:end].decode("ascii", "replace").split() or [""]
        if key == "#" and values[:1] == ["unit"]:
            unit = values[1]
        head[key] = values
        at = end + 1
    for key in ("FIELDS", "SIZE", "TYPE", "POINTS"):
        if key not in head:
            raise ValueError(f"the header has no line {key}")
    head.setdefault("COUNT", ["1"] * len(head["FIELDS"]))
    return head, data[at:], unit


def _decoded(kind: str, body: bytes, dtype: np.dtype[np.void], n: int) -> np.ndarray[tuple[int], np.dtype[np.void]]:
    table = np.zeros(n, dtype)
    if kind == "ascii":
        values = np.array(body.split(), dtype=np.float64).reshape(n, -1)
        at = 0
        for name in dtype.names or ():
            width = dtype[name].shape[0]
            table[name] = values[:, at : at + width]
            at += width
    elif kind == "binary":
        if len(body) < n * dtype.itemsize:
            raise ValueError(f"{n:,} points of {dtype.itemsize} bytes are promised, {len(body):,} bytes are present")
        table[:] = np.frombuffer(body, dtype, n)
    elif kind == "binary_compressed":
        packed, size = struct.unpack("<II", body[:8])
        limits.require_unpacked(size)
        flat, at = lzf(body[8 : 8 + packed], size), 0
        for name in dtype.names or ():  # stored field by field
            part = dtype[name]
            table[name] = np.frombuffer(flat, part.base, n * part.shape[0], at).reshape(n, -1)
            at += n * part.itemsize
    else:
        raise ValueError(f"DATA {kind}; ascii, binary and binary_compressed are read")
    return table


def lzf(data: bytes, size: int) -> bytes:
    """Decompress LZF (Lehmann's liblzf): literal runs and back references.

    Raises:
        ValueError: the data are damaged.
    """
    out, at = bytearray(), 0
    while at < len(data) and len(out) <= size:
        control = data[at]
        at += 1
        if control < 32:
            out += data[at : at + control + 1]
            at += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += data[at]
            at += 1
        back = len(out) - ((control & 31) << 8) - data[at] - 1
        at += 1
        if back < 0:
            raise ValueError("a back reference before the start")
        while length + 2 > 0:
            piece = out[back : back + length + 2]
            out += piece
            length, back = length - len(piece), back + len(piece)
    if len(out) != size:
        raise ValueError(f"{len(out)} bytes instead of {size}")
    return bytes(out)
