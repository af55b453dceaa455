"""sensor_msgs/PointCloud2: its points as arrays, and arrays as its fields. The message may come from ROS 2 or a bag."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.errors import CloudError
from palpate.world.clouds import MAX_POINTS

_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}  # sensor_msgs/PointField


@dataclass(frozen=True)
class Decoded:
    """Points of a message."""

    points: npt.NDArray[np.float32]
    """(N, 3), or (rows, columns, 3) of an organised cloud, in the frame of the message [m]"""
    colors: npt.NDArray[np.uint8] | None
    """(N, 3) red, green, blue"""


def decode(message: Any) -> Decoded:
    """Points and colours of a PointCloud2; REP 103: in metres.

    Raises:
        CloudError: sizes that contradict each other, a truncated message, or no x, y, z.
    """
    where = f"cloud in {message.header.frame_id!r}"
    fields = {field.name: field for field in message.fields}
    if missing := [axis for axis in "xyz" if axis not in fields]:
        why = f"its fields: {', '.join(fields)}"
        raise CloudError(f"the message has no field {missing[0]!r}", where=where, why=why)
    rows, columns = int(message.height), int(message.width)
    step, row_step, data = int(message.point_step), int(message.row_step), np.asarray(message.data, dtype=np.uint8)
    if rows * columns > MAX_POINTS:
        raise CloudError(f"{rows * columns:,} points are more than {MAX_POINTS:,}", where=where, mend="thin the cloud")
    if row_step < columns * step or len(data) < rows * row_step or step <= 0:
        why = f"{rows} rows of {columns} points, point_step {step}, row_step {row_step}, {len(data)} bytes"
        raise CloudError("the sizes in the message contradict each other", where=where, why=why)
    order = ">" if message.is_bigendian else "<"
    table = data[: rows * row_step].reshape(rows, row_step)[:, : columns * step].reshape(-1, step)
    axes = [_column(table, fields[axis], order, where).astype(np.float32) for axis in "xyz"]
    points = np.stack(axes, axis=-1)
    packed = fields.get("rgb") or fields.get("rgba")
    colors = None
    if packed is not None and packed.offset + 4 <= step:
        word = np.ascontiguousarray(table[:, packed.offset : packed.offset + 4])
        colors = word[:, [1, 2, 3] if message.is_bigendian else [2, 1, 0]]
    return Decoded(points.reshape(rows, columns, 3) if rows > 1 else points, colors)


def _column(table: npt.NDArray[np.uint8], field: Any, order: str, where: str) -> npt.NDArray[Any]:
    kind = np.dtype(order + _TYPES.get(int(field.datatype), "V0"))
    if kind.itemsize == 0 or field.offset + kind.itemsize > table.shape[1]:
        what = f"field {field.name!r} with datatype {field.datatype} at byte {field.offset} is not in a point"
        raise CloudError(what, where=where, why=f"a point has {table.shape[1]} bytes")
    part = np.ascontiguousarray(table[:, field.offset : field.offset + kind.itemsize])
    return part.view(kind)[:, 0]


def fields_of(
    points: npt.NDArray[np.floating], colors: npt.NDArray[np.uint8] | None
) -> tuple[list[tuple[str, int, int, int]], int, npt.NDArray[np.uint8]]:
    """Fields (name, offset, datatype, count), point_step and data of a PointCloud2 with points (..., 3) [m].

    colors: (..., 3) red, green, blue; as field `rgb`, whose bytes are blue, green, red, as PCL and RViz read them.
    """
    fields = [("x", 0, 7, 1), ("y", 4, 7, 1), ("z", 8, 7, 1)]
    p = np.ascontiguousarray(points.reshape(-1, 3), dtype="<f4").view(np.uint8).reshape(-1, 12)
    if colors is None:
        return fields, 12, p.reshape(-1)
    table = np.zeros((len(p), 16), dtype=np.uint8)
    table[:, :12], table[:, 12:15] = p, colors.reshape(-1, 3)[:, ::-1]
    return [*fields, ("rgb", 12, 7, 1)], 16, table.reshape(-1)
