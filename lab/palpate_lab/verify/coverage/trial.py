"""One trial of an estimate on data with known truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array

RIGHT = "right"
"""Name of the form that the estimate assumes."""


@dataclass(frozen=True)
class Trial:
    """What an estimate said, against the truth."""

    inside: float  # share of the 95 % intervals, or of the ellipsoid, that hold the truth; NaN if it was refused
    square: float  # squared error over the stated variance, mean of the components; NaN if it was refused
    told: bool  # the data were refused or doubted, or some of them were named as wrong
    possible: float = np.nan  # share of such data that the best possible test would tell; NaN: not bounded


def of_ellipsoid(error: Array, covariance: Array, told: bool) -> Trial:
    """A trial of an ellipsoid with this covariance (k, k) and the error (k,) of its middle."""
    from scipy.special import chdtri

    square, size = float(error @ np.linalg.solve(covariance, error)), len(error)
    return Trial(float(square < chdtri(size, 0.05)), square / size, told)


def of_intervals(value: Array, true: Array, half_width: Array, told: bool) -> Trial:
    """A trial of 95 % intervals (k,) about their middles."""
    error = np.abs(value - true)
    return Trial(float(np.mean(error < half_width)), float(np.mean(np.square(1.96 * error / half_width))), told)
