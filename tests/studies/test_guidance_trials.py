"""Trials of `palpate study guidance` without a simulation: what a condition changes, tasks, and confidence bounds."""

from types import SimpleNamespace

import numpy as np
import pytest

from palpate.base.arrays.polyline import evenly
from palpate.simulators.operators import person
from palpate_lab.studies.guidance import cues, effects
from palpate_lab.studies.guidance import work as guidance
from palpate_lab.studies.guidance.tasks import OFFSET_AXIS, RADIUS, TASKS, _waypoints


@pytest.fixture
def begun(monkeypatch):
    """Start a trial without running it; returns the rig's arguments, the simulation, the operator and the errand."""

    def begin(operator, task, condition, **more):
        seen = []
        genuine = guidance._rig

        def rig(name, kind, offset_mm, stiffness):
            seen.append((name, kind, offset_mm))
            return genuine(name, kind, abs(offset_mm), stiffness)

        monkeypatch.setattr(guidance, "_rig", rig)
        monkeypatch.setattr(guidance, "perform", lambda *given: given)
        simulation, who, errand, _, scale, most = guidance.attempt(operator, task, condition, 5, **more)
        monkeypatch.undo()
        assert (scale, most) == (0.5, 15.0)
        return seen[0], simulation, who, errand

    return begin


@pytest.mark.parametrize("condition", guidance.ALL)
def test_a_condition_changes_forces_guidance_and_senses_alone(begun, condition):
    c = guidance.ALL[condition]
    (task, kind, offset), simulation, operator, errand = begun(4, "tracing", condition)
    assert (task, kind, offset) == ("tracing", c.guidance, c.offset_mm)
    controls = simulation.controls
    assert (controls.stiffness_scale, controls.damping_scale) == (float(c.forces), float(c.forces))
    who = person(4, guidance.SEED)
    assert operator.person.haste == (who.haste if c.haste else 1.0)
    assert operator.person.yields == who.yields
    assert operator.person.hand == who.hand
    assert errand is guidance.task_of("tracing").errand


def test_registration_errors_alternate_over_the_operators(begun):
    assert [begun(k, "ring", "control_wrong")[0][2] for k in (0, 1, 2)] == [5.0, -5.0, 5.0]
    assert {name: guidance.ALL[name].offset_mm for name in guidance.REGISTRATION} == {
        "registration_1mm": 1.0, "registration_2mm": 2.0, "registration_3mm": 3.0}  # fmt: skip


def test_the_trait_of_yielding_is_scaled_alone(begun):
    who, operator = person(2, guidance.SEED), begun(2, "ring", "guidance", assumed=guidance.Assumed(yields=0.5))[2]
    assert operator.person.yields == pytest.approx(0.5 * who.yields)
    assert (operator.person.haste, operator.person.care) == (who.haste, 1.0)


def test_care_and_stiffness_of_fixtures_are_assumptions_that_vary(begun):
    careless = begun(2, "ring", "guidance", assumed=guidance.Assumed(care=0.0))[2]
    assert (careless.person.care, careless.person.yields) == (0.0, person(2, guidance.SEED).yields)
    pull = {}
    for K in (None, 300.0, 1200.0):
        (path,) = guidance._rig("insertion", "soft", 5.0, K).fixtures.list()
        X = np.eye(4)
        X[:3, 3] = guidance.task_of("insertion").errand.path[40]
        pull[K] = np.linalg.norm(path.evaluate(X, 0.0, np.zeros(6))["F"][:3])
    assert pull[1200.0] == pytest.approx(4.0 * pull[300.0])
    assert pull[None] == pytest.approx(2.0 * pull[300.0])


@pytest.mark.parametrize(("task", "press"), [("ring", 0.0), ("tracing", 0.5), ("palpation", 1.0), ("insertion", 0.0)])
def test_paths_press_with_the_stated_force_and_start_a_millimetre_above(task, press):
    """The path lies below the surface z = 0 by the depth at which a spring makes the force."""
    made = guidance.task_of(task)
    assert made.errand.press == press
    if press:
        depth = RADIUS - made.errand.path[:, 2]
        np.testing.assert_allclose(made.errand.stiffness * depth, press)
        np.testing.assert_allclose(made.start, made.errand.path[0] + [0.0, 0.0, 0.001])
    else:
        np.testing.assert_allclose(made.start, made.errand.path[0])
    np.testing.assert_allclose(made.off(made.errand.path), 0.0, atol=1e-12)
    assert (made.outside(made.errand.path) < 0.0).all()
    steps = np.linalg.norm(np.diff(made.errand.path, axis=0), axis=1)
    assert 0.4e-3 < np.median(steps) <= 0.51e-3
    assert made.scene()["operator"]["path"][0]["xyz"] == made.start.tolist()


