"""Reads and checks the recordings that an arm is identified from: static poses, and motions."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm
from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.arrays.checks import is_number
from palpate.base.errors import RecordingError

_LEVELS = 10  # a grid has at most this many levels per joint
_OTHER_SIDE = {"mtm_left": "right", "mtm_right": "left"}
_STILL = 2e-3  # consecutive rows closer than this are samples of one pose [rad]
_MOTOR_SIDE = 0.02  # if no median torque exceeds this, torques were recorded before the gears [N m]


@dataclass(frozen=True)
class Static:
    """Poses at which an arm was held, in order of visits and joint coordinates; tau is the holding torque."""

    q: Array  # (m, n) [rad]
    tau: Array  # (m, n) [N m]
    start: NDArray[np.bool_]  # (m,) first pose of a file: its approach direction is unknown
    files: tuple[str, ...]
    samples: int  # rows read; more than m if poses were sampled several times

    def __len__(self) -> int:
        return len(self.q)

    def only(self, rows: NDArray[np.bool_]) -> Static:
        """A subset of the poses; rows (m,) is a mask. Approach directions follow from the remaining poses."""
        start = self.start[rows]
        if len(start):
            start[0] = True
        return replace(self, q=self.q[rows], tau=self.tau[rows], start=start)


@dataclass(frozen=True)
class Moving:
    """A motion sampled evenly, in the coordinates of its file."""

    q: Array  # (m, n) [rad, m]
    v: Array  # (m, n) [rad/s, m/s]
    tau: Array  # (m, n) [N m, N]
    rate: float  # [Hz]
    file: str

    def __len__(self) -> int:
        return len(self.q)


def read_static(paths: str | Path | Sequence[str | Path], arm: Arm) -> Static:
    """Read static recordings: CSV with q1_rad.., tau1_Nm.. per joint of `arm`, one or more consecutive rows per pose.

    A column `pose` is allowed; rows without a header are q(n), tau(n). Consecutive rows within 2 mrad are one pose and
    are averaged.

    Raises:
        RecordingError: wrong columns, NaN, units other than rad and N m in joint coordinates, joints outside the
            arm's limits, or an empty file. The message names file, line and column.
    """
    paths = [paths] if isinstance(paths, str | Path) else list(paths)
    n, parts, starts, samples = arm.n, [], [], 0
    for path in paths:
        rows = _table(Path(path), [f"q{k}_rad" for k in range(1, n + 1)] + [f"tau{k}_Nm" for k in range(1, n + 1)])
        check_joints(rows[:, :n], arm, path)
        _check_torques(rows[:, n:], path)
        poses = _poses(rows, n)
        parts.append(poses)
        starts.append(np.arange(len(poses)) == 0)
        samples += len(rows)
    if not parts:
        raise RecordingError("no recording given", mend="name at least one CSV file")
    whole = np.concatenate(parts)
    return Static(whole[:, :n], whole[:, n:], np.concatenate(starts), tuple(str(p) for p in paths), samples)


def read_moving(path: str | Path, joints: int, rate: float = 200.0) -> Moving:
    """Read a moving recording: CSV of q(n), v(n), tau(n), with or without the header q1_rad.., dq1_rad_s.., tau1_Nm...

    Units and coordinates are those of the file. Raises RecordingError as `read_static` does.
    """
    names = [f"{symbol}{k}{unit}" for symbol, unit in (("q", "_rad"), ("dq", "_rad_s"), ("tau", "_Nm"))
             for k in range(1, joints + 1)]  # fmt: skip
    rows = _table(Path(path), names)
    return Moving(rows[:, :joints], rows[:, joints : 2 * joints], rows[:, 2 * joints :], rate, str(path))


def on_levels(poses: Static) -> Static:
    """Replace the joint positions of a grid of poses by the levels of the grid; other poses stay unchanged.

    A servo yields under its load, so within a level (about 0.01 rad) the position follows the torque. That slope is the
    compliance of the servo, not a property of the arm, and with a thousand poses per level the fit would adopt it.
    """
    q = poses.q.copy()
    for x in q.T:
        order = np.argsort(x)
        gaps = np.diff(x[order])
        wide = gaps > 0.5 * gaps.max(initial=0.0)
        if 0 < wide.sum() <= _LEVELS and len(x) > 50 * _LEVELS:
            level = np.empty(len(x), dtype=int)
            level[order] = np.concatenate([[0], np.cumsum(wide)])
            x[:] = (np.bincount(level, x) / np.bincount(level))[level]
    return replace(poses, q=q)


def check_joints(q: Array, arm: Arm, path: str | Path, margin: float = 0.05) -> None:
    """Refuse joint positions (m, n) outside the limits; recognises degrees, motor turns and the other arm.

    Raises:
        RecordingError: a joint is outside its limits; the message names row, joint, value and limits.
    """
    over = _beyond(q, arm) - margin
    if (over <= 0).all():
        return
    row, joint = np.unravel_index(int(np.argmax(over)), over.shape)
    value, low, high = q[row, joint], arm.q_min[joint], arm.q_max[joint]
    mend = "record joint positions in rad, on the joint's side of gears and couplings"
    why = f"{arm.name} has {low:.3f} to {high:.3f} rad there"
    far = abs(value) / max(abs(low), abs(high))
    if (other := _OTHER_SIDE.get(arm.name)) and (_beyond(q, Arm.mtm(other)) <= margin).all():
        why += f"; all rows fit the {other} arm"
        mend = f"name the arm that was recorded (--arm mtm{other[0]})"
    elif far > 3.0 and (_beyond(np.radians(q), arm) <= margin).all():
        why += "; all rows fit when they are read as degrees (or as turns of the motors, before their gears)"
        mend = "convert the file to rad of the joints"
    elif far > 8.0:
        why += "; numbers of this size are motor turns or encoder counts"
    raise RecordingError(f"joint {joint + 1} is at {value:.4g} in pose {row + 1}", where=str(path), why=why, mend=mend)


def _beyond(q: Array, arm: Arm) -> Array:
    return np.asarray(np.maximum(q - arm.q_max, arm.q_min - q))


def _check_torques(tau: Array, path: str | Path) -> None:
    loads = np.median(np.abs(tau), axis=0)
    if loads.max() < _MOTOR_SIDE:
        raise RecordingError(
            f"no joint holds more than {loads.max():.2g} N m in most poses",
            where=str(path),
            why="an arm's own weight is tenths of N m at its joints; at the motor, before the gear, it is about 1/50",
            mend="record joint torques in N m (the dVRK's measured_js effort)",
        )


def _poses(rows: Array, n: int) -> Array:
    """Mean of the rows of each pose."""
    moved = np.abs(np.diff(rows[:, :n], axis=0)).max(axis=1) > _STILL
    pose = np.concatenate([[0], np.cumsum(moved)])
    sums = np.zeros((int(pose[-1]) + 1, rows.shape[1]))
    np.add.at(sums, pose, rows)
    means: Array = sums / np.bincount(pose)[:, None]
    return means


def _table(path: Path, names: list[str]) -> Array:
    """The named columns of a CSV file, (rows, len(names)); every value finite."""
    try:
        text = limits.read_text(path, limits.MOST_TABLE, "utf-8-sig").split("\n")
        lines = [(number, line) for number, line in enumerate(csv.reader(text), 1) if any(line)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise RecordingError("the recording cannot be read", where=str(path), why=why, mend="name a CSV file") from None
    columns = list(range(len(names)))
    if lines and not is_number(lines[0][1][0]):
        columns = _columns([word.strip() for word in lines.pop(0)[1]], names, path)
        width = None
    else:
        width = len(names)
    if not lines:
        raise RecordingError("the recording has no rows", where=str(path), mend="record some poses")
    table = np.empty((len(lines), len(names)))
    for i, (number, line) in enumerate(lines):
        if (width is not None and len(line) != width) or len(line) <= max(columns):
            raise _wrong_width(f"{path}:{number}", len(line), names)
        for k, column in enumerate(columns):
            table[i, k] = _value(line[column], f"{path}:{number}", names[k])
    return table


def _columns(header: list[str], names: list[str], path: Path) -> list[int]:
    missing = [name for name in names if name not in header]
    if not missing:
        return [header.index(name) for name in names]
    symbol = missing[0].split("_")[0]
    near = [word for word in header if word.split("_")[0] == symbol]
    if near:
        raise RecordingError(
            f"column {near[0]!r} where {missing[0]!r} is needed",
            where=f"{path}:1",
            why="the unit is part of the name, and it differs",
            mend="convert the column and rename it",
        )
    raise _wrong_width(f"{path}:1", len(header), names, f"no column {', '.join(missing)}")


def _wrong_width(where: str, width: int, names: list[str], what: str = "") -> RecordingError:
    return RecordingError(
        what or f"{width} columns",
        where=where,
        why=f"{len(names)} are needed: {names[0]} .. {names[-1]}",
        mend="write them in this order, or with a header line of these names",
    )


def _value(word: str, where: str, name: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise RecordingError(
            f"{name} is {word.strip() or 'empty'!r}", where=where, why="every value must be a finite number",
            mend="drop the row",
        )  # fmt: skip
    return value
