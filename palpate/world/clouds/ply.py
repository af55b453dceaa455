"""PLY files of points: ascii and both binary forms; faces are ignored."""

from __future__ import annotations

from typing import Any

import numpy as np

from palpate.world.clouds.table import Table, columns, stacked
from palpate.world.mesh import ply_elements


def decode(data: bytes, require_count: Any) -> Table:
    """The vertices of a PLY file with their normals and colours.

    Args:
        data: bytes of the file.
        require_count: called with the number of points before they are read.

    Raises:
        ValueError, KeyError, IndexError: the file is damaged, or has no x, y, z.
    """
    content = ply_elements.read(data, ("vertex",), require_count)
    table = content.numbers.get("vertex")
    if table is None:
        raise ValueError("it has no element 'vertex'")
    return Table(
        points=columns(table, "x", "y", "z"),
        normals=columns(table, "nx", "ny", "nz") if "nx" in table else None,
        colors=columns(table, "red", "green", "blue").astype(np.uint8) if "red" in table else None,
        unit=content.unit,
    )


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