@pytest.mark.parametrize("task", ["ring", "insertion"])
def test_the_wall_of_a_passage_surrounds_it_and_both_its_ends(task):
    """The wall is a clearance and the tool's radius away from the path; the operator is told the same width."""
    made = guidance.task_of(task)
    wall, path = made.surface(), made.errand.path
    clear = -made.outside(path)
    np.testing.assert_allclose(made.errand.width, 2.0 * clear, rtol=1e-9)
    np.testing.assert_allclose(wall.nearest(path)[0], clear + RADIUS, rtol=0.06)
    for k, before in ((0, 1), (-1, -2)):
        out = (path[k] - path[before]) / np.linalg.norm(path[k] - path[before])
        near, far = wall.nearest(np.array([path[k] + 0.002 * out, path[k] + 0.03 * out]))[0]
        assert near == pytest.approx(clear[k] + RADIUS, abs=1e-3), "it goes on beyond the end"
        assert far > 0.018, "but not far"


def test_evenly_spaced_points_keep_the_ends_and_the_length_of_a_curve():
    u = np.linspace(0.0, np.pi, 2000) ** 2 / np.pi  # unevenly spaced
    arc = np.column_stack([0.02 * np.cos(u), 0.02 * np.sin(u), 0.0 * u])
    points = evenly(arc, 0.001)
    np.testing.assert_allclose(points[[0, -1]], arc[[0, -1]], atol=1e-12)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    np.testing.assert_allclose(steps, 0.02 * np.pi / 62, rtol=1e-3)
    kept = np.array(_waypoints(points, np.array([0.0, 0.005, 0.0])))
    np.testing.assert_allclose(kept[[0, -1]], points[[0, -1]] + [0.0, 0.005, 0.0], atol=1e-12)
    np.testing.assert_allclose(kept[3], points[30] + [0.0, 0.005, 0.0])
    np.testing.assert_allclose(OFFSET_AXIS, [0.0, 1.0, 0.0])


def test_sizes_of_effects_on_people_are_those_of_the_page():
    """The judge of palpation is the number of entries: nothing guides along its path."""
    rows = trials(lambda condition, k: 1.0 + 0.1 * k)
    found = {(e["task"], e["condition"], e["measure"]): e for e in effects.summary(rows, 3)["effects"]}
    for task, g in (("ring", -1.28), ("tracing", -1.28), ("insertion", -1.28), ("palpation", None)):
        one = found[task, "haptics+guidance", "path_error_mm"]
        assert one["expected_hedges_g"] == g
        assert one["expected_change"] == (None if g is None else [-0.7, -0.2])
        assert (one["source"] is None) == (g is None)
    for key, g in (("peak_force_N", -0.69), ("mean_force_N", -0.83), ("time_s", -0.83)):
        assert found["palpation", "haptics", key]["expected_hedges_g"] == g
        assert found["ring", "visual", key]["expected_hedges_g"] is None


def trials(path_error, n=6, tasks=TASKS, **more):
    """Trials of all conditions with this path error; the first operator did not finish."""
    same = dict.fromkeys((*guidance.MEASURES, "deepest_mm", "hand_peak_force_N", "peak_50ms_N"), 2.0) | more
    return [{"task": task, "condition": condition, "operator": k, **same, "path_error_mm": path_error(condition, k),
             "done": float(k > 0)} for task in tasks for condition in guidance.ALL for k in range(n)]  # fmt: skip


def test_means_are_those_of_all_operators_and_unfinished_trials_are_counted():
    row = effects.summary(trials(lambda condition, k: 1.0 + k), 3)["rows"][0]
    assert (row["path_error_mm"], row["time_s"], row["unfinished"]) == (3.5, 2.0, 1)


def test_bounds_of_a_relative_change_lie_around_it():
    """Reference: the ratio of two means of normal trials, to first order."""
    rng, n = np.random.default_rng(4), 400
    before, after = 10.0 + rng.normal(size=n), 8.0 + rng.normal(size=n)
    change, low, high = effects.relative_change(before, after)
    error = 1.96 * np.std(after / after.mean() - before / before.mean()) * 0.8 / np.sqrt(n)
    assert change == pytest.approx(after.mean() / before.mean() - 1.0)
    assert (change - low, high - change) == (pytest.approx(error, rel=0.1), pytest.approx(error, rel=0.1))


