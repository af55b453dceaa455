"""Relative change of a mean over 12 simulated operators with and without help."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.intervals import interval
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "study guidance"
FORMS = {
    RIGHT: "12 operators of log-normal skill and noise, 30 % less with help",
    "small": "four operators: no interval is stated",
    "clumsy": "one of twelve is five times as bad, with and without help",
    "unpaired": "the rows with help are those of other operators",
}


def _change(before: Array, after: Array) -> float:
    return float(after.mean() / before.mean() - 1.0)


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One study."""
    n = 4 if form == "small" else 12
    skill = rng.lognormal(0.0, 0.4, n)
    if form == "clumsy":
        skill[0] *= 5.0
    other = rng.permutation(skill) if form == "unpaired" else skill
    before, after = skill * rng.lognormal(0.0, 0.2, n), 0.7 * other * rng.lognormal(0.0, 0.2, n)
    low, high = interval(_change, before, after)
    if not np.isfinite(low):
        return Trial(float("nan"), float("nan"), told=True)
    return of_intervals(np.array([0.5 * (low + high)]), np.array([-0.3]), np.array([0.5 * (high - low)]), told=False)
