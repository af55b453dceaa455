"""What an operator is to do: a path to follow, how wide the passage is, how hard to press on the way; and doing it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from palpate import _core
from palpate.record.ticks import as_ticks

if TYPE_CHECKING:
    from palpate.operators.operator import Operator

Array = NDArray[np.float64]

EVERY = 4
"""Rows of the cycle per row of a trial."""
_THERE = 1e-3  # so near to its end a path is done [m]
_AHEAD = 0.008  # how much of the path is looked through for the nearest point, forwards [m]


@dataclass(frozen=True)
class Aim:
    """What is wanted of a tool where it is seen."""

    error: Array
    """(3,) from the tool to the path, without its part along it, and along `into` where something is pressed [m]."""
    along: Array
    """(3,) unit: where the path goes on."""
    ahead: float
    """How much of the path is left [m]."""
    width: float
    """Of the passage [m]."""
    press: float
    """Force to press with; 0: none [N]."""
    into: Array
    """(3,) unit: the direction that presses."""
    stiffness: float
    """That the operator expects of what is pressed, as the tool feels it [N/m]."""


@dataclass(frozen=True)
class Errand:
    """A path of the tool with a passage around it."""

    path: Array
    """(n, 3) points close to each other, in W [m]."""
    width: Array
    """(n,) of the passage there: what the steering law goes by [m]."""
    stiffness: float
    """Of what the tool touches [N/m]."""
    press: float = 0.0
    """Force to press with along the way; 0: touch nothing [N]."""
    into: tuple[float, float, float] = (0.0, 0.0, -1.0)
    """Unit: the direction that presses."""

    def __post_init__(self) -> None:
        """Lengths along the path."""
        steps = np.linalg.norm(np.diff(self.path, axis=0), axis=1)
        object.__setattr__(self, "s", np.concatenate([[0.0], np.cumsum(steps)]))

    s: Array = None  # type: ignore[assignment]
    """(n,) length of the path up to each point [m]."""

    def aim(self, x: Array, begin: int, preview: float = 0.0) -> tuple[Aim, int]:
        """What is wanted of a tool seen at x (3,), and the point of the path it has come to, from `begin` on.

        preview: how far ahead of there the path's direction is looked up [m].
        """
        last = len(self.path) - 1
        end = int(np.searchsorted(self.s, self.s[begin] + _AHEAD)) + 1
        away = self.path[begin:end] - x
        into = np.array(self.into)
        if self.press > 0.0:
            away = away - np.outer(away @ into, into)
        i = begin + int(np.argmin(np.einsum("ij,ij->i", away, away)))
        j = min(int(np.searchsorted(self.s, self.s[i] + preview)), last)
        before, after = self.path[max(j - 1, 0)], self.path[min(j + 1, last)]
        along = (after - before) / np.linalg.norm(after - before)
        error = away[i - begin]
        error = error - along * float(along @ error)
        return Aim(
            error, along, float(self.s[-1] - self.s[i]), float(self.width[i]), self.press, into, self.stiffness
        ), i


@dataclass(frozen=True)
class Trial:
    """What a simulated operator did, every `EVERY` rows of the haptic cycle."""

    t: Array
    """(n,) [s]"""
    p_WT: Array
    """(n, 3) tool [m]."""
    F_T: Array
    """(n,) of the tool's spring contact with what it touches [N]."""
    F_hand: Array
    """(n,) of the device on the hand [N]."""
    done: bool
    """the end of the path was reached in time."""


def perform(sim: _core.Simulation, operator: Operator, errand: Errand, X_WL: Array, scale: float, most: float) -> Trial:
    """Let an operator do an errand in a simulation that stands at its beginning, at 1000 cycles a second.

    Args:
        sim: fresh; its hand has no path of its own.
        operator: fresh, too.
        errand: what to do.
        X_WL: (4, 4) base of the leader.
        scale: tool motion per hand motion.
        most: longest that it may take [s].
    """
    from palpate.operators.operator import STEP

    n = round(STEP * 1000)
    R_WL, hand, at = X_WL[:3, :3], np.zeros(3), 0
    kept: list[Array] = []
    ramp = (np.arange(1, n + 1) / n)[:, None]
    rows = as_ticks(sim.run(n))
    while True:
        now = rows[-1]
        seen = operator.x
        aim, at = errand.aim(now["p_WT"] if seen is None else seen, at, operator.preview)
        done = aim.ahead < _THERE
        if done or len(kept) * STEP > most:
            break
        F_T = errand.stiffness * float(now["depth"])
        step = STEP * operator.lead(now["p_WT"], F_T, R_WL @ now["F_H_L"], aim, scale)
        rows = as_ticks(sim.run(n, hand + ramp * step))
        hand = hand + step
        some = rows[::EVERY]
        kept.append(np.column_stack([some["t"], some["p_WT"], some["depth"], np.linalg.norm(some["F_H_L"], axis=1)]))
    all_ = np.concatenate(kept)
    return Trial(all_[:, 0], all_[:, 1:4], errand.stiffness * all_[:, 4], all_[:, 5], done)