def test_bounds_of_a_bootstrap_are_two_standard_errors_wide():
    """Reference: normal trials, for which the bounds of a mean, a ratio of means and Hedges' g are known."""
    rng, n = np.random.default_rng(6), 400
    none, mine = 10.0 + rng.normal(size=n), 9.0 + rng.normal(size=n)
    found = effects._effect("ring", "guidance", "path_error_mm", none, mine)
    error = 1.96 * np.std(mine / mine.mean() - none / none.mean()) * 0.9 / np.sqrt(n)
    assert found["change"] == pytest.approx(mine.mean() / none.mean() - 1.0)
    assert found["change_high"] - found["change"] == pytest.approx(error, rel=0.08)
    assert found["change"] - found["change_low"] == pytest.approx(error, rel=0.08)
    g = found["hedges_g"]
    error = 1.96 * np.sqrt(2.0 / n + g**2 / (4.0 * n))
    assert [found["hedges_g_high"] - g, g - found["hedges_g_low"]] == pytest.approx([error, error], rel=0.12)
    rows = trials(lambda condition, k: float(mine[k] if condition == "control_wrong" else none[k]), n, ("ring",))
    against = effects._against(rows, "ring")
    error = 1.96 * np.std(mine - none) / np.sqrt(n)
    for name in ("right", "none"):
        mean, low, high = (against[f"than_{name}{end}_mm"] for end in ("", "_low", "_high"))
        assert mean == pytest.approx(mine.mean() - none.mean())
        assert [mean - low, high - mean] == pytest.approx([error, error], rel=0.08)


def test_registration_errors_are_judged_by_the_first_operators(monkeypatch):
    """A row without guidance, then one per error; only the first FEW operators repeat the tasks."""
    monkeypatch.setattr(effects, "FEW", 3)
    rows = trials(lambda condition, k: 100.0 if k >= 3 else guidance.ALL[condition].offset_mm + k, peak_force_N=4.0)
    found = effects._registered(rows, "ring")
    assert [row["error_mm"] for row in found] == [None, 0.0, 1.0, 2.0, 3.0, 5.0]
    assert [row["path_error_mm"] for row in found] == [1.0, 1.0, 2.0, 3.0, 4.0, 6.0]
    assert {(row["peak_force_N"], row["entries"]) for row in found} == {(4.0, 2.0)}
    assert effects._break_even(rows, "ring")["largest_tried_mm"] == 5.0


def test_tasks_without_pressing_have_no_ablation_of_haste():
    rows = [row for row in trials(lambda *_: 1.0) if (row["condition"], row["task"]) != ("none_no_haste", "ring")]
    assert effects._ablated(rows, "ring") == []
    assert [row["measure"] for row in effects._ablated(rows, "tracing")] == ["mean_force_N", "peak_force_N"]
    conditions = ("none_no_haste", "registration_1mm", "none")
    tried = [(t, o, c) for t in ("ring", "tracing") for o in (49, 50) for c in conditions
             if guidance._included({"task": t, "operator": o, "condition": c})]  # fmt: skip
    assert tried == [("ring", 49, "registration_1mm"), ("ring", 49, "none"), ("ring", 50, "none"),
                     ("tracing", 49, "none_no_haste"), ("tracing", 49, "registration_1mm"), ("tracing", 49, "none"),
                     ("tracing", 50, "none_no_haste"), ("tracing", 50, "none")]  # fmt: skip


def test_visual_cues_are_compared_on_the_same_operators_with_the_same_noise(monkeypatch):
    tried = []
    monkeypatch.setattr(cues, "attempt", lambda *given: tried.append(given) or given[2])
    monkeypatch.setattr(cues, "judged", lambda task, trial: dict.fromkeys(cues.MEASURES, float(len(trial))))
    found = cues.each({"operator": 3, "task": "ring", "cohort": 7}, 11)
    assert tried == [(3, "ring", c, 11, 7) for c in ("none", "visual", "haptics", "visual+haptics")]
    assert (found["path_error_mm none"], found["time_s visual+haptics"]) == (4.0, 14.0)


def test_differences_of_visual_cues_have_the_bounds_of_their_mean():
    """Reference: normal differences of 50 operators, the most that are tried."""
    rng = np.random.default_rng(2)
    difference, grids = rng.normal(-1.0, 0.5, 50), []

    def sweep(each, grid, seed, title):
        grids.append(grid)
        rows = [{"task": task, **{f"{key} {c}": 5.0 + (difference[k] if c == "visual" else 0.0)
                                  for key in cues.MEASURES for c in cues.CONDITIONS}}
                for task in TASKS for k in range(50)]  # fmt: skip
        return SimpleNamespace(rows=lambda: rows)

    found = cues.cued(200, 3, sweep)
    assert list(grids[0]["operator"].values) == list(range(50))
    assert [(row["task"], row["condition"]) for row in found] == [(t, c) for t in TASKS for c in cues.CONDITIONS]
    visual = found[1]
    error = 1.96 * np.std(difference) / np.sqrt(50)
    assert visual["time_s"] == pytest.approx(5.0 + difference.mean())
    for end, sign in (("low", -1.0), ("high", 1.0)):
        assert visual[f"time_s_more_{end}"] - difference.mean() == pytest.approx(sign * error, rel=0.08)
