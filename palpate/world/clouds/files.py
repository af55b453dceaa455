"""Files of point clouds. Their unit is asked for, because none of the formats defines one."""

from __future__ import annotations

import io
import struct
import zipfile
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base import limits
from palpate.base.errors import CloudError, OutputError
from palpate.base.values.units import FILE_UNITS
from palpate.world.clouds import pcd, ply
from palpate.world.clouds.table import Table, require_count

FORMATS = (".pcd", ".ply", ".npz", ".npy", ".xyz", ".txt", ".csv")
"""Suffixes of files that are read."""
_IMAGES = (".png", ".pgm", ".tif", ".tiff", ".exr", ".jpg", ".raw")
DEPTH_IMAGES = (
    "make clouds of them with the camera's fx, fy, cx, cy and the scale of its depths (1000 a metre for most cameras, "
    "5000 in TUM RGB-D), e.g. open3d.geometry.PointCloud.create_from_depth_image, and save one .ply per frame"
)
"""How images of depths become clouds."""
_CONVERTERS = (
    ((".las", ".laz", ".e57"), "CloudCompare converts it: CloudCompare -O FILE -C_EXPORT_FMT PLY -SAVE_CLOUDS"),
    ((".bag",), "a recording of RealSense becomes clouds by: rs-convert -i FILE.bag -l FOLDER/NAME"),
    ((".obj", ".stl", ".off"), "a mesh is read by mesh: FILE"),
)
_COLUMNS = 64  # most columns of a table of points
_DAMAGED = (ValueError, KeyError, IndexError, StopIteration, EOFError, struct.error, zipfile.BadZipFile, OSError)


def load(path: Path, unit: str | None) -> Table:
    """The columns of a file in metres. Arguments and errors as in ``PointCloud.load``."""
    if unit is not None and unit not in FILE_UNITS:
        raise CloudError(f"unit {unit!r} is unknown", where=str(path), mend=f"use one of {', '.join(FILE_UNITS)}")
    table = read(path)
    stated = table.unit if table.unit in FILE_UNITS else None
    if unit is None and stated is None:
        raise _unit_missing(path, table)
    if unit is not None and stated is not None and unit != stated:
        raise CloudError(
            f"the file states its unit {stated}, but {unit} was given", where=str(path), mend="leave out unit"
        )
    scale = FILE_UNITS[unit or stated or "m"]
    viewpoint = None if table.viewpoint is None else scale * table.viewpoint
    return Table(scale * table.points, table.normals, table.colors, viewpoint, "m")


def read(path: Path) -> Table:
    """The columns of a file, in its own unit.

    Raises:
        CloudError: the file cannot be read, is damaged, or has an unknown format.
    """
    kind = path.suffix.lower()
    if kind in _IMAGES:
        raise CloudError("an image of depths is no cloud without the camera", where=str(path), mend=DEPTH_IMAGES)
    if kind not in FORMATS:
        mend = next((mend for endings, mend in _CONVERTERS if kind in endings), "")
        mend = "; or ".join(filter(None, (mend, f"use {', '.join(FORMATS)}")))
        raise CloudError(f"unknown format {path.suffix!r} of a cloud", where=str(path), mend=mend)
    try:
        data = limits.read_bytes(path)
    except FileNotFoundError:
        raise CloudError("cloud file not found", where=str(path), mend="check the path") from None
    except OSError as error:
        raise CloudError("the file cannot be read", where=str(path), why=str(error)) from None
    if not data:
        raise CloudError("the file is empty (0 bytes)", where=str(path), mend="export or copy it again")
    decode = {".pcd": pcd.decode, ".ply": ply.decode, ".npz": _npz, ".npy": _npy}.get(kind, _text)
    try:
        return decode(data, partial(require_count, name=str(path)))
    except CloudError:
        raise
    except _DAMAGED as error:
        what = f"the file is not a readable {kind[1:].upper()}"
        raise CloudError(what, where=str(path), why=str(error), mend="copy or export it again") from None


