"""Tables of places for paths and clouds: each row is x, y, z and, with attitudes, qw, qx, qy, qz."""

from __future__ import annotations

import difflib
from pathlib import Path

import numpy as np

from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.arrays.so3 import matrices, quaternions
from palpate.base.arrays.yaml_loader import MOST_OF_PLAN, load
from palpate.base.errors import GuidanceError, OutputError
from palpate.base.values.units import FILE_UNITS

_PLAN_SPACING = 2e-3  # of the places taken from a plan [m]
HEADER = "x_m,y_m,z_m,qw,qx,qy,qz"


def read_rows(path: Path, unit: str = "mm") -> tuple[Array, Array | None]:
    """Read places (n, 3) [m] and, if the file has them, rotations (n, 3, 3).

    Columns are separated by commas, semicolons or white space; lines that begin with # are skipped. A header line
    may name the unit (``x_m``, ``x_mm``, ``x_cm``, ``x_in``); otherwise the unit is ``unit``.

    A plan of `palpate plan` (.yaml) gives the poses of its tip.

    Raises:
        GuidanceError: the file is missing, empty, or a line is invalid; the message names the line.
    """
    if is_plan(str(path)):
        return _tip_of_plan(path)
    named, rows = unit, []
    for number, line in enumerate(_lines(path), start=1):
        words = line.replace(",", " ").replace(";", " ").split()
        if not words or words[0].startswith("#"):
            continue
        try:
            rows.append([float(word) for word in words])
        except ValueError:
            if rows:
                raise GuidanceError(f"{line.strip()!r:.60} is not a row of numbers", where=f"{path}:{number}") from None
            named = _unit_of(words[0], unit, f"{path}:{number}")
            continue
        if len(rows[-1]) not in (3, 7) or len(rows[-1]) != len(rows[0]):
            what = f"{len(rows[-1])} numbers in a row"
            mend = f"x y z, or x y z qw qx qy qz, the same in every row ({HEADER})"
            raise GuidanceError(what, where=f"{path}:{number}", mend=mend)
    table = np.array(rows)
    if not len(table) or not np.isfinite(table).all():
        what = "the file holds no places" if not len(table) else "a number is not finite"
        raise GuidanceError(what, where=str(path), mend="rows of x, y, z")
    return FILE_UNITS[named] * table[:, :3], _rotations(table, path) if table.shape[1] == 7 else None


def write_rows(path: Path, places: Array, rotations: Array) -> None:
    """Write places (n, 3) [m] and rotations (n, 3, 3), with a header that names the unit.

    Raises:
        OutputError: the file cannot be written.
    """
    try:
        np.savetxt(
            path,
            np.hstack([places, quaternions(rotations, canonical=True)]),
            fmt="%.9g",
            delimiter=",",
            header=HEADER,
            comments="",
        )
    except OSError as error:
        raise OutputError(
            "the path cannot be written", where=str(path), why=str(error), mend="choose another file"
        ) from None


def _lines(path: Path) -> list[str]:
    try:
        return limits.read_text(path, limits.MOST_TABLE, "utf-8-sig").splitlines()
    except FileNotFoundError:
        names = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
        near = difflib.get_close_matches(path.name, names, n=1)
        mend = f"did you mean {path.parent / near[0]}?" if near else "check the path; it is relative to the scene file"
        raise GuidanceError("file not found", where=str(path), mend=mend) from None
    except (OSError, ValueError) as error:
        raise GuidanceError(
            "cannot be read as text", where=str(path), why=str(error), mend="give a text file with rows of x, y, z"
        ) from None


def is_plan(file: str | None) -> bool:
    """True if the name of a file is that of a plan of `palpate plan`."""
    return file is not None and file.lower().endswith((".yaml", ".yml"))


def clearance_of_plan(path: Path) -> float:
    """The clearance [m] that a plan keeps: the radius of the tube around it.

    Raises:
        GuidanceError: the file is not a plan, or its clearance is not above zero.
    """
    (clearance,) = _numbers_of_plan(path, "clearance_asked_m")
    if clearance.shape != () or not 0.0 < clearance < np.inf:
        what, mend = "the plan has no clearance above zero", "give the tube a radius, or plan with --clearance 3mm"
        raise GuidanceError(what, where=str(path), mend=mend)
    return float(clearance)


def _numbers_of_plan(path: Path, *keys: str) -> list[Array]:
    """The numbers of a plan file under these keys."""
    import yaml

    try:
        data = load("\n".join(_lines(path)), MOST_OF_PLAN)
        return [np.array(data[key], dtype=np.float64) for key in keys]
    except (yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        why = f"{error} is missing" if isinstance(error, KeyError) else str(error)
        mend = "palpate plan SCENE --to GOAL --out plan.yaml writes one"
        raise GuidanceError("the file is not a plan", where=str(path), why=why, mend=mend) from None


def _tip_of_plan(path: Path) -> tuple[Array, Array]:
    """Places (n, 3) [m] and rotations (n, 3, 3) of the tip along a plan, thinned to one every 2 mm."""
    places, turns = _numbers_of_plan(path, "tip_xyz_m", "tip_wxyz")
    if places.ndim != 2 or places.shape[1:] != (3,) or turns.shape != (len(places), 4) or not len(places):
        raise GuidanceError("the plan has no path of the tip", where=str(path), mend="plan again")
    if not np.isfinite(places).all() or not np.isfinite(turns).all():
        raise GuidanceError("a number of the plan is not finite", where=str(path), mend="plan again")
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))]
    kept = np.unique(np.searchsorted(along, np.linspace(0.0, along[-1], 1 + max(1, round(along[-1] / _PLAN_SPACING)))))
    kept = kept[kept < len(places)]
    return places[kept], _rotations(np.hstack([places, turns])[kept], path)


def _unit_of(first: str, unit: str, where: str) -> str:
    _, underscore, named = first.partition("_")
    if not underscore:
        return unit
    if named not in FILE_UNITS:
        raise GuidanceError(f"unknown unit {named!r} in {first!r}", where=where, mend=f"one of {', '.join(FILE_UNITS)}")
    return named


def _rotations(table: Array, path: Path) -> Array:
    lengths = np.linalg.norm(table[:, 3:], axis=1)
    if abs(lengths - 1.0).max() > 0.01:
        length = lengths[abs(lengths - 1.0).argmax()]
        raise GuidanceError(
            f"quaternion of length {length:.3g}", where=str(path), mend="give quaternions of unit length, qw first"
        )
    return matrices(table[:, 3:])
