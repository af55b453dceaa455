"""A point cloud, checked once when it is made."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import CloudError
from palpate.world.clouds import files
from palpate.world.clouds.table import MAX_POINTS, Colors, Table, Unit, require_count

__all__ = ["MAX_POINTS", "PointCloud"]

#: Largest magnitude of a coordinate [m].
MAX_COORDINATE = 1e4


class PointCloud:
    """Points on a surface, for example from a depth camera, a scanner or a tracked probe.

    Points with a coordinate that is not finite, which depth cameras send where they see nothing, are left out together
    with their normals and colours; `invalid` counts them.

    Args:
        points: (N, 3) positions [m].
        normals: (N, 3) outward normals of any length; None: unknown.
        colors: (N, 3) red, green, blue, 0 to 255; None: unknown.
        viewpoint: (3,) position of the sensor in the frame of the points [m], towards which normals are oriented;
            None: unknown.
        name: name in plots and messages.

    Raises:
        CloudError: no valid point, a wrong shape, too many points, or coordinates beyond ``MAX_COORDINATE``.
    """

    points: Array  #: (N, 3) [m], finite
    normals: Array | None  #: (N, 3) outward unit normals
    colors: Colors | None  #: (N, 3) red, green, blue
    viewpoint: Array | None  #: (3,) position of the sensor [m]
    invalid: int  #: number of points left out because a coordinate was not finite

    def __init__(
        self,
        points: npt.ArrayLike,
        normals: npt.ArrayLike | None = None,
        colors: npt.ArrayLike | None = None,
        *,
        viewpoint: npt.ArrayLike | None = None,
        name: str = "cloud",
    ) -> None:
        self.name = name
        p = _rows("points", points, np.float64, name)
        n = None if normals is None else _rows("normals", normals, np.float64, name, len(p))
        c = None if colors is None else _rows("colors", colors, np.uint8, name, len(p))
        valid = np.isfinite(p).all(axis=1)
        if n is not None:
            length = np.linalg.norm(n, axis=1)
            valid &= np.isfinite(length) & (length > 0.0)
            n = n / np.where(valid, length, 1.0)[:, None]
        self.invalid = int(len(p) - valid.sum())
        self.points = _require_points(p[valid] if self.invalid else p, len(p), name)
        self.normals = n if n is None else np.asarray(n[valid])
        self.colors = c if c is None else np.asarray(c[valid])
        self.viewpoint = None if viewpoint is None else _position(viewpoint, name)

    @classmethod
    def load(cls, path: str | os.PathLike[str], unit: Unit | None = None) -> PointCloud:
        """Read a file: .pcd, .ply, .npz, .npy, .xyz, .txt or .csv.

        Args:
            path: the file.
            unit: unit of its numbers. Files that Palpate wrote state their unit; for every other file it is required,
                because no format of point clouds defines one.

        Raises:
            CloudError: the file cannot be read, is damaged, or has no unit.
        """
        table = files.load(Path(path), unit)
        return cls(table.points, table.normals, table.colors, viewpoint=table.viewpoint, name=Path(path).stem)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file in metres, with the unit stated in it: .pcd, .ply, .npz, .xyz or .csv.

        Raises:
            OutputError: the file cannot be written. CloudError: the format is unknown.
        """
        files.save(Table(self.points, self.normals, self.colors, self.viewpoint, "m"), Path(path))

    def transformed(self, X: npt.ArrayLike) -> PointCloud:
        """The cloud in another frame: X (4, 4) is the pose of the present frame in the new one [m]."""
        pose = np.asarray(X, dtype=np.float64)
        R, p = pose[:3, :3], pose[:3, 3]
        normals = None if self.normals is None else self.normals @ R.T
        seen_from = None if self.viewpoint is None else R @ self.viewpoint + p
        return PointCloud(self.points @ R.T + p, normals, self.colors, viewpoint=seen_from, name=self.name)

    @property
    def bounds(self) -> Array:
        """Lowest and highest corner (2, 3) [m]."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    def __len__(self) -> int:
        """Number of valid points."""
        return len(self.points)

    def __repr__(self) -> str:
        """Name, number of points and size."""
        size = " x ".join(f"{1e3 * s:.0f}" for s in np.ptp(self.points, axis=0))
        return f"<PointCloud {self.name!r}: {len(self):,} points, {size} mm>"


def _rows(what: str, values: npt.ArrayLike, dtype: npt.DTypeLike, name: str, n: int | None = None) -> Array:
    try:
        array = np.ascontiguousarray(values, dtype=dtype)
    except (TypeError, ValueError) as error:
        raise CloudError(f"{what} must be an array of numbers", where=name, why=str(error)) from None
    if array.ndim == 3 and array.shape[2] == 3 and n is None:
        array = array.reshape(-1, 3)  # an organised cloud: rows and columns of a depth image
    if array.ndim != 2 or array.shape[1] != 3 or (n is not None and len(array) != n):
        expected = "(N, 3)" if n is None else f"({n}, 3), one row for each point"
        raise CloudError(f"{what} must have shape {expected}, got {array.shape}", where=name)
    require_count(len(array), name)
    return array


def _require_points(valid: Array, given: int, name: str) -> Array:
    if not len(valid):
        what = f"none of the {given:,} points is finite" if given else "the cloud has zero points"
        why = "the camera saw nothing within its range" if given else ""
        raise CloudError(what, where=name, why=why, mend="record it again, nearer to the object")
    worst = float(np.abs(valid).max())
    if worst > MAX_COORDINATE:
        raise CloudError(
            f"a coordinate of {worst:.3g} m is beyond {MAX_COORDINATE:g} m",
            where=name,
            why="the numbers are in another unit, or the point is invalid",
            mend="give the unit of the file, e.g. unit: mm",
        )
    return valid


def _position(viewpoint: npt.ArrayLike, name: str) -> Array:
    v = np.asarray(viewpoint, dtype=np.float64)
    if v.shape != (3,) or not np.isfinite(v).all():
        raise CloudError(f"viewpoint must be three finite numbers [m], got {viewpoint!r}", where=name)
    return v
