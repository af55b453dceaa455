"""Why a start, a goal or a number is refused, in words, and what to do about it."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PlanningError
from palpate.planning import planners
from palpate.planning.checker import Checker, Nearest


def nearest_free(checker: Checker, q: Array, clearance: float, samples: int = 400) -> Array | None:
    """Free joint positions (n,) near q (n,): the first found in growing regions around q; None if there are none."""
    arm, rng = checker.robot.arm, np.random.default_rng(0)
    scale = planners.levers(arm)
    for k in range(samples):
        size = 0.08 * (k + 1) / samples  # [m]
        other = np.clip(q + rng.normal(size=arm.n) * size / scale, arm.q_min, arm.q_max)
        if checker.refusal(other, clearance) is None:
            return other
    return None


def free_words(q: Array | None) -> str:
    """What to do about a start that is not free. q (n,): free joint positions near it; None: none were found."""
    if q is None:
        return "move the instrument by hand"
    return f"start from joints:{','.join(f'{x:.4f}' for x in q)}, which is free"


def less(refusal: Nearest) -> str:
    """The clearance that would be possible, if there is one."""
    possible = np.floor(1e4 * refusal.distance) / 10.0  # [mm]
    return f", or give a clearance of {possible:g} mm or less" if possible > 0.0 else ""


def words(refusal: Nearest, clearance: float) -> str:
    """Which pair is how deep in the other, or nearer than the clearance [m]."""
    one, two = refusal.pair
    if refusal.distance < 0.0:
        return f"in collision: {one} is {-1e3 * refusal.distance:.2f} mm deep in {two}"
    return f"nearer than the clearance: {one} is {1e3 * refusal.distance:.2f} mm from {two}, not {1e3 * clearance:g} mm"


def require_number(value: float, name: str, least: float) -> float:
    """The value as a number of at least `least`.

    Raises:
        PlanningError: it is none.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = float("nan")
    if not (np.isfinite(number) and number >= least):
        raise PlanningError(f"the {name} must be a number of {least:g} or more. Got: {value!r:.60}", mend="e.g. 0.003")
    return number
