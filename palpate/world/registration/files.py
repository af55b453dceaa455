"""Files of points and poses: CSV with checked columns."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.arrays.checks import is_number
from palpate.base.arrays.rigid import rigid
from palpate.base.arrays.so3 import matrices
from palpate.base.errors import FrameError, RegistrationError
from palpate.base.values.units import FILE_UNITS
from palpate.world.frames.checks import quaternion
from palpate.world.registration import slicer_files, tracker_tables

_QUATERNION = ("qw", "qx", "qy", "qz")
_NAMES = ("name", "marker", "label")
_SAME = 0.05  # relative difference of distances that scales of 1000 are told apart by


@dataclass(frozen=True)
class Points:
    """Points of a file."""

    names: tuple[str, ...]
    p: Array  #: (N, 3) [m]
    sigma: Array | None  #: (N, 3) standard deviations along the axes [m], or None if the file has none
    stated: bool = False  #: True if the file itself states its unit


def read_points(path: Path, unit: str = "m") -> Points:
    """Points of 3D Slicer (.fcsv, .mrk.json; in LPS) or of a CSV.

    A CSV has columns x, y, z, optionally name and sx, sy, sz; or three columns of numbers without a header.

    A header may carry the unit (x_mm); otherwise lengths are in `unit`.

    Raises:
        RegistrationError: the file cannot be read, a column is missing, a value is no number, or a name is used twice.
    """
    if slicer_files.is_slicer(path):
        names, p = slicer_files.read(path)
        return Points(names, p, None, stated=True)
    header, rows = _table(path)
    if not header:
        header = ["x", "y", "z"] if len(rows[0]) == 3 else ["name", "x", "y", "z"]
        if len(rows[0]) not in (3, 4):
            raise RegistrationError(
                f"{len(rows[0])} columns without a header", where=str(path), mend="begin with a header, e.g. name,x,y,z"
            )
    columns = _columns(path, header, rows, unit)
    p = _stack(path, columns, ("x", "y", "z"))
    names = _names(path, header, rows)
    sigma = _stack(path, columns, ("sx", "sy", "sz")) if "sx" in columns else None
    return Points(
        names, p, sigma, stated=all(name.partition("_")[2] in FILE_UNITS for name in header if name[0] in "xyz")
    )


def read_poses(path: Path, unit: str = "m") -> Array:
    """Poses (N, 4, 4) of a table of OptiTrack, NDI or TUM, or of a CSV.

    A CSV has columns x, y, z, qw, qx, qy, qz, optionally t; or 16 numbers per row, row by row.

    Raises:
        RegistrationError: as for points; also stamps that do not increase, and quaternions that are not of unit length.
    """
    _refuse_transform(path)
    table = tracker_tables.read(path, _text(path))
    if table is not None:
        return table
    header, rows = _table(path)
    if not header:
        if len(rows[0]) != 16:
            raise RegistrationError(
                f"{len(rows[0])} columns without a header", where=str(path),
                mend="begin with the header x,y,z,qw,qx,qy,qz, or give 16 numbers per row",
            )  # fmt: skip
        columns = _columns(path, [str(i) for i in range(16)], rows, "m")
        X = np.stack([columns[str(i)] for i in range(16)], axis=1).reshape(-1, 4, 4)
        X[:, :3, 3] *= FILE_UNITS[unit]
        return X
    columns = _columns(path, header, rows, unit)
    if "t" in columns:
        _increasing(path, columns["t"])
    q = _stack(path, columns, _QUATERNION)
    for i, one in enumerate(q):
        try:
            quaternion(f"the quaternion of row {i + 1}", one)
        except FrameError as error:
            why = "the columns are not a quaternion, or its components are swapped with others"
            mend = "give unit quaternions with the header qw,qx,qy,qz"
            raise RegistrationError(error.what, where=str(path), why=why, mend=mend) from None
    return rigid(matrices(q), _stack(path, columns, ("x", "y", "z")))


def _refuse_transform(path: Path) -> None:
    """Refuse files of one transform, which say in other programs what they are."""
    if path.suffix.lower() in (".tfm", ".h5", ".mat"):
        mend = "one row per pose; in Python: SimpleITK.ReadTransform(FILE), whose translation is in mm and in LPS"
        raise RegistrationError("a file of one transform is no table of poses", where=str(path), mend=mend)


def _text(path: Path) -> str:
    try:
        return limits.read_text(path, limits.MOST_TABLE, "utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise RegistrationError("the file cannot be read", where=str(path), why=str(error)) from None


def _table(path: Path) -> tuple[list[str], list[list[str]]]:
    """Header (empty without one) and rows of a CSV."""
    try:
        lines = limits.read_text(path, limits.MOST_TABLE, "utf-8-sig").split("\n")
        rows = [[cell.strip() for cell in row] for row in csv.reader(lines) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise RegistrationError("the file cannot be read", where=str(path), why=str(error)) from None
    if not rows:
        raise RegistrationError("the file is empty", where=str(path), mend="give one row per measurement")
    header = [] if is_number(rows[0][-1]) else [cell.lower() for cell in rows[0]]
    body = rows[1:] if header else rows
    if not body:
        raise RegistrationError(
            "the file has a header and no rows", where=str(path), mend="give one row per measurement"
        )
    for i, row in enumerate(body):
        if len(row) != len(rows[0]):
            raise RegistrationError(
                f"row {i + 1} has {len(row)} columns, the first has {len(rows[0])}", where=str(path), mend="complete it"
            )
    return header, body


def _columns(path: Path, header: list[str], rows: list[list[str]], unit: str) -> dict[str, Array]:
    """Numbers by column name without its unit; lengths in metres."""
    found = {}
    for k, full in enumerate(header):
        name, _, suffix = full.partition("_")
        if name in _NAMES:
            continue
        bad = [i for i, row in enumerate(rows) if not is_number(row[k])]
        if bad:
            raise RegistrationError(
                f"row {bad[0] + 1}, column {full!r}: {rows[bad[0]][k]!r} is no number", where=str(path)
            )
        if name in found:
            raise RegistrationError(f"the column {name!r} appears twice", where=str(path), mend="remove one")
        values = np.array([float(row[k]) for row in rows])
        length = name in ("x", "y", "z", "sx", "sy", "sz")
        found[name] = values * FILE_UNITS[suffix if suffix in FILE_UNITS else unit] if length else values
    return found


def _stack(path: Path, columns: dict[str, Array], names: tuple[str, ...]) -> Array:
    missing = [name for name in names if name not in columns]
    if missing:
        raise RegistrationError(
            f"the columns {', '.join(missing)} are missing; there are {', '.join(columns)}", where=str(path),
            mend=f"name the columns {','.join(names)}",
        )  # fmt: skip
    return np.stack([columns[name] for name in names], axis=1)


def _names(path: Path, header: list[str], rows: list[list[str]]) -> tuple[str, ...]:
    k = next((header.index(name) for name in _NAMES if name in header), None)
    names = tuple(row[k] if k is not None else str(i) for i, row in enumerate(rows))
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise RegistrationError(
            f"the marker {twice!r} appears {names.count(twice)} times", where=str(path), mend="give each marker one row"
        )
    return names


def _increasing(path: Path, t: Array) -> None:
    back = np.flatnonzero(np.diff(t) <= 0)
    if len(back):
        i = int(back[0])
        raise RegistrationError(
            f"the stamp of row {i + 2} is {t[i + 1]:g}, not later than {t[i]:g} of the row before", where=str(path),
            why="rows out of order, or two recordings joined", mend="sort the rows by time, and record once",
        )  # fmt: skip


def by_name(moving: Points, fixed: Points) -> tuple[Points, Points, tuple[str, ...]]:
    """Both sets in the order of the moving names, without the points of one set alone, whose names come third.

    Files without names correspond by rows.
    """
    shared = [name for name in moving.names if name in fixed.names]
    alone = tuple(sorted({*moving.names, *fixed.names} - set(shared)))
    if not shared:
        return moving, fixed, ()
    return _chosen(moving, shared), _chosen(fixed, shared), alone


def in_measured_unit(moving: Points, fixed: Points, names: tuple[str, str]) -> tuple[Points, Points, str]:
    """Points whose unit one file states, and the other contradicts by a factor of 1000: the measured distances decide.

    Args:
        moving, fixed: corresponding points.
        names: of their files, for the words.

    Returns:
        Both in metres, and what was changed, in words; empty if nothing was.
    """
    if moving.stated == fixed.stated or len(moving.p) != len(fixed.p) or len(moving.p) < 3:
        return moving, fixed, ""
    sure, other = (moving, fixed) if moving.stated else (fixed, moving)
    lengths = [np.linalg.norm(one.p - np.roll(one.p, 1, axis=0), axis=1) for one in (other, sure)]
    ratio = float(np.median(lengths[1] / np.maximum(lengths[0], 1e-12)))
    factor = next((f for f in (1e3, 1e-3) if abs(ratio / f - 1.0) < _SAME), None)
    if factor is None:
        return moving, fixed, ""
    scaled = replace(other, p=factor * other.p, sigma=None if other.sigma is None else factor * other.sigma)
    wrong, right = names[::-1] if moving.stated else names
    words = f"{wrong} is in {'m, not in mm' if factor > 1.0 else 'mm, not in m'}: its distances are those of {right}, "
    words += "which states its unit"
    return (moving, scaled, words) if moving.stated else (scaled, fixed, words)


def _chosen(points: Points, names: list[str]) -> Points:
    rows = [points.names.index(name) for name in names]
    sigma = None if points.sigma is None else points.sigma[rows]
    return Points(tuple(names), points.p[rows], sigma, points.stated)
