"""Fiducials of 3D Slicer, .fcsv and .mrk.json: points in metres of the patient frame LPS, by their labels."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.errors import RegistrationError
from palpate.base.values.units import FILE_UNITS

ENDINGS = (".fcsv", ".mrk.json")
_SIGNS = {"LPS": (1.0, 1.0, 1.0), "1": (1.0, 1.0, 1.0), "RAS": (-1.0, -1.0, 1.0), "0": (-1.0, -1.0, 1.0)}
_COLUMNS = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID"  # of files that do not name them
_KINDS = ("Fiducial", "PointList", "Line", "Curve", "ClosedCurve", "Angle")

Named = tuple[tuple[str, ...], Array]


def is_slicer(path: Path) -> bool:
    """Whether the name of a file ends as those of 3D Slicer's fiducials do."""
    return path.name.lower().endswith(ENDINGS)


def read(path: Path) -> Named:
    """Labels and points (N, 3) [m] in LPS.

    Raises:
        RegistrationError: the file cannot be read, names no known frame or unit, or holds no points.
    """
    try:
        text = limits.read_text(path, limits.MOST_TABLE, "utf-8-sig")
        names, points = (
            _fcsv(path, text) if path.name.lower().endswith(".fcsv") else _json(path, limits.load_json(text))
        )
    except RegistrationError:
        raise
    except (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError, csv.Error) as error:
        why, mend = " ".join(str(error).split())[:200], "save the markups again from 3D Slicer"
        raise RegistrationError("the fiducials cannot be read", where=str(path), why=why, mend=mend) from None
    if not len(points):
        raise RegistrationError("the file holds no placed point", where=str(path), mend="place the fiducials, and save")
    return _unique(names), points


def _signs(path: Path, system: str) -> Array:
    if system.upper() not in _SIGNS:
        raise RegistrationError(
            f"the coordinate system {system or 'is not named'!r} is not read", where=str(path), why="LPS and RAS are",
            mend="save the markups again from 3D Slicer, which names LPS or RAS in the file",
        )  # fmt: skip
    return np.array(_SIGNS[system.upper()])


def _fcsv(path: Path, text: str) -> tuple[list[str], Array]:
    notes = {}
    for line in text.splitlines():
        key, sign, value = line.lstrip("# ").partition("=")
        if line.startswith("#") and sign:
            notes[key.strip().lower()] = value.strip()
    signs = _signs(path, notes.get("coordinatesystem", ""))
    columns = notes.get("columns", _COLUMNS).lower().split(",")
    place, label = [columns.index(axis) for axis in "xyz"], columns.index("label")
    rows = list(csv.reader(line for line in text.splitlines() if line.strip() and not line.startswith("#")))
    points = np.array([[float(row[k]) for k in place] for row in rows]).reshape(-1, 3)
    return [row[label].strip() or row[0] for row in rows], signs * points * FILE_UNITS["mm"]


def _json(path: Path, tree: Any) -> tuple[list[str], Array]:
    if not isinstance(tree, dict) or not isinstance(tree.get("markups"), list):
        raise ValueError("it has no list of markups")
    lists = [one for one in tree["markups"] if one.get("controlPoints")]
    if len(lists) > 1:
        what = f"{len(lists)} lists of markups"
        raise RegistrationError(what, where=str(path), mend="save the list that was measured into a file of its own")
    names, points = [], []
    for one in lists:
        if str(one.get("type", "Fiducial")) not in _KINDS:
            kind = one["type"]
            raise RegistrationError(
                f"markups of type {kind} are no list of points", where=str(path), mend="save a list"
            )
        signs, unit = _signs(path, str(one.get("coordinateSystem", ""))), str(_unit(one))
        if unit not in FILE_UNITS:
            raise RegistrationError(f"the unit {unit!r} is not known", where=str(path), mend="save the markups in mm")
        for k, point in enumerate(one["controlPoints"]):
            if str(point.get("positionStatus", "defined")) != "defined":
                continue  # a point that was named and never placed
            names.append(str(point.get("label") or point.get("id") or k))
            points.append(signs * np.array([float(x) for x in point["position"]]) * FILE_UNITS[unit])
    return names, np.array(points).reshape(-1, 3)


def _unit(markup: Any) -> str:
    unit = markup.get("coordinateUnits", "mm")
    if isinstance(unit, list):  # code of a terminology: UCUM, mm, millimeter
        unit = next((word for word in unit if word in FILE_UNITS), unit[0])
    return str(unit)


def _unique(names: list[str]) -> tuple[str, ...]:
    """The labels, or numbers where a label appears twice."""
    return tuple(names) if len(set(names)) == len(names) else tuple(str(k) for k in range(len(names)))
