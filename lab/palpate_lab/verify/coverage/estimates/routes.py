"""Reduction of an entry over 8 routes and 6 operators, both of which are samples."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.intervals import interval
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "study planning"
FORMS = {
    RIGHT: "8 routes and 6 operators, log-normal, half of the entry",
    "routes alone": "the help depends on the route, not on the operator",
    "operators alone": "the help depends on the operator, not on the route",
    "three": "three routes: no interval is stated",
}


def _reduction(before: Array, after: Array) -> float:
    return float(1.0 - after.sum() / before.sum())


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One study."""
    n, m = (3 if form == "three" else 8), 6
    before = rng.lognormal(0.0, 0.5, (n, 1)) * rng.lognormal(0.0, 0.3, m) * rng.lognormal(0.0, 0.3, (n, m))
    by_route = 0.0 if form == "operators alone" else 0.3
    by_operator = 0.0 if form == "routes alone" else 0.3
    help_of = rng.lognormal(-0.5 * by_route**2, by_route, (n, 1)) * rng.lognormal(-0.5 * by_operator**2, by_operator, m)
    after = 0.5 * before * help_of * rng.lognormal(-0.5 * 0.2**2, 0.2, (n, m))
    low, high = interval(_reduction, before, after, axes=(0, 1))
    if not np.isfinite(low):
        return Trial(float("nan"), float("nan"), told=True)
    return of_intervals(np.array([0.5 * (low + high)]), np.array([0.5]), np.array([0.5 * (high - low)]), told=False)
