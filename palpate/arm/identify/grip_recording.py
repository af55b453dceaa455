"""Reads a recorded grip: a Palpate record (MCAP) of a session with a load cell, or a CSV of one direction."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from palpate.arm.identify.hand import Grip
from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.errors import RecordError, RecordingError
from palpate.record.reader import Record
from palpate.record.ticks import Ticks

COLUMNS = ("t_s", "x_m", "F_N")
EXCITATION = "u"
_SIGNALS = ["t", "contacts", "F_cell_L", "F_H_L", "p_LH", "p_WP", "normal"]
_SETTLE = 2.0  # time after the start of contact that is discarded [s]


def load(path: str | Path) -> Grip:
    """Read a grip.

    From a record, the longest contact is used, from 2 s after its start, along the direction in which the commanded
    force varies most; the excitation u is the position of the proxy on the moving surface. A CSV has the columns
    ``t_s``, ``x_m``, ``F_N`` (force of the arm on the hand) and, if known, ``u`` (the excitation, in any unit). All
    columns are along one direction.

    Raises:
        RecordingError: the file cannot be read, is not sampled evenly, or holds no contact.
    """
    path = Path(path)
    return _csv(path) if path.suffix.lower() == ".csv" else _record(path)


def _record(path: Path) -> Grip:
    try:
        record = Record.open(path)
    except RecordError as error:
        raise RecordingError(error.what, where=str(path), why=error.why, mend=error.mend) from None
    return grip_of_ticks(record.read(_SIGNALS), record.rate, str(path))


def grip_of_ticks(ticks: Ticks, rate: float, source: str) -> Grip:
    """The grip during the longest contact of a session.

    Raises:
        RecordingError: no contact lasted long enough, or the record has no load cell.
    """
    touching = np.concatenate([[False], ticks["contacts"] > 0, [False]]).astype(int)
    starts, ends = np.flatnonzero(np.diff(touching) == 1), np.flatnonzero(np.diff(touching) == -1)
    if not len(starts):
        mend = "run scenes/grip.yaml: its moving wall pushes the hand"
        raise RecordingError("nothing was touched in this record", where=source, mend=mend)
    k = int(np.argmax(ends - starts))
    held = ticks[starts[k] + round(_SETTLE * rate) : ends[k]]
    if len(held) < 2:
        mend = "run scenes/grip.yaml for 40 s"
        raise RecordingError("the handle was pushed for less than 2 s", where=source, mend=mend)
    if not held["F_cell_L"].any():
        raise RecordingError("the record holds no load cell", where=source, mend="mount one in the handle")
    push = held["F_H_L"] - held["F_H_L"].mean(axis=0)
    n = np.linalg.svd(push.T @ push)[0][:, 0]
    n = n * np.sign(n[np.argmax(np.abs(n))])
    x, F, u = held["p_LH"] @ n, held["F_cell_L"] @ n, held["p_WP"] @ held["normal"].mean(axis=0)
    return Grip(rate, x, F, u, (float(n[0]), float(n[1]), float(n[2])), source)


def _csv(path: Path) -> Grip:
    try:
        lines = limits.read_text(path, limits.MOST_TABLE).splitlines()
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "it is not text"
        raise RecordingError("the recording cannot be read", where=str(path), why=why) from None
    names = [name.strip() for name in lines[0].split(",")] if lines else []
    missing = [name for name in COLUMNS if name not in names]
    if missing:
        why = f"its first line names {', '.join(names)[:200] or 'nothing'}"
        mend = f"columns {', '.join(COLUMNS)}, and {EXCITATION} where it is known"
        raise RecordingError(f"column {missing[0]} is missing", where=str(path), why=why, mend=mend)
    table = _numbers(path, lines[1:], len(names))
    column = {name: table[:, i] for i, name in enumerate(names)}
    return Grip(_rate(path, column["t_s"]), column["x_m"], column["F_N"], column.get(EXCITATION), None, str(path))


def _numbers(path: Path, lines: list[str], width: int) -> Array:
    rows = []
    for i, line in enumerate(lines):
        if not line.strip():
            continue
        try:
            row = [float(text) for text in line.split(",")]
        except ValueError:
            row = []
        if len(row) != width:
            why = f"a row holds {width} numbers. Got: {line[:60]!r}"
            raise RecordingError("not a row of numbers", where=f"{path}:{i + 2}", why=why, mend="correct or delete it")
        rows.append(row)
    return np.array(rows).reshape(-1, width)


def _rate(path: Path, t: Array) -> float:
    steps = np.diff(t)
    if len(steps) < 2 or not np.isfinite(steps).all() or not steps.min() > 0.0:
        raise RecordingError("t_s must rise from row to row", where=str(path), mend="sort the rows; seconds, evenly")
    rate = 1.0 / float(np.median(steps))
    worst = float(np.abs(steps * rate - 1.0).max())
    if worst > 0.1:
        why = f"steps of {1e3 * steps.min():.3g} to {1e3 * steps.max():.3g} ms"
        raise RecordingError("not sampled evenly", where=str(path), why=why, mend="record, or resample, at one rate")
    return rate
