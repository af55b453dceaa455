"""Reads a recorded indentation: a CSV with force, depth and time, or a Palpate record of a session."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.errors import RecordError, RecordingError
from palpate.record.reader import Record
from palpate.record.ticks import Ticks

UNITS = {
    "time": {"s": 1.0, "ms": 1e-3},
    "depth": {"m": 1.0, "mm": 1e-3, "um": 1e-6},
    "force": {"N": 1.0, "mN": 1e-3, "uN": 1e-6},
}
"""Columns of a CSV, as ``time_s``, ``depth_mm``, ``force_mN`` and so on, with the sizes of their units."""
LEAST_ROWS = 30
_STRAY = 1.5e-3  # motion along the surface at which a press in a record counts as over [m]


@dataclass(frozen=True)
class Press:
    """A sphere pressed into tissue along the normal of its surface."""

    t: Array
    """(n,) time, rising [s]."""
    depth: Array
    """(n,) travel of the sphere from the first touch, positive into the tissue [m]."""
    force: Array
    """(n,) force of the tissue on the sphere, positive outwards [N]."""
    source: str = ""
    """Path of the recording, for messages."""


def load(path: str | Path) -> Press:
    """Read an indentation.

    A CSV names its columns with their units (`UNITS`); rows need not be evenly spaced. From a record, the longest
    press is taken: from a touch until the tool leaves or moves sideways.

    Raises:
        RecordingError: the file cannot be read, lacks a column, or holds no press.
    """
    path = Path(path)
    press = _csv(path) if path.suffix.lower() in (".csv", ".txt") else _record(path)
    for key in ("t", "depth", "force"):
        values = getattr(press, key)
        if not np.isfinite(values).all():
            row = int(np.argmin(np.isfinite(values)))
            raise RecordingError(f"{key} is not finite in row {row + 1}", where=str(path), mend="delete the row")
    if len(press.t) < LEAST_ROWS:
        mend = "record at 100 Hz or more"
        raise RecordingError(f"{len(press.t)} rows; at least {LEAST_ROWS} are needed", where=str(path), mend=mend)
    if not (np.diff(press.t) > 0).all():
        row = int(np.argmin(np.diff(press.t))) + 2
        raise RecordingError(f"the time does not rise in row {row}", where=str(path), mend="sort the rows by time")
    return press


def _record(path: Path) -> Press:
    try:
        record = Record.open(path)
    except RecordError as error:
        raise RecordingError(error.what, where=str(path), why=error.why, mend=error.mend) from None
    return press_of_ticks(record.read(["t", "contacts", "normal", "p_WT", "F_T_W"]), str(path))


def press_of_ticks(ticks: Ticks, source: str) -> Press:
    """The longest press of a session.

    Raises:
        RecordingError: nothing was touched.
    """
    touching = np.concatenate([[False], ticks["contacts"] > 0, [False]]).astype(int)
    starts, ends = np.flatnonzero(np.diff(touching) == 1), np.flatnonzero(np.diff(touching) == -1)
    presses = [_press(ticks[a:b]) for a, b in zip(starts, ends, strict=True)]
    if not presses:
        raise RecordingError("nothing was touched in this record", where=source, mend="press the tissue and hold")
    t, depth, force = max(presses, key=lambda press: len(press[0]))
    return Press(t, depth, force, source)


def _press(ticks: Ticks) -> tuple[Array, Array, Array]:
    """Time, depth and force of one touch along its first normal, until the tool moves sideways."""
    n = ticks["normal"][0]
    travel = ticks["p_WT"] - ticks["p_WT"][0]
    depth = -travel @ n
    aside = np.linalg.norm(travel + np.outer(depth, n), axis=1) > _STRAY
    end = int(np.argmax(aside)) if aside.any() else len(ticks)
    return ticks["t"][:end], depth[:end], (ticks["F_T_W"] @ n)[:end]


def _csv(path: Path) -> Press:
    try:
        lines = limits.read_text(path, limits.MOST_TABLE, "utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "it is not text"
        raise RecordingError("the recording cannot be read", where=str(path), why=why) from None
    names = [name.strip() for name in lines[0].split(",")] if lines else []
    chosen = [_column(names, quantity, path) for quantity in UNITS]
    rows = []
    for i, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        try:
            texts = line.split(",")
            rows.append([float(texts[index]) * size for index, size in chosen])
        except (ValueError, IndexError):
            why = f"Got: {line[:60]!r}"
            raise RecordingError(
                "not a row of numbers", where=f"{path}:{i}", why=why, mend="correct or delete it"
            ) from None
    t, depth, force = np.array(rows).reshape(-1, 3).T
    return Press(t, depth, force, str(path))


def _column(names: list[str], quantity: str, path: Path) -> tuple[int, float]:
    """Index of the column of a quantity, and the size of its unit."""
    for unit, size in UNITS[quantity].items():
        if f"{quantity}_{unit}" in names:
            return names.index(f"{quantity}_{unit}"), size
    options = ", ".join(f"{quantity}_{unit}" for unit in UNITS[quantity])
    why = f"its first line names {', '.join(names)[:200] or 'nothing'}"
    raise RecordingError(f"no column of the {quantity}", where=str(path), why=why, mend=f"name it one of {options}")
