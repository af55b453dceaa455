"""Files of volumes: NRRD, NIfTI and MetaImage as values with their place in the patient frame LPS.

This is the only reader of these formats: surfaces of segmentations and distance grids both come from `read`. What a
header says and this reader does not know is refused by name; what a header leaves out is told (`Image.doubts`).
"""

from __future__ import annotations

import math
import struct
import warnings
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.errors import MeshError, MissingExtraError, PalpateWarning
from palpate.world.mesh import meta_image

ENDINGS = (".nrrd", ".nhdr", ".nii", ".nii.gz", ".mha", ".mhd")
MILLIMETRES = {
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres"), 1.0),
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1e3),
    **dict.fromkeys(("cm", "centimeter", "centimeters"), 10.0),
    **dict.fromkeys(("um", "\u00b5m", "\u03bcm", "micron", "microns", "micrometer", "micrometers"), 1e-3),
    **dict.fromkeys(("in", "inch", "inches"), 25.4),
}
"""Length of a unit by its names in headers [mm]."""
_TO_LPS = {  # signs of the axes of each patient frame in LPS
    **dict.fromkeys(("left-posterior-superior", "lps"), (1.0, 1.0, 1.0)),
    **dict.fromkeys(("right-anterior-superior", "ras"), (-1.0, -1.0, 1.0)),
    **dict.fromkeys(("left-anterior-superior", "las"), (1.0, -1.0, 1.0)),
    **dict.fromkeys(("", "3d-right-handed", "3dr"), (1.0, 1.0, 1.0)),  # frames without names of their axes
}
_SPATIAL = ("domain", "space", "none", "???", "")
_SERIES = "a volume is needed, and this is a series of {count}"
_APART = 0.5  # difference of the two poses of a NIfTI file that is told [voxels]

Volume = npt.NDArray[Any]


@dataclass(frozen=True)
class Image:
    """A volume as its file holds it."""

    values: Volume  #: (nx, ny, nz), or (layers, nx, ny, nz) of a segmentation with layers
    X_PI: Array  #: (4, 4) voxel indices to LPS, in the file's unit
    mm: float | None  #: length of the file's unit [mm]; None: the file states none
    segments: dict[str, tuple[int, int]] = field(default_factory=dict)  #: name: (layer, value)
    doubts: tuple[str, ...] = ()  #: what the header leaves out or contradicts

    def layer(self, index: int) -> Volume:
        """One layer (nx, ny, nz) of the volume."""
        return self.values[index] if self.values.ndim == 4 else self.values

    @property
    def labels(self) -> Volume | None:
        """The values as integers; None if they are no whole numbers.

        Label maps are often stored as floats, with NaN outside of the mask in which they were made: these become 0.
        """
        if not np.issubdtype(self.values.dtype, np.floating):
            return self.values
        finite = np.where(np.isfinite(self.values), self.values, 0.0)
        if not np.array_equal(finite, np.rint(finite)) or abs(finite).max() >= 2**31:
            return None
        return finite.astype(np.int32)

    @property
    def layers(self) -> int:
        """Number of layers."""
        return int(self.values.shape[0]) if self.values.ndim == 4 else 1


def is_volume(path: Path) -> bool:
    """Whether the name of a file ends as those of volumes do."""
    return path.name.lower().endswith(ENDINGS)


def read(path: Path) -> Image:
    """Read a volume.

    Raises:
        MeshError: the file cannot be read, or holds what is no single volume of numbers.
        MissingExtraError: the extra `files` is not installed.
    """
    name = path.name.lower()
    decode = _nrrd if name.endswith((".nrrd", ".nhdr")) else _meta if name.endswith((".mha", ".mhd")) else _nifti
    try:
        image = decode(path)
        if image.values.ndim not in (3, 4) or 0 in image.values.shape:
            raise ValueError(f"its axes have {image.values.shape} values; a volume has three axes")
        if not np.isfinite(image.X_PI).all() or abs(np.linalg.det(image.X_PI[:3, :3])) < 1e-12:
            raise ValueError("its axes do not span the space")
        return image
    except ImportError:
        raise MissingExtraError(f"the reader of {path.suffix} files", "files") from None
    except MeshError:
        raise
    except Exception as error:  # damaged files raise many types of exception in both libraries
        why = " ".join(str(error).split())
        raise MeshError("the volume cannot be read", where=str(path), why=why, mend="export it again") from None


