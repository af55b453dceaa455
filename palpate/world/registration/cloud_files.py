"""Files of clouds and surfaces as dense points."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.errors import CloudError, RegistrationError
from palpate.base.values.units import FILE_UNITS
from palpate.world.clouds import files as clouds_files
from palpate.world.mesh import files as mesh_files
from palpate.world.registration.clouds import sampled
from palpate.world.registration.files import read_points

_SAMPLES = 20_000  # points of a mesh


def read_cloud(path: Path, unit: str = "m") -> Array:
    """Points (N, 3) [m] of a cloud (.csv, .npy, .pcd), or spread over a mesh (.stl, .ply, .obj, ...).

    Raises:
        RegistrationError, MeshError: the file cannot be read.
    """
    kind = path.suffix.lower()
    if kind == ".csv":
        return read_points(path, unit).p
    if kind == ".pcd":
        return _pcd(path) * FILE_UNITS[unit]
    if kind == ".npy":
        return _array(path) * FILE_UNITS[unit]
    vertices, triangles = mesh_files.read(path)
    return sampled(np.asarray(vertices, dtype=np.float64) * FILE_UNITS[unit], np.asarray(triangles), _SAMPLES)


def _pcd(path: Path) -> Array:
    try:
        points = clouds_files.read(path).points
    except CloudError as error:
        raise RegistrationError(error.what, where=error.where, why=error.why, mend=error.mend) from None
    return np.asarray(points[np.isfinite(points).all(axis=1)])


def _array(path: Path) -> Array:
    try:
        return np.asarray(limits.load_npy(limits.read_bytes(path)), dtype=np.float64)
    except (OSError, ValueError) as error:
        raise RegistrationError("the file cannot be read", where=str(path), why=str(error)) from None


def averaged(points: Array, size: float) -> Array:
    """Means of the points in each cell of a grid with this size [m]."""
    cells = np.floor(points / size).astype(np.int64)
    _, index, counts = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(counts), 3))
    np.add.at(sums, index.ravel(), points)
    return np.asarray(sums / counts[:, None])
