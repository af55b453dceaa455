"""Surfaces of segmentations and CT volumes in NRRD and NIfTI files, in millimetres of the patient frame LPS.

The patient frame is that of DICOM, and of the surfaces that 3D Slicer writes: x to the left, y to posterior, z to
superior. A file in the frame RAS is converted.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate import limits
from palpate.errors import MeshError, MissingExtraError

ENDINGS = (".nrrd", ".nhdr", ".nii", ".nii.gz")
_LABELS_SHOWN = 12
_MOST_LABELS = 64
_SMOOTHING = 0.8  # standard deviation of the Gaussian that rounds the steps of a label map [voxels]
_RAS_TO_LPS = np.diag([-1.0, -1.0, 1.0, 1.0])
_TO_MM = {"mm": 1.0, "millimeter": 1.0, "m": 1e3, "meter": 1e3, "cm": 10.0, "um": 1e-3, "micron": 1e-3}

Volume = npt.NDArray[Any]


@dataclass(frozen=True)
class Selection:
    """Part of a volume: a label of a segmentation, or all values from a threshold."""

    label: int | str | None = None  # value or name of a segment
    threshold: float | None = None  # in the file's own values, e.g. Hounsfield units


@dataclass(frozen=True)
class _Image:
    values: Volume  # (nx, ny, nz), or (layers, nx, ny, nz)
    X_PI: npt.NDArray[np.float64]  # (4, 4) voxel indices to LPS [mm]
    segments: dict[str, tuple[int, int]]  # name: (layer, value)

    def layer(self, index: int) -> Volume:
        """One layer (nx, ny, nz) of the volume."""
        return self.values[index] if self.values.ndim == 4 else self.values


def is_volume(path: Path) -> bool:
    """Whether the name of a file ends as those of volumes do."""
    return path.name.lower().endswith(ENDINGS)


def surface(path: Path, selection: Selection) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Closed surface of a segment, or of the values from a threshold: vertices (n, 3) [mm] and triangles (m, 3).

    Raises:
        MeshError: the file cannot be read, the label is absent or ambiguous, or the selection is empty.
        MissingExtraError: the extra `files` is not installed.
    """
    image = _read(path)
    if selection.threshold is not None:
        level, values = float(selection.threshold), image.layer(0)
        found = values >= level
        what = f"threshold {level:g}"
        low = float(values.min()) if values.size else 0.0
    else:
        layer, label = _label(image, selection.label, path)
        found, level, low, what = image.layer(layer) == label, 0.5, 0.0, f"label {label}"
        values = found
    if not found.any():
        raise MeshError(f"no voxel has {what}", where=str(path), why=_range(image), mend="choose another value")
    corner, values = _cropped(values, found, low)
    return _contour(values, level, corner, image.X_PI, smooth=selection.threshold is None)