def tell_doubts(image: Image, path: Path) -> None:
    """Warn of what the header leaves out or contradicts."""
    for doubt in image.doubts:
        mend = "compare its place with the scan that it belongs to, or export it again with its pose"
        warnings.warn(PalpateWarning(doubt, where=str(path), mend=mend), stacklevel=3)


def _refused(path: Path, what: str, mend: str, why: str = "") -> MeshError:
    return MeshError(what, where=str(path), why=why, mend=mend)


def _series(path: Path, count: int, tool: str) -> MeshError:
    return _refused(path, _SERIES.format(count=f"{count:,} values at each place"), tool, "time, colours or vectors")


# -- NRRD --------------------------------------------------------------------------------------------------------------


def _nrrd(path: Path) -> Image:
    import nrrd

    limits.require_file(path)
    with path.open("rb") as file:
        header = nrrd.read_header(file)
        _require_known(path, header)
        values = _nrrd_values(path, header, file.read() if "data file" not in header else None)
    values = _with_layers_first(path, header, values)
    space = str(header.get("space", "")).lower().removesuffix("-time")
    doubts = []
    if space in ("", "3d-right-handed", "3dr") and "space directions" in header:
        doubts.append("the header names no patient frame (space): its axes are taken as left, posterior, superior")
    if "space origin" not in header and "space directions" in header:
        doubts.append("the header has no space origin: its first voxel is placed at the origin of the frame")
    X = np.eye(4)
    X[:3, :3] = _directions(header).T
    X[:3, 3] = np.asarray(header.get("space origin", np.zeros(3)), dtype=float)
    X = np.diag([*_TO_LPS[space], 1.0]) @ X
    return Image(values, X, _nrrd_unit(path, header), _slicer_segments(header), tuple(doubts))


def _require_known(path: Path, header: Any) -> None:
    """Refuse by name what the header says and this reader does not know."""
    space = str(header.get("space", "")).lower().removesuffix("-time")
    if space not in _TO_LPS:
        mend = "save it in a patient frame, e.g. by 3D Slicer, or by: unu basinfo -spc LPS -i IN -o OUT"
        what = f"the space {header['space']!r} is no frame of a patient that is read"
        raise _refused(path, what, mend, "LPS, RAS, LAS")
    if "axis mins" in header or "axismins" in header:
        mend = "write it with space directions and space origin, e.g. by 3D Slicer or SimpleITK"
        raise _refused(path, "its place is given by axis mins, which are not read", mend)
    if "data file" in header and (isinstance(header["data file"], list) or "%" in str(header["data file"])):
        raise _refused(path, "its data lie in several files", "join them: unu save -f nrrd -i IN.nhdr -o OUT.nrrd")


def _with_layers_first(path: Path, header: Any, values: Volume) -> Volume:
    """Values (nx, ny, nz), or (layers, nx, ny, nz) of a segmentation of 3D Slicer; other lists are refused."""
    kinds = [str(kind).lower() for kind in header.get("kinds", ["domain"] * values.ndim)]
    if "space directions" in header:
        lists = [k for k, row in enumerate(np.asarray(header["space directions"], float)) if not np.isfinite(row).all()]
    else:
        lists = [k for k, kind in enumerate(kinds) if kind not in _SPATIAL]
    for k in lists:
        if values.shape[k] == 1:
            continue
        if k == 0 and kinds[0] in ("list", *_SPATIAL) and "Segment0_LabelValue" in header:
            continue
        tool = "take one volume out: unu slice -a AXIS -p 0, or 3D Slicer's Sequences; colours: unu 2op or ITK-SNAP"
        if kinds[k] not in ("list", "time", *_SPATIAL):
            what = f"each voxel holds {values.shape[k]} values ({kinds[k]}), not one"
            raise _refused(path, what, "export labels or one channel: unu slice -a 0 -p CHANNEL")
        raise _series(path, values.shape[k], tool)
    layered = lists == [0] and values.shape[0] > 1
    kept = [0] if layered else []
    single = tuple(k for k in lists if k not in kept)
    return values.squeeze(axis=single) if single else values


def _directions(header: Any) -> Array:
    """Steps (3, 3) along the axes of space of each index, one row per index."""
    if "space directions" not in header:
        spacings = np.asarray(header.get("spacings", np.ones(3)), dtype=float)
        return np.diag(spacings[np.isfinite(spacings)][-3:] if len(spacings) > 3 else spacings)
    rows = np.asarray(header["space directions"], dtype=float)
    axes = rows[np.isfinite(rows).all(axis=1)]
    if axes.shape != (3, 3):
        raise ValueError("its header names no three directions in space")
    return np.asarray(axes, dtype=np.float64)


