"""The mixed model against a closed form, its error rate, and the power against the noncentral t distribution."""

import numpy as np
import pytest
from scipy import stats

from palpate.experiment.analysis import DRAWS, effects, means, mixed, power

pytest.importorskip("statsmodels", reason="statsmodels is not installed (extra experiment)")
NAMES = ("none", "bar", "force")


def rows_of(rng, people=12, effect=0.0, tasks=("a",), spread=1.0, scale=1.0, differ=0.0):
    """Trials of people with a random level, two repetitions, and an effect of the third condition.

    differ: standard deviation of the effect of each condition between people.
    """
    rows = []
    for who in range(people):
        level, own = rng.normal(0.0, 2.0), differ * rng.normal(size=3)
        for task in tasks:
            for k, condition in enumerate(NAMES):
                for _ in range(2):
                    y = scale * (5.0 + level + own[k] + effect * (k == 2) + rng.normal(0.0, spread))
                    rows.append({"participant": f"P{who}", "task": task, "condition": condition, "y": y})
    return rows


def anova_p(table, k):
    """Closed form of a balanced design: the contrast with the mean square of people by conditions."""
    n, c = table.shape
    rest = table - table.mean(axis=1, keepdims=True) - table.mean(axis=0) + table.mean()
    freedom = (n - 1) * (c - 1)
    error = np.sqrt(2.0 * np.square(rest).sum() / freedom / n)
    return 2.0 * stats.t.sf(abs(table[:, k].mean() - table[:, 0].mean()) / error, freedom)


@pytest.mark.parametrize("scale", [1.0, 1e-4])
def test_the_model_of_a_balanced_design_is_the_analysis_of_variance(scale):
    for seed in range(4):
        rows = rows_of(np.random.default_rng(seed), effect=0.8, scale=scale)
        _, table = means(rows, "y", NAMES)
        found = mixed(rows, "y", NAMES)
        for k, name in enumerate(NAMES[1:], 1):
            assert found[name][0] == pytest.approx(table[:, k].mean() - table[:, 0].mean(), rel=1e-6)
            assert found[name][1] == pytest.approx(anova_p(table, k), rel=0.02)


@pytest.mark.long
def test_without_an_effect_one_test_in_twenty_finds_one():
    p = [mixed(rows_of(np.random.default_rng([9, k])), "y", NAMES)["force"][1] for k in range(400)]
    low, high = stats.binom.ppf([0.001, 0.999], 400, 0.05)
    assert low <= np.sum(np.array(p) < 0.05) <= high


def test_tasks_of_one_participant_are_not_further_participants():
    """Effects differ between six people; with each task as a unit of its own, 15 to 20 % of such tests find one."""
    p = [
        mixed(rows_of(np.random.default_rng([5, k]), 6, tasks=("a", "b", "c", "d"), differ=0.7), "y", NAMES)
        for k in range(150)
    ]
    found = np.array([value for one in p for _, value in one.values()]) < 0.05
    assert found.mean() < 0.1


def test_four_participants_have_no_probability():
    assert mixed(rows_of(np.random.default_rng(1), 4, effect=5.0), "y", NAMES) == {}
    assert mixed(rows_of(np.random.default_rng(1), 5, effect=5.0), "y", NAMES)["force"][1] < 0.05


def test_effects_name_their_units_and_are_corrected_together():
    rows = rows_of(np.random.default_rng(1), effect=2.0, tasks=("a", "b"))
    found = effects(rows, ("y",), NAMES)
    assert [one.condition for one in found] == ["bar", "force"]
    assert found[1].difference == pytest.approx(2.0, abs=0.7)
    assert found[1].low < found[1].difference < found[1].high
    assert found[1].dz_low < found[1].dz < found[1].dz_high
    assert found[1].p < 1e-4
    assert found[1].p_holm == pytest.approx(2.0 * found[1].p)
    assert found[0].p_holm >= found[0].p


def test_missing_values_and_a_missing_condition_leave_the_rest():
    rows = rows_of(np.random.default_rng(2), people=6, effect=2.0)
    for row in rows:
        if row["condition"] == "bar" or row["participant"] == "P0":
            row["y"] = None
    bar, force = effects(rows, ("y",), NAMES)
    assert (bar.participants, force.participants) == (0, 5)
    assert np.isnan([bar.difference, bar.p, bar.p_holm]).all()
    assert force.p < 0.05


def trials_of(people, values):
    """Trials whose value does not depend on the participant: values by task and condition."""
    return [
        {"participant": f"P{who}", "task": task, "condition": condition, "y": y}
        for who in range(people)
        for (task, condition), y in values.items()
    ]


@pytest.mark.parametrize("people", [2, 3, 4, 8])
def test_without_any_spread_a_difference_has_no_probability(people):
    for names in (NAMES, ("none", "force")):
        rows = trials_of(people, {("a", name): float(k) for k, name in enumerate(names)})
        force = effects(rows, ("y",), names)[-1]
        assert force.difference == len(names) - 1
        assert np.isnan([force.dz, force.p]).all()


def test_conditions_that_were_met_in_different_tasks_are_not_modelled():
    rows = trials_of(4, {("a", "none"): 0.0, ("b", "force"): 1.0})
    for k, row in enumerate(rows):
        row["y"] += 0.1 * np.sin(k)
    (force,) = effects(rows, ("y",), ("none", "force"))
    assert np.isnan(force.p)


def test_power_is_that_of_the_noncentral_t_distribution():
    """A pool of many people whose differences have the mean 0.8 and the deviation 1: one comparison, no correction."""
    rng = np.random.default_rng(3)
    change = rng.normal(size=4000)
    change = 0.8 + (change - change.mean()) / change.std()
    rows = []
    for who, difference in enumerate(change):
        for condition, y in (("none", 0.0), ("force", difference)):
            rows.append({"participant": str(who), "task": "a", "condition": condition, "y": y})
    for one in power(rows, "y", ("none", "force")):
        n = one.participants
        critical, shift = stats.t.ppf(0.975, n - 1), 0.8 * np.sqrt(n)
        truth = stats.nct.sf(critical, n - 1, shift) + stats.nct.cdf(-critical, n - 1, shift)
        assert one.power == pytest.approx(truth, abs=4.0 * np.sqrt(0.25 / DRAWS))
        assert one.low <= one.power <= one.high