def save(table: Table, path: Path) -> None:
    """Write columns in metres. Errors as in ``PointCloud.save``."""
    encode = {".pcd": pcd.encode, ".ply": ply.encode, ".npz": _npz_bytes, ".xyz": _text_bytes, ".csv": _csv_bytes}
    if path.suffix.lower() not in encode:
        raise CloudError(f"unknown format {path.suffix!r} to write", where=str(path), mend=f"use {', '.join(encode)}")
    data = encode[path.suffix.lower()](table)
    try:
        path.write_bytes(data)
    except OSError as error:
        raise OutputError("the cloud cannot be written", where=str(path), why=str(error)) from None


def _unit_missing(path: Path, table: Table) -> CloudError:
    finite = table.points[np.isfinite(table.points).all(axis=1)]
    size = float(np.ptp(finite, axis=0).max()) if len(finite) else 0.0
    lengths = ", ".join(f"{1e3 * size * FILE_UNITS[u]:.4g} mm in {u}" for u in ("m", "mm"))
    what, mend = "the unit of the cloud is not known", 'give it: unit="m", or unit: m in a scene'
    return CloudError(what, where=str(path), why=f"the file states none; it is long {lengths}", mend=mend)


def _npz(data: bytes, require: partial[None]) -> Table:
    arrays = limits.load_npz(data)
    if "points" not in arrays:
        raise ValueError(f"it has no array 'points'; its arrays are {', '.join(arrays) or 'none'}")
    require(len(arrays["points"]))
    part = {key: arrays[key] for key in ("normals", "colors", "viewpoint") if key in arrays}
    return Table(np.asarray(arrays["points"], float), **part, unit=str(arrays["unit"]) if "unit" in arrays else None)


def _npz_bytes(table: Table) -> bytes:
    out = io.BytesIO()
    named: dict[str, Any] = {"normals": table.normals, "colors": table.colors, "viewpoint": table.viewpoint}
    given = {key: value for key, value in named.items() if value is not None}
    np.savez_compressed(out, points=table.points, unit=np.array("m"), **given)
    return out.getvalue()


def _npy(data: bytes, require: partial[None]) -> Table:
    points = limits.load_npy(data)
    require(len(points))
    return Table(np.asarray(points, dtype=np.float64))


def _text(data: bytes, require: partial[None]) -> Table:
    """Rows of x y z, separated by spaces, commas or semicolons; then normals (6 columns) or colours (integers)."""
    text = data.decode("utf-8", "replace").replace(",", " ").replace(";", " ")
    lines = [line for line in text.splitlines() if line.strip()]
    notes = [line.lstrip("# ").split() for line in lines if line.startswith("#")]
    if any("tx ty tz" in line for line in lines if line.startswith("#")) or any(
        note[:2] == ["timestamp", "filename"] for note in notes
    ):
        raise ValueError("it lists poses or files of images by time, and no points (a folder of TUM RGB-D)")
    rows = [line for line in lines if not line.startswith("#")]
    if rows and not _is_number(rows[0].split()[0]):
        rows = rows[1:]  # names of the columns
    require(len(rows))
    if not rows:
        raise ValueError("it has no row of numbers")
    width = len(rows[0].split())
    if width > _COLUMNS:
        raise ValueError(f"its first row has {width:,} columns; at most {_COLUMNS} are read")
    words = " ".join(rows).split()
    if width < 3 or len(words) != width * len(rows):
        raise ValueError(f"its first row has {width} columns, {len(rows):,} rows have {len(words):,} numbers")
    values = np.array(words, dtype=np.float64).reshape(-1, width)
    more = values[:, 3:6] if width >= 6 else None
    coloured = more is not None and bool((more == np.round(more)).all()) and float(np.abs(more).max()) > 1.0
    return Table(
        values[:, :3],
        normals=None if coloured or more is None else more,
        colors=more.astype(np.uint8) if coloured and more is not None else None,
        unit=next((note[1] for note in notes if note[:1] == ["unit"] and len(note) > 1), None),
    )


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _text_bytes(table: Table) -> bytes:
    parts = [table.points] + ([table.normals] if table.normals is not None else [])
    out = io.StringIO()
    out.write("# unit m\n")
    np.savetxt(out, np.hstack(parts), fmt="%.9g")
    return out.getvalue().encode()


def _csv_bytes(table: Table) -> bytes:
    return (
        _text_bytes(table)
        .replace(b"# unit m\n", b"# unit m\nx y z\n", 1)
        .replace(b" ", b",")
        .replace(b"#,unit,m", b"# unit m", 1)
    )
