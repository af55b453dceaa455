"""The ticks of an arm reduced to frames at the rate of a camera.

A frame holds the state at its time, and of each force the least, the mean and the greatest value since the frame
before: a frame of 30 Hz spans 33 ticks, in which the tip of an instrument strikes and is gone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError, RecordError
from palpate.record.ticks import Ticks

SIGNALS = (
    "t", "p_WT", "quat_WT", "jaw", "p_WT_goal", "quat_WT_asked", "jaw_goal", "q_follower", "q_follower_goal", "q",
    "gripper", "F_T_W", "t_T_W", "F_H_L", "t_H_L", "depth", "contacts", "normal",
)  # fmt: skip
"""Signals that the frames are made of."""
AT_ONCE = 3000
"""Frames that are reduced together, which bounds the memory."""
WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")
PEAKS = tuple(f"{part}_{kind}" for kind in ("min", "mean", "max") for part in (*WRENCH, "f"))
"""Columns of the least, mean and greatest wrench of a frame; f is the size of the force."""


class Readable(Protocol):
    """Ticks that are read in parts: a `Record`, or a bag or a simulation made alike."""

    @property
    def rate(self) -> float:
        """Ticks per second [Hz]."""
        ...

    def __len__(self) -> int:
        """Number of ticks."""
        ...

    def read(self, signals: Sequence[str], start: int = 0, stop: int | None = None) -> Ticks:
        """Some signals of some ticks."""
        ...


@dataclass(frozen=True)
class ArmFrames:
    """One arm over n frames. What was not recorded is NaN."""

    t: Array
    """(n,) times of the ticks that the frames show [s]."""
    pose: Array
    """(n, 7) measured tool pose X_WT: x y z [m], quaternion x y z w, without jumps of its sign."""
    goal: Array
    """(n, 7) commanded tool pose, as `pose`."""
    jaw: Array
    """(n, 2) angle of the jaws, measured and commanded [rad]."""
    q: Array
    """(n, 7) joints of the follower, measured [rad, m]."""
    q_goal: Array
    """(n, 7) joints of the follower, commanded [rad, m]."""
    q_leader: Array
    """(n, 8) joints of the leader and its gripper, measured [rad]."""
    wrench: Array
    """(n, 6) wrench of the environment on the instrument at its tip, in W [N, N m]."""
    peaks: Array
    """(n, 21) of `wrench`, in the order of `PEAKS`."""
    hand: Array
    """(n, 6) wrench of the device on the hand, in the axes of the leader's base [N, N m]."""
    hand_peaks: Array
    """(n, 21) of `hand`, in the order of `PEAKS`."""
    contact: Array
    """(n, 5) penetration [m], number of touches, surface normal in W."""

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.t)


def frames_of(ticks: Readable, fps: int, where: str = "") -> ArmFrames:
    """Reduce all ticks to frames. Frame k shows the tick nearest to k / fps after the first one.

    Raises:
        RecordError: fewer ticks per second than frames. PalpateError: less than one frame per second.
    """
    if fps < 1:
        raise PalpateError(f"{fps} frames/s: must be 1 or more")
    if ticks.rate < fps:
        what = f"{fps} frames/s are more than the {ticks.rate:g} ticks/s of the record"
        raise RecordError(what, where=where, mend=f"give --fps {max(1, int(ticks.rate))} or less")
    at = np.rint(np.arange(int((len(ticks) - 1) * fps / ticks.rate + 1e-9) + 1) * ticks.rate / fps).astype(np.int64)
    first = np.concatenate([[0], at[:-1] + 1])  # of the ticks since the frame before
    parts = [
        _reduce(ticks.read(SIGNALS, int(first[a]), int(at[b - 1]) + 1), at[a:b] - first[a], first[a:b] - first[a])
        for a in range(0, len(at), AT_ONCE)
        for b in [min(a + AT_ONCE, len(at))]
    ]
    whole = {f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(ArmFrames)}
    for name in ("pose", "goal"):
        whole[name][:, 3:] = _continuous(whole[name][:, 3:])
    return ArmFrames(**whole)


def _reduce(ticks: Ticks, at: NDArray[np.int64], first: NDArray[np.int64]) -> ArmFrames:
    """Frames of ticks: `at` are the ticks that they show, `first` those after the frame before."""
    wrench = np.concatenate([ticks["F_T_W"], ticks["t_T_W"]], axis=1)
    hand = np.concatenate([ticks["F_H_L"], ticks["t_H_L"]], axis=1)
    shown = ticks[at]

    def column(*names: str) -> Array:
        return np.concatenate([np.asarray(shown[name]).reshape(len(at), -1) for name in names], axis=1)

    return ArmFrames(
        t=np.array(shown["t"]),
        pose=column("p_WT", "quat_WT")[:, [0, 1, 2, 4, 5, 6, 3]],
        goal=column("p_WT_goal", "quat_WT_asked")[:, [0, 1, 2, 4, 5, 6, 3]],
        jaw=column("jaw", "jaw_goal"),
        q=column("q_follower"),
        q_goal=column("q_follower_goal"),
        q_leader=column("q", "gripper"),
        wrench=wrench[at],
        peaks=_peaks(wrench, first),
        hand=hand[at],
        hand_peaks=_peaks(hand, first),
        contact=column("depth", "contacts", "normal"),
    )


def _peaks(wrench: Array, first: NDArray[np.int64]) -> Array:
    """(n, 21) least, mean and greatest values of a wrench (m, 6) and of the size of its force, from each first tick."""
    values = np.column_stack([wrench, np.linalg.norm(wrench[:, :3], axis=1)])
    counts = np.diff(np.append(first, len(values)))[:, None]
    least, most = np.minimum.reduceat(values, first, axis=0), np.maximum.reduceat(values, first, axis=0)
    return np.concatenate([least, np.add.reduceat(values, first, axis=0) / counts, most], axis=1)


def _continuous(quaternions: Array) -> Array:
    """Quaternions (n, 4), x y z w, each with the sign nearer to the one before; the first has w >= 0."""
    along = np.einsum("ij,ij->i", quaternions[1:], quaternions[:-1])
    first = -1.0 if len(quaternions) and quaternions[0, 3] < 0.0 else 1.0
    signs = first * np.cumprod(np.concatenate([[1.0], np.where(along < 0.0, -1.0, 1.0)]))
    return np.asarray(quaternions * signs[:, None])
