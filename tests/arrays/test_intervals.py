"""Intervals: coverage on generators of known truth, and closed forms."""

import numpy as np
import pytest
from scipy.special import ndtri
from scipy.stats import binomtest, t, ttest_1samp, ttest_rel

from palpate.base.arrays.intervals import LEAST, chance, holm, interval, paired, proportion


def change(before, after):
    return float(after.mean() / before.mean() - 1.0)


@pytest.mark.parametrize(("n", "trials"), [(5, 500), (8, 500), (19, 400), (24, 120)])
def test_intervals_of_few_operators_hold_the_truth(n, trials):
    """A ratio of means of skewed pairs; percentiles of a bootstrap hold it in 80 to 90 % of the trials with 5 and 8."""
    rng, held, plain = np.random.default_rng(n), 0, 0
    for _ in range(trials):
        person = rng.lognormal(0.0, 0.4, n)
        before = person * rng.lognormal(0.0, 0.25, n)
        after = 0.7 * person * rng.lognormal(0.0, 0.25, n)
        low, high = interval(change, before, after)
        held += low < -0.3 < high
        draws = rng.integers(n, size=(400, n))
        low, high = np.percentile(after[draws].mean(axis=1) / before[draws].mean(axis=1) - 1.0, [2.5, 97.5])
        plain += low < -0.3 < high
    assert proportion(held / trials, trials)[1] >= 0.93
    assert held / trials < 0.995
    if n < 10:
        assert proportion(plain / trials, trials)[1] < 0.93


def test_interval_of_a_mean_is_students_and_needs_five_units():
    x = np.random.default_rng(0).normal(size=9)
    known = t.interval(0.95, 8, loc=x.mean(), scale=x.std(ddof=1) / 3.0)
    assert interval(np.mean, x) == pytest.approx(known)
    assert np.isnan(interval(np.mean, x[: LEAST - 1])).all()
    assert interval(np.mean, np.full(7, 0.4)) == pytest.approx((0.4, 0.4))


def test_interval_of_twenty_normal_units_is_as_wide_as_students():
    """Normal percentiles of the bootstrap's draws are narrower by 8 to 11 %, and hold the truth in 92.5 %."""
    n = 20
    x = ndtri((np.arange(n) + 0.5) / n)
    low, high = interval(lambda v: float(v.mean()), x)
    reach = t.ppf(0.975, n - 1) * x.std(ddof=1) / np.sqrt(n)
    assert 0.95 < 0.5 * (high - low) / reach < 1.05


def test_routes_and_operators_are_both_drawn():
    """A mean over 7 routes and 9 operators whose effects are both random."""
    rng, held = np.random.default_rng(3), 0
    for _ in range(300):
        x = 1.0 + rng.normal(size=(7, 1)) + 0.7 * rng.normal(size=9) + 0.5 * rng.normal(size=(7, 9))
        low, high = interval(np.mean, x, axes=(0, 1))
        held += low < 1.0 < high
    assert 0.93 <= held / 300 <= 0.995


def test_interval_of_a_proportion_is_that_of_scipy():
    for k, n in [(0, 5), (5, 5), (190, 200), (3, 80)]:
        known = binomtest(k, n).proportion_ci(method="exact")
        assert proportion(k / n, n) == pytest.approx((known.low, known.high), abs=1e-12)


def test_paired_probability_is_that_of_scipy():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 12))
    assert paired(a, b) == pytest.approx(ttest_rel(a, b).pvalue)
    assert paired(a, a) == 1.0
    assert np.isnan(paired(a[:4], b[:4]))


def test_family_without_effects_names_one_in_five_of_a_hundred():
    """120 tests without an effect: without correction, 6 are named in each family."""
    rng = np.random.default_rng(2)
    families = [rng.random(120) for _ in range(400)]
    wrong = np.mean([(holm(p) < 0.05).any() for p in families])
    assert proportion(float(wrong), 400)[0] <= 0.05
    assert np.mean([(p < 0.05).sum() for p in families]) > 5.0
    assert holm(np.array([0.01, 0.04, 0.03, np.nan])) == pytest.approx([0.03, 0.06, 0.06, np.nan], nan_ok=True)


def test_chance_of_a_mean_is_students_and_agrees_with_its_interval():
    rng = np.random.default_rng(4)
    x = rng.normal(0.5, 1.0, 11)
    assert chance(np.mean, x) == pytest.approx(ttest_1samp(x, 0.0).pvalue)
    assert np.isnan(chance(np.mean, x[: LEAST - 1]))
    grid = 1.0 + rng.normal(size=(7, 1)) + 0.7 * rng.normal(size=9) + 0.5 * rng.normal(size=(7, 9))
    low, high = interval(np.mean, grid, axes=(0, 1))
    assert (chance(np.mean, grid, axes=(0, 1)) < 0.05) == (low > 0.0 or high < 0.0)
    assert chance(np.mean, grid - low, axes=(0, 1)) == pytest.approx(0.05), "the lower end at zero"
