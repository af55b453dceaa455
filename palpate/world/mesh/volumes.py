"""Surfaces of segmentations and CT volumes, in millimetres of the patient frame LPS.

The patient frame is that of DICOM, and of the surfaces that 3D Slicer writes: x to the left, y to posterior, z to
superior. A file in another frame is converted (`palpate.world.mesh.volume_files`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.errors import MeshError, MissingExtraError
from palpate.world.mesh.volume_files import ENDINGS, Image, Volume, is_volume, read, tell_doubts

__all__ = ["ENDINGS", "Selection", "is_volume", "surface"]

_LABELS_SHOWN = 12
_MOST_LABELS = 64
_SMOOTHING = 0.8  # standard deviation of the Gaussian that rounds the steps of a label map [voxels]


@dataclass(frozen=True)
class Selection:
    """Part of a volume: a label of a segmentation, or all values from a threshold."""

    label: int | str | None = None  # value or name of a segment
    threshold: float | None = None  # in the file's own values, e.g. Hounsfield units


def surface(path: Path, selection: Selection) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Closed surface of a segment, or of the values from a threshold: vertices (n, 3) [mm] and triangles (m, 3).

    Values that are not finite count as outside.

    Raises:
        MeshError: the file cannot be read, the label is absent or ambiguous, or the selection is empty.
        MissingExtraError: the extra `files` is not installed.
    """
    image = read(path)
    tell_doubts(image, path)
    if selection.threshold is not None:
        level, values = float(selection.threshold), _finite(image.layer(0), float(selection.threshold))
        found = values >= level
        what = f"threshold {level:g}"
        low = min(float(values.min()), level - 1.0)
        if found.all():
            mend = "give a value between the smallest and the largest"
            raise MeshError(f"all voxels have {what}", where=str(path), why=_range(image), mend=mend)
    else:
        labels = image.labels
        if labels is None:
            what = "this is an image of continuous values, not a segmentation"
            mend = "add threshold: VALUE, e.g. 200 for bone in CT"
            raise MeshError(what, where=str(path), why=_range(image), mend=mend)
        image = replace(image, values=labels)
        layer, label = _label(image, selection.label, path)
        found, level, low, what = image.layer(layer) == label, 0.5, 0.0, f"label {label}"
        values = found
    if not found.any():
        raise MeshError(f"no voxel has {what}", where=str(path), why=_range(image), mend="choose another value")
    corner, values = _cropped(values, found, low)
    X = image.X_PI.copy()
    X[:3] *= image.mm or 1.0  # where the file states no unit, it is mm, as in all programs of this field
    return _contour(values, level, corner, X, path, smooth=selection.threshold is None)


def _finite(values: Volume, level: float) -> Volume:
    """The same with background in place of values that are not finite: 0, or less than a threshold below 0."""
    if not np.issubdtype(values.dtype, np.floating):
        return values
    good = np.isfinite(values)
    if good.all():
        return values
    lowest = float(values[good].min()) if good.any() else level - 1.0
    return np.where(good, values, 0.0 if level > 0.0 else min(lowest, level - 1.0))


def _contour(
    values: Volume,
    level: float,
    corner: npt.NDArray[np.int64],
    X_PI: npt.NDArray[np.float64],
    path: Path,
    smooth: bool,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Surface of values above a level, with vertices in LPS [mm] and triangles counter-clockwise from outside."""
    from scipy.ndimage import gaussian_filter

    try:
        from skimage.measure import marching_cubes
    except ImportError:
        raise MissingExtraError(f"the surface of {path.suffix} files", "files") from None
    grid = values.astype(np.float32)
    if smooth:
        count = int(np.count_nonzero(grid > level))
        grid = gaussian_filter(grid, _SMOOTHING)
        around = -np.partition(-grid, (count - 1, count), axis=None)[count - 1 : count + 1]
        level = float(around.mean())  # as many voxels as before are inside: small segments keep their volume
    contour: Any = marching_cubes  # the library has no types
    vertices, triangles, *_ = contour(grid, level, gradient_direction="ascent")
    points = (vertices + corner) @ X_PI[:3, :3].T + X_PI[:3, 3]
    turned = np.linalg.det(X_PI[:3, :3]) < 0.0
    return points, np.asarray(triangles[:, ::-1] if turned else triangles, dtype=np.int64)


def _cropped(values: Volume, found: Volume, outside: float) -> tuple[npt.NDArray[np.int64], Volume]:
    """Index of the first voxel, and the box around the found voxels with a border of outside values: closed there."""
    border = 4
    box = []
    for axis in range(3):
        inside = np.flatnonzero(found.any(axis=tuple(a for a in range(3) if a != axis)))
        box.append(slice(max(int(inside[0]) - border, 0), int(inside[-1]) + border + 1))
    padded = np.pad(values[tuple(box)].astype(np.float32), border, constant_values=outside)
    return np.array([s.start - border for s in box]), padded


def _label(image: Image, wanted: int | str | None, path: Path) -> tuple[int, int]:
    """Layer and value of a segment."""
    if isinstance(wanted, str):
        if wanted in image.segments:
            return image.segments[wanted]
        mend = f"segments: {', '.join(image.segments)}" if image.segments else "give the number of the label"
        raise MeshError(f"there is no segment {wanted!r}", where=str(path), mend=mend)
    present = [(k, int(v)) for k in range(image.layers) for v in np.unique(image.layer(k)) if v != 0]
    matching = present if wanted is None else [pair for pair in present if pair[1] == wanted]
    if len(matching) == 1:
        return matching[0]
    what, mend = _choice(wanted, len(present), bool(matching))
    raise MeshError(what, where=str(path), why=f"labels: {_labels(image, present)}", mend=mend)


def _choice(wanted: int | None, count: int, several: bool) -> tuple[str, str]:
    """Why no single label is selected, and the correction."""
    if wanted is not None and several:
        return f"label {wanted} is in several layers", "name the segment: label: NAME"
    if wanted is not None:
        return f"label {wanted} is not in the segmentation", "choose one of these labels"
    if count == 0:
        return "the segmentation is empty", "export it again with its segments"
    if count > _MOST_LABELS:
        return f"{count} values are too many for labels", "add threshold: VALUE, or label: NUMBER"
    return f"the segmentation has {count} labels", "add label: NUMBER to the object"


def _labels(image: Image, present: list[tuple[int, int]]) -> str:
    """The first labels with the names of their segments."""
    names = {place: name for name, place in image.segments.items()}
    shown = [f"{v} ({names[k, v]})" if (k, v) in names else str(v) for k, v in present[:_LABELS_SHOWN]]
    return ", ".join(shown) + (", ..." if len(present) > _LABELS_SHOWN else "") or "none"


def _range(image: Image) -> str:
    finite = image.values[np.isfinite(image.values)]
    return f"its values are {finite.min():g} to {finite.max():g}" if finite.size else "no value is finite"