def _nrrd_unit(path: Path, header: Any) -> float | None:
    stated = {str(unit).strip().lower() for unit in header.get("space units", header.get("units", ()))} - {"", "none"}
    if not stated:
        return None
    if len(stated) > 1 or not stated <= set(MILLIMETRES):
        known = "mm, cm, m, um and in are read, the same for all axes"
        raise _refused(path, f"the space units {', '.join(sorted(stated))} are not known", "write it in mm", known)
    return MILLIMETRES[stated.pop()]


def _nrrd_values(path: Path, header: Any, data: bytes | None) -> Volume:
    """Values of an NRRD file, the fastest axis first; its data may lie in another file."""
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


# -- NIfTI -------------------------------------------------------------------------------------------------------------


def _nifti(path: Path) -> Image:
    import nibabel

    size = limits.require_file(path)
    packed = path.name.lower().endswith(".gz")
    if packed:
        begins = [abs(struct.unpack_from(f"{order}f", limits.gunzip_head(path, 352), 108)[0]) for order in "<>"]
        if not min(begins) <= limits.MEBI:
            raise limits.LimitError("its values begin more than 1 MiB after its header")
    image: Any = nibabel.load(str(path))
    kind = image.get_data_dtype()
    if kind.fields is not None or kind.kind == "c":
        what = "complex numbers" if kind.kind == "c" else f"colours ({', '.join(kind.names)})"
        raise _refused(path, f"its voxels are {what}, not labels or intensities", "export one number per voxel")
    count, width = math.prod(int(n) for n in image.shape), int(kind.itemsize)
    if packed:
        limits.require_unpacked(count * max(width, 4 if image.dataobj.slope == 1.0 else 8))
    else:
        limits.require_present(count, width, size, "values")
    if len(image.shape) > 3 and math.prod(image.shape[3:]) != 1:
        tool = "take one volume out: fslroi IN OUT 0 1, or in Python: nibabel.four_to_three(image)[0]"
        raise _series(path, math.prod(image.shape[3:]), tool)
    values = np.asanyarray(image.dataobj)
    values = values.reshape(values.shape[:3])
    unit = str(image.header.get_xyzt_units()[0])
    if unit not in ("unknown", *MILLIMETRES):
        raise _refused(path, f"the unit {unit!r} of its axes is not known", "write it in mm")
    X = np.diag([-1.0, -1.0, 1.0, 1.0]) @ np.asarray(image.affine, dtype=float)
    return Image(values, X, MILLIMETRES.get(unit), doubts=_nifti_doubts(image))


def _nifti_doubts(image: Any) -> tuple[str, ...]:
    q, s = (form(coded=True) for form in (image.get_qform, image.get_sform))
    if not q[1] and not s[1]:
        return ("the header has neither sform nor qform: place, turn and sides of the patient are not stated",)
    if not q[1] or not s[1]:
        return ()
    n = np.array(image.shape[:3], dtype=float) - 1.0
    corners = np.array([[*(n * [i, j, k]), 1.0] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    away = float(np.linalg.norm(corners @ (q[0] - s[0]).T, axis=1).max())
    if not away > _APART * float(np.linalg.norm(s[0][:3, :3], axis=0).min()):
        return ()
    what = f"its sform and qform place it up to {away:.3g} mm apart: the sform is taken"
    return (f"{what}, other programs take the qform",)


# -- MetaImage ---------------------------------------------------------------------------------------------------------


def _meta(path: Path) -> Image:
    header, values = meta_image.read(path)
    if any(key.startswith("seq_frame") for key in header):
        tool = "take one image out: 3D Slicer's Sequences module, or EditSequenceFile of PLUS"
        raise _series(path, values.shape[-1], tool)
    if values.ndim == 4 and values.shape[0] > 1 and int(header.get("elementnumberofchannels", ["1"])[0]) > 1:
        raise _refused(path, f"each voxel holds {values.shape[0]} values, not one", "export labels or one channel")
    if values.ndim == 4:
        if values.shape[3] != 1 and values.shape[0] != 1:
            raise _series(path, values.shape[3], "take one volume out: SimpleITK.Extract, or 3D Slicer's Sequences")
        values = values[..., 0] if values.shape[3] == 1 else values[0]
    X, doubts = meta_image.pose(header)
    return Image(values, X, 1.0, doubts=doubts)
