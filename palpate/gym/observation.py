"""What the environments observe: arrays by name, and their spaces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.record.ticks import Ticks

PARTS = ("pose", "joints", "force", "contact", "goal")
"""Parts of an observation of any scene, in their order."""
MORE = ("jaw", "bodies")
"""Further parts: of a scene whose jaws are moved, and of one with bodies that move."""
_FAR = 10.0  # largest position [m] and angle [rad]
_LARGE = 1000.0  # largest force [N] and torque [N m]

Observation = dict[str, NDArray[Any]]
"""Arrays by name: float32, and the picture of type uint8."""


def space_of(
    parts: Sequence[str], joints: int, picture: tuple[int, int] | None = None, hands: int = 1, bodies: int = 0
) -> spaces.Dict:
    """The space of an observation, for several hands with the values of one after the other.

    Raises:
        PalpateError: a part is unknown, or there is nothing of it.
    """
    if "bodies" in parts and bodies == 0:
        raise PalpateError("observe = bodies: the scene has no body that moves", mend="leave bodies out of observe")
    sizes = {
        "pose": (-_FAR, _FAR, 7), "joints": (-_FAR, _FAR, joints), "force": (-_LARGE, _LARGE, 7),
        "contact": (-_FAR, _LARGE, 5), "goal": (-_FAR, _FAR, 3), "jaw": (-_FAR, _FAR, 1),
    }  # fmt: skip
    boxes = {part: spaces.Box(low, high, (hands * n,), np.float32) for part, (low, high, n) in sizes.items()}
    boxes["bodies"] = spaces.Box(-_FAR, _FAR, (7 * bodies,), np.float32)
    unknown = [part for part in parts if part not in boxes]
    if unknown or not parts:
        mend = f"name some of {', '.join((*PARTS, *MORE))}"
        raise PalpateError(f"observe = {tuple(parts)}: {', '.join(unknown) or 'nothing'} to observe", mend=mend)
    found: dict[str, spaces.Space[Any]] = {part: boxes[part] for part in (*PARTS, *MORE) if part in parts}
    if picture is not None:
        found["picture"] = spaces.Box(0, 255, (*picture, 3), np.uint8)
    return spaces.Dict(found)


def observe(
    parts: Sequence[str], joints: int, ticks: Ticks, felt: Array, goals: Array, bodies: Array | None = None
) -> Observation:
    """Fresh arrays (n, size) by name, of n ticks, largest forces felt (n,) [N] and places of the task (n, 3) [m].

    ``pose``: measured pose of the tool in W, x y z [m] and quaternion w x y z with w >= 0. ``joints`` [rad, m].
    ``force``: force [N] and torque [N m] of the environment on the tool in W, and the largest force that a hand would
    have felt since the last step. ``contact``: penetration [m], touches, surface normal in W. ``goal``: the place of
    the task from the tool, in W [m]. ``jaw``: its angle [rad]. ``bodies``: poses of the bodies that move, as those of
    the tool. Of ticks and forces (n, h), the values of the h hands follow each other.
    """
    n = len(ticks)
    hands = ticks.size // max(n, 1)
    ticks, places = ticks.reshape(-1), np.repeat(goals, hands, axis=0)

    def column(*names: str) -> Array:
        return np.concatenate([np.asarray(ticks[name]).reshape(len(ticks), -1) for name in names], axis=1)

    told = np.any(places, axis=1, keepdims=True)
    made: dict[str, Callable[[], Array]] = {
        "pose": lambda: poses(column("p_WT", "quat_WT")),
        "joints": lambda: ticks["q_follower"][:, :joints],
        "force": lambda: np.column_stack([column("F_T_W", "t_T_W"), felt.ravel()]),
        "contact": lambda: column("depth", "contacts", "normal"),
        "goal": lambda: np.where(told, places - ticks["p_WT"], 0.0),
        "jaw": lambda: column("jaw"),
        "bodies": lambda: np.zeros((n, 0)) if bodies is None else bodies,
    }
    limits = {"force": _LARGE, "contact": _LARGE}
    return {
        part: np.clip(made[part](), -limits.get(part, _FAR), limits.get(part, _FAR)).astype(np.float32).reshape(n, -1)
        for part in (*PARTS, *MORE)
        if part in parts
    }


def poses(rows: Array) -> Array:
    """Poses (..., 7) x y z and quaternion w x y z, with w >= 0."""
    return np.concatenate([rows[..., :3], rows[..., 3:] * _sign(rows[..., 3:4])], axis=-1)


def _sign(w: Array) -> Array:
    return np.where(w < 0.0, -1.0, 1.0)
