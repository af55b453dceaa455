"""The columns of a cloud's file, as the readers of all formats return them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import CloudError

Unit = Literal["mm", "cm", "m", "in"]
#: Thickness of the solid layer behind the points of a surface [m].
THICKNESS = 0.02
Colors = npt.NDArray[np.uint8]

#: Largest number of points of a cloud.
MAX_POINTS = 20_000_000


@dataclass(frozen=True)
class Table:
    """Columns of a file, in the file's unit."""

    points: Array  #: (N, 3)
    normals: Array | None = None  #: (N, 3)
    colors: Colors | None = None  #: (N, 3), 0 to 255
    viewpoint: Array | None = None  #: (3,)
    unit: str | None = None  #: unit that the file states; None: it states none


def columns(table: Mapping[str, Any], *names: str) -> Array:
    """The named columns, side by side.

    Raises:
        ValueError: a column is missing.
    """
    missing = [name for name in names if name not in table]
    if missing:
        raise ValueError(f"column {missing[0]!r} is missing; the columns are {', '.join(table) or 'none'}")
    return np.stack([np.asarray(table[name], dtype=np.float64) for name in names], axis=1)


def colours_of_packed(packed: Any) -> Colors:
    """Colours (N, 3) of integers 0x00RRGGBB, which PCL also stores in the bits of a float."""
    bits = packed.view("<u4") if packed.dtype.kind == "f" else packed.astype("<u4")
    return np.stack([bits >> 16 & 255, bits >> 8 & 255, bits & 255], axis=1).astype(np.uint8)


def stacked(columns: Mapping[str, Any]) -> np.ndarray[tuple[int], np.dtype[np.void]]:
    """A structured array (N,) of equally long columns, without padding."""
    rows = np.empty(
        len(next(iter(columns.values()))), np.dtype([(name, values.dtype.str) for name, values in columns.items()])
    )
    for name, values in columns.items():
        rows[name] = values
    return rows


def require_count(n: int, name: str) -> None:
    """Refuse more points than ``MAX_POINTS``, before memory for them is allocated.

    Raises:
        CloudError: there are too many.
    """
    if n > MAX_POINTS:
        raise CloudError(
            f"{n:,} points are more than {MAX_POINTS:,}",
            where=name,
            why="a haptic surface needs about one point per square millimetre",
            mend="thin the cloud, e.g. by a voxel grid of 1 mm, or cut out the part that is touched",
        )
