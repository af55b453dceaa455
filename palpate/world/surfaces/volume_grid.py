"""Distance grids from volumes: which volumes hold distances, and their axes along those of the patient frame LPS."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import MeshError, SurfaceError
from palpate.base.values.units import FILE_UNITS
from palpate.world.mesh import volume_files

_STEEPEST = 2.001  # largest difference of neighbouring distances over their spacing: 1, and 1 of rounded ones
_FLATTEST = 0.1  # a smaller largest difference: the distances have another unit than the spacing
_MOST = 10_000_000
_FEW = 0.01  # share of neighbours that may differ by more: medial surfaces, noise
_PARALLEL = 1e-4  # largest sine of the angle between an axis of the grid and one of space

Grid = tuple[npt.NDArray[np.float32], Array, Array]


def read(path: Path, unit: str) -> Grid:
    """Values (nx, ny, nz), origin (3,) and spacing (3,) in LPS [m].

    Args:
        path: the file.
        unit: unit of its lengths and distances, if its header states none.

    Raises:
        SurfaceError: the file cannot be read, holds labels or intensities, or its axes are oblique.
        MissingExtraError: the extra `files` is not installed.
    """
    image = _image(path)
    volume_files.tell_doubts(image, path)
    values = image.layer(0)
    scale = 1e3 * FILE_UNITS[unit] if image.mm is None else image.mm  # [mm]
    why = _no_distances(image)
    if why:
        mend = "a segmentation or CT is read as a surface, mesh: FILE, with label: or threshold: where it needs them"
        raise SurfaceError("its values are no signed distances", where=str(path), why=why, mend=mend)
    X = image.X_PI.copy()
    X[:3] *= 1e-3 * scale
    return _along_axes(path, values.astype(np.float32) * np.float32(1e-3 * scale), X)


def holds_distances(path: Path) -> bool:
    """Whether a volume holds signed distances, not labels or intensities.

    True also for a file that cannot be read: `read` then says why.
    """
    try:
        return not _no_distances(_image(path))
    except (SurfaceError, MeshError):
        return True


def _image(path: Path) -> volume_files.Image:
    try:
        return volume_files.read(path)
    except MeshError as error:
        raise SurfaceError(error.what, where=str(path), why=error.why, mend=error.mend) from None


def _no_distances(image: volume_files.Image) -> str:
    """Why the values are not signed distances; empty if they may be."""
    values = image.layer(0)
    finite = values[np.isfinite(values)] if np.issubdtype(values.dtype, np.floating) else values
    if image.layers > 1:
        return f"it has {image.layers} layers"
    if not finite.size or len(finite.ravel()) < values.size:
        return f"{values.size - finite.size:,} of {values.size:,} values are not finite"
    if float(finite.min()) >= 0.0:
        kind = "whole numbers" if image.labels is not None else "numbers"
        return f"they are {kind} from {finite.min():g} to {finite.max():g}: none is negative, as inside"
    slopes = _slopes(values, np.linalg.norm(image.X_PI[:3, :3], axis=0))
    if (slopes > _STEEPEST).mean() > _FEW or (slopes.size and slopes.max() < _FLATTEST):
        steepest = float(np.percentile(slopes, 99))
        return f"neighbours differ by {steepest:.3g} times their distance, which is 1 for distances in the file's unit"
    return ""


def _slopes(values: npt.NDArray[np.generic], spacing: Array) -> npt.NDArray[np.float32]:
    """Differences of neighbours over their distances, of some ten million neighbours at most."""
    skip = max(1, round((values.size / _MOST) ** 0.5))
    found = []
    for k in range(3):
        lines = values[tuple(slice(None) if axis == k else slice(None, None, skip) for axis in range(3))]
        found.append((np.abs(np.diff(lines.astype(np.float32), axis=k)) / np.float32(spacing[k])).ravel())
    return np.concatenate(found)


def _along_axes(path: Path, values: npt.NDArray[np.float32], X: Array) -> Grid:
    """The grid with ascending axes x, y, z; X (4, 4) from indices to space [m]."""
    spacing = np.linalg.norm(X[:3, :3], axis=0)
    turn = X[:3, :3] / spacing
    order = np.argmax(np.abs(turn), axis=0)  # axis of space of each index
    straight = np.zeros((3, 3))
    straight[order, range(3)] = np.sign(turn[order, range(3)])
    if len(set(order.tolist())) < 3 or np.abs(turn - straight).max() > _PARALLEL:
        mend = "resample it along them, e.g. by 3D Slicer's Resample module or SimpleITK.Resample"
        raise SurfaceError("its axes are oblique to those of the patient", where=str(path), mend=mend)
    origin = X[:3, 3].copy()
    for k in range(3):
        if turn[order[k], k] < 0.0:
            values = np.flip(values, k)
            origin = origin + X[:3, k] * (values.shape[k] - 1)
    index = np.argsort(order)  # index along each axis of space
    return np.ascontiguousarray(values.transpose(index)), origin, spacing[index]
