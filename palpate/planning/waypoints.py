"""A plan as way points for an arm that interpolates between them by itself, such as CRTK's move_jp.

Between two way points the arm starts and ends at rest, and all joints arrive together, but they need not move in step:
a joint that accelerates for longer is behind the others at first and ahead of them later. The share of its way that a
joint has made, p_j(tau), is symmetric in time and lies between that of a constant speed and that of a constant jerk:
  p = tau   and   p = 16/3 tau^3 (tau < 1/4)     differ by 1/6 at most, at tau = 1/4 of the duration.
All joints are therefore within SPREAD = 1/12 of a common share, and `Checker.blocked` proves all such motions free.
"""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PlanningError
from palpate.planning.checker import Blocked, Checker
from palpate.planning.curves import Curve, line
from palpate.planning.result import Plan

SPREAD = 1.0 / 12.0
"""Share of a leg by which a joint may be ahead of the common motion of all joints, or behind it [-]."""
_HALVINGS = 6  # of one curve of the plan


def waypoints(checker: Checker, plan: Plan, clearance: float) -> Array:
    """Joint positions (k, n) from the plan's start to its goal, between which the arm may interpolate by itself.

    Every leg is proved to keep the clearance [m] for all motions within `SPREAD`. A plan that passes something at just
    its clearance has no such way points: they need a little less.

    Raises:
        PlanningError: a part of the plan cannot be proved however short its legs are; the message names the pair.
    """
    rows = [plan.curves[0].controls[0]]
    for curve in plan.curves:
        rows += _ends(checker, curve, 0.0, 1.0, clearance, _HALVINGS)
    return _fewer(checker, np.array(rows), clearance)


def blocked(checker: Checker, a: Array, b: Array, clearance: float) -> Blocked | None:
    """None if a leg from a to b (n,) is proved to keep the clearance [m], however the arm interpolates."""
    return checker.blocked(line(a, b), clearance, SPREAD)


def _ends(checker: Checker, curve: Curve, a: float, b: float, clearance: float, halvings: int) -> list[Array]:
    """Ends of the legs that replace the part from a to b of a curve: one leg, or those of both halves."""
    start, end = curve.at(np.array([a, b]))
    found = blocked(checker, start, end, clearance)
    if found is None:
        return [end]
    if halvings == 0:
        raise PlanningError(
            f"the plan cannot be sent as way points: between two of them {found.pair[0]} may come nearer than "
            f"{1e3 * clearance:g} mm to {found.pair[1]}",
            why="the arm interpolates by itself, and its joints need not move in step",
            mend=f"--clearance {900 * clearance:.2g}mm, or --by servo_jp, which sends the whole path",
        )
    middle = 0.5 * (a + b)
    return [
        *_ends(checker, curve, a, middle, clearance, halvings - 1),
        *_ends(checker, curve, middle, b, clearance, halvings - 1),
    ]


def _fewer(checker: Checker, rows: Array, clearance: float) -> Array:
    """The way points without those that a longer leg can leave out: the arm stops at each."""
    kept, k = [rows[0]], 0
    while k < len(rows) - 1:
        end = k + 1
        while end + 1 < len(rows) and blocked(checker, rows[k], rows[end + 1], clearance) is None:
            end += 1
        kept.append(rows[end])
        k = end
    return np.array(kept)
