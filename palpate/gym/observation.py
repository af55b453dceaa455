"""What the environments observe: arrays by name, and their spaces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from palpate.arrays import Array
from palpate.errors import PalpateError
from palpate.record.ticks import Ticks

PARTS = ("pose", "joints", "force", "contact", "goal")
"""Parts of an observation, in their order."""
_FAR = 10.0  # largest position [m] and angle [rad]
_LARGE = 1000.0  # largest force [N] and torque [N m]

Observation = dict[str, NDArray[Any]]
"""Arrays by name: float32, and the picture of type uint8."""


def space_of(parts: Sequence[str], joints: int, picture: tuple[int, int] | None = None) -> spaces.Dict:
    """The space of an observation.

    Raises:
        PalpateError: a part is unknown.
    """
    boxes = {
        "pose": spaces.Box(-_FAR, _FAR, (7,), np.float32),
        "joints": spaces.Box(-_FAR, _FAR, (joints,), np.float32),
        "force": spaces.Box(-_LARGE, _LARGE, (7,), np.float32),
        "contact": spaces.Box(-_FAR, _LARGE, (5,), np.float32),
        "goal": spaces.Box(-_FAR, _FAR, (3,), np.float32),
    }
    unknown = [part for part in parts if part not in boxes]
    if unknown or not parts:
        mend = f"name some of {', '.join(PARTS)}"
        raise PalpateError(f"observe = {tuple(parts)}: {', '.join(unknown) or 'nothing'} to observe", mend=mend)
    found: dict[str, spaces.Space[Any]] = {part: boxes[part] for part in PARTS if part in parts}
    if picture is not None:
        found["picture"] = spaces.Box(0, 255, (*picture, 3), np.uint8)
    return spaces.Dict(found)


def observe(parts: Sequence[str], joints: int, ticks: Ticks, felt: Array, goals: Array) -> Observation:
    """Fresh arrays (n, size) by name, of n ticks, largest forces felt (n,) [N] and places of the task (n, 3) [m].

    ``pose``: measured pose of the tool in W, x y z [m] and quaternion w x y z with w >= 0. ``joints`` [rad, m].
    ``force``: force [N] and torque [N m] of the environment on the tool in W, and the largest force that a hand would
    have felt since the last step. ``contact``: penetration [m], touches, surface normal in W. ``goal``: the place of
    the task from the tool, in W [m].
    """

    def column(*names: str) -> Array:
        return np.concatenate([np.asarray(ticks[name]).reshape(len(ticks), -1) for name in names], axis=1)

    told = np.any(goals, axis=1, keepdims=True)
    made: dict[str, Callable[[], Array]] = {
        "pose": lambda: np.concatenate([ticks["p_WT"], ticks["quat_WT"] * _sign(ticks["quat_WT"][:, :1])], axis=1),
        "joints": lambda: ticks["q_follower"][:, :joints],
        "force": lambda: np.column_stack([column("F_T_W", "t_T_W"), felt]),
        "contact": lambda: column("depth", "contacts", "normal"),
        "goal": lambda: np.where(told, goals - ticks["p_WT"], 0.0),
    }
    limits = {"force": _LARGE, "contact": _LARGE}
    return {
        part: np.clip(made[part](), -limits.get(part, _FAR), limits.get(part, _FAR)).astype(np.float32)
        for part in PARTS
        if part in parts
    }


def _sign(w: Array) -> Array:
    return np.where(w < 0.0, -1.0, 1.0)
