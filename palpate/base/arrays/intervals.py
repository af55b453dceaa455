"""Confidence intervals of statistics, proportions and families of tests: one place for all studies and pages."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from palpate.base.arrays import Array

LEVEL = 0.95
"""Confidence of an interval."""
LEAST = 5
"""Fewest independent units from which an interval is stated."""
FEW = 20
"""Number of units below which the interval is Student's."""
_DRAWS = 2000


def interval(statistic: Callable[..., float], *samples: Array, axes: tuple[int, ...] = (0,)) -> tuple[float, float]:
    """95 % confidence interval of a statistic of independent units.

    Below `FEW` units it is Student's, with the variance from leaving out one unit at a time (jackknife; Tukey 1958):
    percentiles of a bootstrap of 5 to 8 units hold the truth in 79 to 92 % only. From `FEW` units on it is the
    bootstrap with bias correction and acceleration (BCa; Efron, JASA 82, 1987).

    Args:
        statistic: of the samples.
        samples: arrays whose entries along `axes` belong to the same unit, e.g. an operator before and after.
        axes: axes of independent units; with several (routes and operators) their variances add, and the fewest count.

    Returns:
        (low, high); NaN below `LEAST` units.
    """
    from scipy.special import stdtrit

    n = min(samples[0].shape[axis] for axis in axes)
    value = statistic(*samples)
    if n < LEAST or not np.isfinite(value):
        return float("nan"), float("nan")
    deviation = _deviation(statistic, samples, axes)
    if deviation <= 1e-12 * abs(value):
        return value, value
    if n >= FEW and len(axes) == 1:
        return _bca(statistic, samples)
    reach = float(stdtrit(n - 1, 0.5 + 0.5 * LEVEL)) * deviation
    return value - reach, value + reach


def chance(statistic: Callable[..., float], *samples: Array, axes: tuple[int, ...] = (0,)) -> float:
    """Probability of a statistic at least as far from zero if it is zero: Student's t, of the jackknife's deviation.

    Arguments are those of `interval`; NaN below `LEAST` units.
    """
    from scipy.special import stdtr

    n = min(samples[0].shape[axis] for axis in axes)
    value = statistic(*samples)
    if n < LEAST or not np.isfinite(value):
        return float("nan")
    deviation = _deviation(statistic, samples, axes)
    if deviation <= 1e-12 * abs(value):
        return 1.0 if value == 0.0 else 0.0
    return float(2.0 * stdtr(n - 1, -abs(value) / deviation))


def _deviation(statistic: Callable[..., float], samples: tuple[Array, ...], axes: tuple[int, ...]) -> float:
    return float(np.sqrt(sum(_variance(statistic, samples, axis) for axis in axes)))


def _variance(statistic: Callable[..., float], samples: tuple[Array, ...], axis: int) -> float:
    """Variance of the statistic by leaving out one unit along an axis at a time."""
    n = samples[0].shape[axis]
    left = np.array([statistic(*(np.delete(x, k, axis) for x in samples)) for k in range(n)])
    return float((n - 1) / n * np.square(left - left.mean()).sum())


def _bca(statistic: Callable[..., float], samples: tuple[Array, ...]) -> tuple[float, float]:
    """BCa at a level that makes the interval of normal units Student's (Hesterberg, American Statistician 69, 2015).

    The draws have (n - 1)/n of the variance, and normal percentiles: with 20 units, intervals 9 % narrower.
    """
    from scipy.special import ndtr, stdtrit
    from scipy.stats import bootstrap

    n = len(samples[0])
    level = 1.0 - 2.0 * float(ndtr(-np.sqrt(n / (n - 1)) * stdtrit(n - 1, 0.5 + 0.5 * LEVEL)))
    found = bootstrap(
        (np.arange(n),), lambda rows: statistic(*(x[rows] for x in samples)), n_resamples=_DRAWS,
        vectorized=False, confidence_level=level, method="BCa", rng=np.random.default_rng(0),
    ).confidence_interval  # fmt: skip
    return float(found.low), float(found.high)


def proportion(found: float, n: int, level: float = LEVEL) -> tuple[float, float]:
    """Confidence interval of a proportion from n trials (Clopper and Pearson, Biometrika 26, 1934)."""
    from scipy.special import betaincinv

    k, tail = found * n, 0.5 - 0.5 * level
    low = 0.0 if k <= 0.0 else float(betaincinv(k, n - k + 1.0, tail))
    return low, 1.0 if k >= n else float(betaincinv(k + 1.0, n - k, 1.0 - tail))


def paired(before: Array, after: Array) -> float:
    """Probability of a mean difference at least as large of the same units (n,) if there is none (Student's t)."""
    from scipy.special import stdtr

    change = after - before
    n, mean = len(change), float(change.mean())
    if n < LEAST:
        return float("nan")
    deviation = float(change.std(ddof=1)) / np.sqrt(n)
    if deviation <= 1e-12 * abs(mean):
        return 1.0 if mean == 0.0 else 0.0
    return float(2.0 * stdtr(n - 1, -abs(mean) / deviation))


def holm(p: Array) -> Array:
    """Probabilities (n,) corrected for the family of n tests (Holm, Scandinavian J. Statistics 6, 1979).

    Among results below 0.05 there is a wrong one in at most 5 % of the families. NaN, a test that was not made, stays.
    """
    found = np.full(len(p), np.nan)
    made = np.flatnonzero(np.isfinite(p))
    order = made[np.argsort(p[made], kind="stable")]
    found[order] = np.minimum(1.0, np.maximum.accumulate(p[order] * np.arange(len(order), 0, -1)))
    return found