def _contour(
    values: Volume, level: float, corner: npt.NDArray[np.int64], X_PI: npt.NDArray[np.float64], smooth: bool
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Surface of values above a level, with vertices in LPS [mm] and triangles counter-clockwise from outside."""
    from scipy.ndimage import gaussian_filter
    from skimage.measure import marching_cubes

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


def _label(image: _Image, wanted: int | str | None, path: Path) -> tuple[int, int]:
    """Layer and value of a segment."""
    if isinstance(wanted, str):
        if wanted in image.segments:
            return image.segments[wanted]
        mend = f"segments: {', '.join(image.segments)}" if image.segments else "give the number of the label"
        raise MeshError(f"there is no segment {wanted!r}", where=str(path), mend=mend)
    if not np.issubdtype(image.values.dtype, np.integer) and len(np.unique(image.values[::4])) > 256:
        what = "this is an image of continuous values, not a segmentation"
        raise MeshError(what, where=str(path), why=_range(image), mend="add threshold: VALUE, e.g. 200 for bone in CT")
    present = [(k, int(v)) for k in range(_layers(image)) for v in np.unique(image.layer(k)) if v != 0]
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


def _labels(image: _Image, present: list[tuple[int, int]]) -> str:
    """The first labels with the names of their segments."""
    names = {place: name for name, place in image.segments.items()}
    shown = [f"{v} ({names[k, v]})" if (k, v) in names else str(v) for k, v in present[:_LABELS_SHOWN]]
    return ", ".join(shown) + (", ..." if len(present) > _LABELS_SHOWN else "") or "none"


def _layers(image: _Image) -> int:
    return image.values.shape[0] if image.values.ndim == 4 else 1


def _range(image: _Image) -> str:
    return f"its values are {image.values.min():g} to {image.values.max():g}" if image.values.size else "it is empty"


def _read(path: Path) -> _Image:
    try:
        image = _nrrd(path) if path.suffix.lower() in (".nrrd", ".nhdr") else _nifti(path)
        if image.values.ndim not in (3, 4):
            raise ValueError(f"it has {image.values.ndim} axes; volumes have three")
        if not np.isfinite(image.X_PI).all() or abs(np.linalg.det(image.X_PI[:3, :3])) < 1e-12:
            raise ValueError("its axes do not span the space")
        return image
    except ImportError:
        raise MissingExtraError(f"the reader of {path.suffix} files", "files") from None
    except Exception as error:  # damaged files raise many types of exception in both libraries
        why = " ".join(str(error).split())
        raise MeshError("the volume cannot be read", where=str(path), why=why, mend="export it again") from None


def _nrrd(path: Path) -> _Image:
    import nrrd

    limits.require_file(path)
    with path.open("rb") as file:
        header = nrrd.read_header(file)
        values = _nrrd_values(path, header, file.read() if "data file" not in header else None)
    directions = np.asarray(header.get("space directions", np.diag(header.get("spacings", np.ones(3)))), dtype=float)
    axes = directions[np.isfinite(directions).all(axis=1)][-3:]  # a list axis of layers has no direction
    if np.shape(axes) != (3, 3):
        raise ValueError("its header names no three directions in space")
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = axes.T, np.asarray(header.get("space origin", np.zeros(3)), dtype=float)
    X[:3] *= _TO_MM.get(str(next(iter(header.get("space units", ["mm"])))), 1.0)
    space = str(header.get("space", "left-posterior-superior")).lower()
    if space in ("right-anterior-superior", "ras"):
        X = _RAS_TO_LPS @ X
    return _Image(values, X, _slicer_segments(header))


def _nrrd_values(path: Path, header: Any, data: bytes | None) -> Volume:
    """Values of an NRRD file (nx, ny, nz), or with a first axis of layers; its data may lie in another file."""
    import nrrd

    if any(int(header.get(key, 0)) for key in ("line skip", "lineskip", "byte skip", "byteskip")):
        raise ValueError("it skips lines or bytes before its data; write it again without")
    sizes, width = [int(n) for n in header["sizes"]], nrrd.reader._determine_datatype(header).itemsize
    if min(sizes) < 0:
        raise ValueError(f"sizes {sizes}")
    if data is None:
        data = limits.read_bytes(path.parent / str(header.pop("data file")))
    unpack = {"gzip": limits.gunzip, "gz": limits.gunzip, "bzip2": limits.bunzip2, "bz2": limits.bunzip2}
    if header["encoding"] in unpack:
        limits.require_unpacked(math.prod(sizes) * width)
        data = unpack[header["encoding"]](data, math.prod(sizes) * width)
        header["encoding"] = "raw"
    limits.require_present(math.prod(sizes), 1, len(data), "values")
    return np.asarray(nrrd.read_data(header, BytesIO(data), index_order="F"))


def _slicer_segments(header: Any) -> dict[str, tuple[int, int]]:
    """Names of the segments as 3D Slicer writes them: layer and value of each."""
    found = {}
    for i in range(1000):
        key = f"Segment{i}_"
        if key + "LabelValue" not in header:
            break
        place = int(header.get(key + "Layer", 0)), int(header[key + "LabelValue"])
        found[str(header.get(key + "Name", header.get(key + "ID", i)))] = place
    return found


def _nifti(path: Path) -> _Image:
    import nibabel

    size = limits.require_file(path)
    packed = path.name.lower().endswith(".gz")
    if packed:
        begins = [abs(struct.unpack_from(f"{order}f", limits.gunzip_head(path, 352), 108)[0]) for order in "<>"]
        if not min(begins) <= limits.MEBI:
            raise limits.LimitError("its values begin more than 1 MiB after its header")
    image: Any = nibabel.load(str(path))
    count, width = math.prod(int(n) for n in image.shape), int(image.get_data_dtype().itemsize)
    if packed:
        limits.require_unpacked(count * max(width, 4 if image.dataobj.slope == 1.0 else 8))
    else:
        limits.require_present(count, width, size, "values")
    values = np.asanyarray(image.dataobj)
    while values.ndim > 3 and values.shape[-1] == 1:
        values = values[..., 0]
    if values.ndim > 3:
        raise ValueError("it is a series of volumes; one volume is needed")
    if (
        np.issubdtype(values.dtype, np.floating)
        and np.array_equal(values, np.rint(values))
        and abs(values).max() < 2**31
    ):
        values = values.astype(np.int32)  # label maps are often stored as floats
    X: npt.NDArray[np.float64] = _RAS_TO_LPS @ np.asarray(image.affine, dtype=float)
    X[:3] *= _TO_MM.get(str(image.header.get_xyzt_units()[0]), 1.0)
    return _Image(values, X, {})
