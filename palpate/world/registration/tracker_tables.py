"""Tables of poses as the programs of trackers export them: OptiTrack Motive, NDI ToolBox, and trajectories of TUM."""

from __future__ import annotations

import csv
import warnings
from pathlib import Path

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import rigid
from palpate.base.arrays.so3 import matrices
from palpate.base.errors import PalpateWarning, RegistrationError

_LENGTHS = {"meters": 1.0, "centimeters": 1e-2, "millimeters": 1e-3, "inches": 0.0254}
_NDI = ("q0", "qx", "qy", "qz", "tx", "ty", "tz")
_GOOD = ("ok", "partially out of volume", "enabled")


def read(path: Path, text: str) -> Array | None:
    """Poses (N, 4, 4) [m] of such a table; None for other files. Frames in which the tool was not seen are left out.

    Raises:
        RegistrationError: it holds several tools, or angles in place of quaternions, or is damaged.
    """
    lines = text.splitlines()
    first = next((line for line in lines if line.strip()), "")
    try:
        if first.lower().startswith("format version"):
            return _optitrack(path, lines)
        header = [cell.strip().lower() for cell in first.split(",")]
        if all(name in header for name in _NDI):
            return _ndi(path, header, lines)
        if _is_tum(path, lines):
            return _tum(lines)
    except RegistrationError:
        raise
    except (ValueError, IndexError) as error:
        raise RegistrationError(
            "the table cannot be read", where=str(path), why=str(error), mend="export it again"
        ) from None
    return None


def _optitrack(path: Path, lines: list[str]) -> Array:
    rows = [[cell.strip() for cell in row] for row in csv.reader(lines) if any(cell.strip() for cell in row)]
    head = {rows[0][k].lower(): rows[0][k + 1] for k in range(0, len(rows[0]) - 1, 2)}
    if head.get("rotation type", "").lower() != "quaternion":
        what = f"rotations are {head.get('rotation type') or 'not named'}"
        raise RegistrationError(what, where=str(path), mend="export again from Motive with Rotation: Quaternion")
    length = head.get("length units", "").lower()
    if length not in _LENGTHS:
        raise RegistrationError(f"the length units {length!r} are not known", where=str(path), mend="export in Meters")
    start = next(k for k, row in enumerate(rows) if row[0].lower() == "frame")
    titles = {row[1].lower(): row for row in rows[1:start] if len(row) > 2}
    kinds, names = titles.get("type", []), titles.get("name", [])
    parts = [row for row in rows[1:start] if "Rotation" in row and "Position" in row]
    if not kinds:
        kinds = next((row for row in rows[1:start] if "Rigid Body" in row), [])
        names = rows[rows.index(kinds) + 1] if kinds in rows else []
    found: dict[str, dict[str, int]] = {}
    for k in range(2, len(rows[start])):
        if k < len(kinds) and kinds[k] == "Rigid Body" and parts:
            found.setdefault(names[k], {})[f"{parts[0][k]} {rows[start][k]}"] = k
    if len(found) != 1:
        what = f"{len(found)} rigid bodies: {', '.join(found)}" if found else "no rigid body"
        mend = "export the one that was measured alone (in Motive: select it, then Export)"
        raise RegistrationError(what, where=str(path), mend=mend)
    places = next(iter(found.values()))
    keys = [f"Rotation {axis}" for axis in "WXYZ"] + [f"Position {axis}" for axis in "XYZ"]
    cells = [[row[places[key]] if places[key] < len(row) else "" for key in keys] for row in rows[start + 1 :]]
    return _poses(path, cells, _LENGTHS[length])


def _ndi(path: Path, header: list[str], lines: list[str]) -> Array:
    if header.count("q0") > 1:
        what = f"{header.count('q0')} tools in one table"
        raise RegistrationError(what, where=str(path), mend="export the tool that was measured alone, in NDI ToolBox")
    places = [header.index(name) for name in _NDI]
    state = header.index("state") if "state" in header else None
    rows = list(csv.reader(lines))[1:]
    return _poses(path, [
        [""] * 7 if state is not None and row[state].strip().lower() not in _GOOD else [row[k] for k in places]
        for row in rows if any(cell.strip() for cell in row)
    ], 1e-3)  # fmt: skip


def _is_tum(path: Path, lines: list[str]) -> bool:
    """Eight numbers a row, separated by spaces: t tx ty tz qx qy qz qw, as the TUM RGB-D benchmark writes them."""
    if path.suffix.lower() not in (".txt", ".tum", ".freiburg"):
        return False
    rows = [line for line in lines if line.strip() and not line.startswith("#")]
    return bool(rows) and len(rows[0].split()) == 8 and "," not in rows[0]


def _tum(lines: list[str]) -> Array:
    rows = np.array([[float(x) for x in line.split()] for line in lines if line.strip() and not line.startswith("#")])
    if rows.shape[1:] != (8,):
        raise ValueError("its rows have different lengths")
    return rigid(matrices(rows[:, [7, 4, 5, 6]]), rows[:, 1:4])


def _poses(path: Path, rows: list[list[str]], scale: float) -> Array:
    """Poses from rows of qw, qx, qy, qz, x, y, z; those with an empty cell were not seen."""
    seen = [[float(cell) for cell in row] for row in rows if all(cell.strip() for cell in row)]
    seen = [row for row in seen if np.isfinite(row).all() and abs(np.linalg.norm(row[:4]) - 1.0) < 0.01]
    if not seen:
        raise RegistrationError(
            "the tool was seen in no frame", where=str(path), mend="record it with the tool in view"
        )
    if len(seen) < len(rows):
        what = f"{len(rows) - len(seen):,} of {len(rows):,} frames, in which the tool was not seen, are left out"
        warnings.warn(PalpateWarning(what, where=str(path)), stacklevel=2)
    values = np.array(seen)
    return rigid(matrices(values[:, :4]), scale * values[:, 4:])
