"""The task of an operator: a path to follow, the width of the passage, and the force to press with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.record.ticks import Ticks

_AHEAD = 0.008  # length of path, ahead of the last nearest point, that is searched for the next one [m]


@dataclass(frozen=True)
class Aim:
    """Local goal for a tool at its seen position."""

    error: Array
    """(3,) vector from the tool to the path, without its components along the path and, when pressing, `into` [m]."""
    along: Array
    """(3,) unit tangent of the path, forwards."""
    ahead: float
    """Remaining length of the path [m]."""
    width: float
    """Width of the passage [m]."""
    press: float
    """Force to press with; 0: do not press [N]."""
    into: Array
    """(3,) unit vector of the pressing direction."""
    stiffness: float
    """Stiffness that the operator expects of the pressed surface, at the tool [N/m]."""


@dataclass(frozen=True)
class Errand:
    """A path of the tool with a passage around the path."""

    path: Array
    """(n, 3) closely spaced points in W [m]."""
    width: Array
    """(n,) width of the passage at each point, for the steering law [m]."""
    stiffness: float
    """Stiffness of the touched surface [N/m]."""
    press: float = 0.0
    """Force to press with along the path; 0: touch nothing [N]."""
    into: tuple[float, float, float] = (0.0, 0.0, -1.0)
    """Unit vector of the pressing direction, in W."""
    rendered: bool = False
    """True: the force of the tool is the rendered one; False: stiffness times depth."""

    def force(self, tick: Ticks) -> float:
        """Force of the tool on the touched surface at a tick [N]."""
        return float(np.linalg.norm(tick["F_T_W"])) if self.rendered else self.stiffness * float(tick["depth"])

    def __post_init__(self) -> None:
        """Compute the arc length at each point."""
        steps = np.linalg.norm(np.diff(self.path, axis=0), axis=1)
        object.__setattr__(self, "s", np.concatenate([[0.0], np.cumsum(steps)]))

    s: Array = None  # type: ignore[assignment]
    """(n,) arc length at each point [m]."""

    def aim(self, x: Array, begin: int, preview: float = 0.0) -> tuple[Aim, int]:
        """The local goal for a tool seen at x (3,) [m], and the index of the nearest path point, searched from `begin`.

        preview: distance ahead of the nearest point at which the tangent is taken [m].
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
