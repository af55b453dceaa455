"""Upper bound of what any test could tell: the power of the most powerful one (Neyman and Pearson 1933)."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.world.registration.organ_motion import directions

_DRAWS = 10_000


def most_powerful(M: Array, size: float, level: float) -> float:
    """Share of displacements of a known size, in a random direction, that the most powerful test tells.

    Its statistic is the likelihood ratio, averaged over the directions; no test with this level tells a larger share.

    Args:
        M: inverse covariance (3, 3) of the displacement [1/m^2].
        size: length of the displacement [m].
        level: probability of a false alarm.
    """
    value, axes = np.linalg.eigh(M)
    d = size * directions() @ (axes * np.sqrt(np.maximum(value, 0.0)))  # in units of its standard deviation
    z = np.random.default_rng(0).normal(size=(_DRAWS, 3))

    def log_ratio(z: Array) -> Array:
        return np.asarray(np.logaddexp.reduce(z @ d.T - 0.5 * np.square(d).sum(axis=1), axis=1))

    limit = np.quantile(log_ratio(z), 1.0 - level)
    return float(np.mean(log_ratio(z + d[np.arange(_DRAWS) % len(d)]) > limit))
