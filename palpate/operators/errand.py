"""What an operator is to do: a path to follow, how wide the passage is, how hard to press on the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.arrays import Array

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
