"""`palpate study guidance`: its measures, its statistics, and a small cohort from end to end."""

import re
from dataclasses import replace
from pathlib import Path

import json_contract
import numpy as np
import pytest

from palpate import _core
from palpate.base.arrays.polyline import distance
from palpate.base.sweep import sweep
from palpate.record.ticks import as_ticks
from palpate.simulators.operators import Trial
from palpate_lab.studies.guidance import effects as guidance_effects
from palpate_lab.studies.guidance import work as guidance
from palpate_lab.studies.guidance.assumptions import assumptions
from palpate_lab.studies.guidance.assumptions import tables as assumption_tables
from palpate_lab.studies.guidance.conformance import entered, entry_words
from palpate_lab.studies.guidance.cues import cued
from palpate_lab.studies.guidance.tasks import SCALE, TASKS, sleeve
from palpate_lab.studies.guidance.words import tables
from palpate_lab.studies.guidance.yields import yielding
from palpate_lab.verify.conformance import entry


def test_distance_to_a_polyline():
    path = np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 1, 0]])
    d, q = distance(np.array([[0.5, 0.2, 0], [2.0, 2, 0], [-1.0, 0, 1.0]]), path)
    np.testing.assert_allclose(d, [0.2, np.sqrt(2), np.sqrt(2)])
    np.testing.assert_allclose(q, [[0.5, 0, 0], [1, 1, 0], [0, 0, 0]])


def test_sleeve_is_closed_and_has_its_inner_radius():
    u = np.linspace(0.0, 1.0, 40)
    path = np.column_stack([0.04 * u, 0.004 * np.sin(5 * u), 0.01 * u])
    core = sleeve(path, np.linspace(0.004, 0.006, 40), 0.003)
    d = core.nearest(path[5:-5])[0]  # above zero: the wall is the solid part
    np.testing.assert_allclose(d, np.linspace(0.004, 0.006, 40)[5:-5], rtol=0.03)
    assert core.triangle_count == 4 * 24 * 40


def test_traced_curve_is_pressed_with_half_a_newton_on_both_sides_of_the_middle():
    errand, radius = TASKS["tracing"]().errand, 0.002
    path = errand.path
    assert path[0, :2] == pytest.approx([-0.02, 0.0], abs=1e-9)
    assert path[-1, :2] == pytest.approx([0.02, 0.0], abs=1e-9)
    assert errand.stiffness * (radius - path[:, 2]) == pytest.approx(np.full(len(path), 0.5))


def test_hedges_g():
    """Hedges' g against its definition, with the correction for small samples."""
    rng = np.random.default_rng(0)
    a, b = rng.normal(2.0, 1.0, 10), rng.normal(1.0, 1.0, 10)
    spread = np.sqrt((a.var(ddof=1) + b.var(ddof=1)) / 2)
    assert guidance_effects.hedges_g(a, b) == pytest.approx((b.mean() - a.mean()) / spread * (1 - 3 / 71))
    assert guidance_effects.hedges_g(a, a) == 0.0


def test_every_entry_is_counted_once():
    """A short exit within the hysteresis continues an entry; a full exit and return is a second entry."""
    deep = 1e-3 * np.array([-1.0, 1.0, 0.5, 0.3, -0.01, 0.5, -1.5, 0.4, -2.0])
    task = replace(guidance.task_of("ring"), outside=lambda p: p[:, 0], off=lambda p: np.full(len(p), 3e-3))
    result = guidance.judged(
        task, Trial(np.arange(9.0), deep[:, None] * np.eye(3)[0], np.arange(9.0), 2.0 * np.arange(9.0), True)
    )
    assert result["entries"] == 2
    assert result["deepest_mm"] == pytest.approx(1.0)
    assert result["path_error_mm"] == pytest.approx(3.0)
    assert (result["mean_force_N"], result["peak_force_N"], result["hand_peak_force_N"]) == (4.0, 8.0, 16.0)
    assert (result["time_s"], result["done"]) == (8.0, 1.0)


def made_up(wrong=1.0):
    """Trials of five operators: guidance halves the path error, and displaced guidance adds about `wrong` [mm]."""
    force = {"none": 4.0, "none_no_haste": 2.0}
    error = {"guidance": 0.5, "haptics+guidance": 0.5}
    measures = dict.fromkeys((*guidance.MEASURES, "deepest_mm", "hand_peak_force_N", "peak_50ms_N", "done"), 1.0)
    rows = []
    for task in TASKS:
        for condition in guidance.ALL:
            for k in range(5):
                path = (2.0 + k) * error.get(condition, 1.0)
                path = 0.5 * (2.0 + k) + wrong + 0.2 * (k - 2) if condition == "control_wrong" else path
                more = {"path_error_mm": path, "entries": 0.0, "mean_force_N": force.get(condition, 1.0)}
                rows.append({"task": task, "condition": condition, "operator": k, **measures, **more})
    return rows


def test_effects_changes_and_controls_of_made_up_trials():
    report = guidance_effects.summary(made_up(), 3)
    assert (report["operators"], report["control_works"]) == (5, True)
    effects = {(e["task"], e["condition"], e["measure"]): e for e in report["effects"]}
    half = effects["ring", "guidance", "path_error_mm"]
    assert [half[f"change{end}"] for end in ("", "_low", "_high")] == pytest.approx([-0.5] * 3)
    none, mine = np.arange(2.0, 7.0), 0.5 * np.arange(2.0, 7.0)
    assert half["hedges_g"] == pytest.approx(guidance_effects.hedges_g(none, mine))
    assert half["hedges_g_low"] < half["hedges_g"] < half["hedges_g_high"]
    assert effects["ring", "guidance", "time_s"]["change"] == effects["ring", "guidance", "time_s"]["hedges_g"] == 0.0
    assert effects["ring", "guidance", "entries"]["change"] is None, "no entries to begin with"
    forces = [row for row in report["ablation"] if row["measure"] == "mean_force_N"]
    assert {(row["change"], row["change_without_haste"]) for row in forces} == {(-0.75, -0.5)}
    for one in report["control"]:
        assert one["than_right_mm"] == pytest.approx(1.0)
        assert 0.6 <= one["than_right_low_mm"] < 1.0 < one["than_right_high_mm"] <= 1.4
        assert one["than_none_mm"] == pytest.approx(1.0 - 2.0)


def test_a_control_that_may_be_chance_does_not_work():
    report = guidance_effects.summary(made_up(0.05), 3)
    assert all(one["than_right_mm"] > 0.0 > one["than_right_low_mm"] for one in report["control"])
    assert not report["control_works"]


PAGE = (Path(__file__).resolve().parents[2] / "docs/guidance-study.md").read_text(encoding="utf-8")


def stated(before, after):
    """Numbers of the page between two texts."""
    found = re.search(rf"{before} ([\d., and]+?) {after}", " ".join(PAGE.split()))
    assert found, f"docs/guidance-study.md says: {before} ... {after}"
    return [float(x) for x in re.findall(r"\d+(?:\.\d+)?", found[1])]


def fixture_of(name, condition="haptics+guidance"):
    c = guidance.ALL[condition]
    (only,) = guidance._rig(name, c.guidance, c.offset_mm).fixtures.list()
    return only


def inwards(name, share=0.5):
    """Positions (n, 3) from 8 mm off the path of a task to the path, in steps of 5 um, at a share of its length."""
    path = guidance.task_of(name).errand.path
    k = round(share * (len(path) - 2))
    across = np.cross(path[k + 1] - path[k], [0.0, 0.0, 1.0])
    return path[k] + np.linspace(0.008, 0.0, 1601)[:, None] * across / np.linalg.norm(across)


@pytest.mark.parametrize(
    ("task", "share", "words"),
    [
        ("ring", 0.5, ("forbidden beyond", "mm from the wire")),
        ("tracing", 0.5, ("wire, beyond", "mm from the traced line")),
        ("insertion", 0.0, ("narrows from", "to")),
        ("insertion", 1.0, ("narrows from 7 to", "mm")),
    ],
)
def test_forbidden_regions_of_paths_begin_at_the_stated_distance(task, share, words):
    outside = guidance.task_of(task).outside(inwards(task, share))
    assert np.count_nonzero(outside <= 0.0) * 5e-3 == pytest.approx(stated(*words)[0], abs=0.1)


def test_palpation_is_forbidden_nearer_to_the_vessel_than_the_stated_margin():
    """The judge, the soft and the hard fixture agree on the boundary; the wall of the vessel is 2 mm from its axis."""
    (margin,) = stated("nearer than", "mm to the wall of the vessel")
    x = np.linspace(0.0, 0.010, 2001)
    p = np.column_stack([-x, 0.004 * np.ones_like(x), np.zeros_like(x)])
    outside = guidance.task_of("palpation").outside(p)
    np.testing.assert_allclose(outside, 0.002 + 1e-3 * margin - x, atol=1e-12)
    for condition in ("haptics+guidance", "haptics+hard"):
        vessel = fixture_of("palpation", condition)
        assert vessel.policy.hard == (condition == "haptics+hard")
        for one, depth in zip(p[::100], outside[::100], strict=True):
            X = np.eye(4)
            X[:3, 3] = one
            assert vessel.evaluate(X, 0.0, np.zeros(6))["gap"] == pytest.approx(-depth, abs=1e-9), one


@pytest.mark.parametrize("task", ["ring", "tracing", "insertion"])
def test_guidance_of_paths_is_a_spring_of_the_stated_stiffness_and_a_tube_of_the_stated_radius(task):
    (K,), (tube,) = stated("the fixtures of paths have", "N/m"), stated("in a tube of", "mm")
    soft, hard = fixture_of(task), fixture_of(task, "haptics+hard")
    assert (soft.policy.hard, hard.policy.hard) == (False, True)
    near, far, on = np.tile(np.eye(4), (3, 1, 1))
    near[:3, 3], far[:3, 3], on[:3, 3] = inwards(task)[[-201, -401, -1]]  # 1 mm, 2 mm and 0 mm from the path
    forces = [np.linalg.norm(soft.evaluate(X, 0.0, np.zeros(6))["F"][:3]) for X in (near, far)]
    assert forces[1] - forces[0] == pytest.approx(1e-3 * K, rel=0.02)
    between = hard.evaluate(on, 0.0, np.zeros(6))["gap"]
    assert between == pytest.approx(1e-3 * tube, abs=2e-4)  # the tube's waypoints are 5 mm apart


@pytest.mark.parametrize(("task", "place"), [(name, i) for i, name in enumerate(TASKS)])
def test_touched_objects_have_the_stated_stiffness(task, place):
    """The contact force of the chain over the depth; the judge of forces uses the same stiffness."""
    K = stated("The touched objects have", "N/m")[place]
    made, rig = guidance.task_of(task), guidance._rig(task, "", 0.0)
    o, arms = rig.options(1), rig.arms
    start = np.array(made.start)
    into = inwards(task)[0] - inwards(task)[-1] if made.errand.press == 0.0 else np.array([0.0, 0.0, -0.001])
    end = start + (into if made.errand.press else 0.006 * into / np.linalg.norm(into)) / SCALE
    sim = _core.Simulation(
        o, arms.leader, arms.leader, arms.follower, rig.snapshot, _core.HandPath([0.0, 1.0], np.array([start, end]))
    )
    ticks = as_ticks(sim.run(2000))
    deepest = ticks[np.argmax(ticks["depth"])]
    assert deepest["depth"] > 1e-4
    assert np.linalg.norm(deepest["F_spring_W"]) == pytest.approx(K * deepest["depth"], rel=1e-6)
    assert made.errand.stiffness == K


def test_control_compares_displaced_guidance_with_correct_guidance_and_with_none():
    """Path errors of 5 mm displaced, 1 mm in place and 2 mm without: 4 mm more than right, 3 mm more than none."""
    errors = {"control_wrong": 5.0, "haptics+guidance": 1.0, "none": 2.0}
    rows = [
        {"task": "ring", "condition": c, "operator": k, "path_error_mm": e} for c, e in errors.items() for k in range(5)
    ]
    found = guidance_effects._against(rows, "ring")
    assert [found[f"than_right{x}_mm"] for x in ("", "_low", "_high")] == pytest.approx([4.0] * 3)
    assert [found[f"than_none{x}_mm"] for x in ("", "_low", "_high")] == pytest.approx([3.0] * 3)


@pytest.mark.parametrize(
    ("condition", "felt", "forces", "fixture", "off_mm"),
    [
        ("none", "looks", False, "", 0.0),
        ("visual", "shown", False, "", 0.0),
        ("haptics", "felt", True, "", 0.0),
        ("guidance", "looks", False, "soft", 0.0),
        ("haptics+guidance", "felt", True, "soft", 0.0),
        ("haptics+hard", "felt", True, "hard", 0.0),
        ("control_wrong", "felt", True, "soft", 5.0),
    ],
)
def test_conditions_are_those_of_the_page(condition, felt, forces, fixture, off_mm):
    """No guidance and no force in `none`; the control is guidance displaced by 5 mm."""
    c = guidance.CONDITIONS[condition]
    assert (c.senses.force, c.forces, c.guidance, c.offset_mm) == (felt, forces, fixture, off_mm)
    assert c.senses.drawn == (condition == "visual")


def test_displaced_guidance_lies_beside_the_path():
    """The registration error moves the fixture along y, to alternating sides, and the judge not at all."""
    for off_mm in (5.0, -5.0):
        (path,) = guidance._rig("insertion", "soft", off_mm).fixtures.list()
        X = np.eye(4)
        X[:3, 3] = guidance.task_of("insertion").errand.path[40]
        pull = path.evaluate(X, 0.0, np.zeros(6))["F"][:3]
        assert np.sign(pull[1]) == np.sign(off_mm)
        assert np.linalg.norm(pull) > 1.0


def serial(fn, grid, seed=0, **more):
    return sweep(fn, grid, seed, executor="serial", where=more.get("where"))


@pytest.fixture(scope="module")
def patch():
    with pytest.MonkeyPatch.context() as patch:
        yield patch


@pytest.fixture(scope="module")
def trials(patch):
    """Two operators, registration errors for the first of them."""
    for module in (guidance, guidance_effects):
        patch.setattr(module, "FEW", 1)
    return guidance.run(2, sweep=serial)


@pytest.fixture(scope="module")
def yields():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("palpate_lab.studies.guidance.yields.PATHS", ("ring", "insertion"))
        return yielding(3, sweep=serial)


@pytest.fixture(scope="module")
def visual_cues():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "palpate_lab.studies.guidance.cues.TASKS", {name: TASKS[name] for name in ("tracing", "insertion")}
        )
        return cued(3, sweep=serial)


def test_small_cohort_has_the_documented_keys_and_tables(trials, yields, visual_cues):
    report = guidance_effects.summary(trials, 7)
    report |= {"yields": yields, "visual_cues": visual_cues}
    few, all_ = len(guidance.REGISTRATION), len(guidance.CONDITIONS)
    assert len(trials) == len(TASKS) * (2 * all_ + few) + 2 * 2 * len(guidance.ABLATION)
    assert all(row["done"] == 1.0 for row in trials)
    assert set(report) == json_contract.keys("study guidance") - {"conformance", "entry", "stiffness", "care"}
    assert set(report["rows"][0]) == json_contract.keys_of("study guidance", "A row of `rows`:")
    assert set(report["effects"][0]) == json_contract.keys_of("study guidance", "A row of `effects`:")
    by = {(r["task"], r["condition"]): r for r in report["rows"]}
    for task in ("ring", "tracing", "insertion"):
        assert by[task, "guidance"]["path_error_mm"] < 0.8 * by[task, "none"]["path_error_mm"]
    for task in ("tracing", "palpation"):
        assert by[task, "haptics"]["peak_force_N"] < by[task, "none"]["peak_force_N"]
    assert set(report["registration"][0]) == json_contract.keys_of("study guidance", "A row of `registration`:")
    assert set(report["break_even"][0]) == json_contract.keys_of("study guidance", "A row of `break_even`:")
    assert set(report["ablation"][0]) == json_contract.keys_of("study guidance", "A row of `ablation`:")
    assert {row["task"] for row in report["ablation"]} == {"tracing", "palpation"}
    assert set(report["visual_cues"][0]) == json_contract.keys_of("study guidance", "A row of `visual_cues`:")
    assert set(report["yields"][0]) == json_contract.keys_of("study guidance", "A row of `yields`:")
    assert all(e["source"] for e in report["effects"] if e["expected_hedges_g"] is not None)
    for task in TASKS:
        assert by[task, "control_wrong"]["path_error_mm"] > by[task, "haptics+guidance"]["path_error_mm"]
    assert tables(report)


@pytest.fixture(scope="module")
def varied():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(guidance_effects, "FEW", 50)
        patch.setattr("palpate_lab.studies.guidance.assumptions.PATHS", ("insertion",))
        patch.setattr("palpate_lab.studies.guidance.assumptions.TASKS", {"insertion": TASKS["insertion"]})
        patch.setattr("palpate_lab.studies.guidance.assumptions.STIFFNESSES", (100.0, 600.0, 1500.0))
        return assumptions(3, sweep=serial)


def test_assumptions_have_the_documented_keys(varied):
    found = varied
    documented = json_contract.keys_of("study guidance", "With `--assumptions` the keys are")
    rows = {*found["stiffness"][0], *found["care"][0]} - {"path_error_mm", "change", "change_low", "change_high"}
    assert {*found, *rows} == documented - {"yields"}
    assert set(found["stiffness"][0]) - {"stiffness_N_per_m"} == json_contract.keys_of(
        "study guidance", "A row of `yields`:"
    ) - {"share"}
    assert (found["operators"], found["seed"]) == (3, 7)
    assert assumption_tables(found)


def test_a_stiffer_fixture_guides_more(varied):
    (soft, middle, stiff) = (row["change"] for row in varied["stiffness"])
    assert 0.0 > soft > middle > stiff


def test_operators_without_care_are_not_hastened_by_guidance(varied):
    """Guidance saves time because operators slow down for the error that they see; it leaves the others as they are."""
    (row,) = varied["care"]
    assert row["hedges_g"] < -0.3
    assert abs(row["hedges_g_without_care"]) < 0.3


def test_entry_results_have_the_documented_keys(monkeypatch):
    monkeypatch.setattr(entry, "REGIONS", {"floor": replace(entry.REGIONS["floor"], hands=2)})
    report = entered(serial)
    keys = {"hard_entry", "soft_entry", "entry_passed", *report["hard_entry"][0], *report["soft_entry"][0]}
    assert keys == json_contract.keys_of("study guidance", "`entry`:")
    assert report["hard_entry"][0]["hands"] == 2
    assert entry_words(report)[-1] == "entry: within the bounds"


def test_same_seed_gives_the_same_trial():
    point = {"operator": 3, "task": "insertion", "condition": "haptics+guidance", "cohort": 7}
    assert guidance.measure(point, 11) == guidance.measure(point, 11)
    assert guidance.measure(point, 11) != guidance.measure(point, 12)


def test_drawn_trial_is_one_of_the_study(trials):
    row = next(r for r in trials if (r["operator"], r["task"], r["condition"]) == (1, "tracing", "none"))
    trial = guidance.attempt(1, "tracing", "none", guidance.trial_seed(1, "tracing", "none"))
    assert guidance.judged(guidance.task_of("tracing"), trial)["path_error_mm"] == row["path_error_mm"]


def test_break_even_is_the_intersection_of_the_lines():
    """Path error e + 0.5 mm with guidance misplaced by e, against 2 mm without: 1.5 mm; 2.5 mm, never, and zero."""

    misplaced = ("haptics+guidance", *guidance.REGISTRATION, "control_wrong")

    def rows(slope, begin):
        errors = {"haptics": 2.0} | {n: begin + slope * guidance.ALL[n].offset_mm for n in misplaced}
        return [
            {"task": "ring", "condition": n, "operator": k, "path_error_mm": v, "peak_force_N": 0.0, "entries": 0.0}
            for n, v in errors.items()
            for k in range(2)
        ]

    for given, at in (
        ((1.0, 0.5), pytest.approx(1.5)),
        ((0.6, 0.5), pytest.approx(2.5)),
        ((0.1, 0.5), None),
        ((1.0, 3.0), 0.0),
    ):
        assert guidance_effects._break_even(rows(*given), "ring")["break_even_mm"] == at


def test_operators_without_haste_press_less():
    pressed = {
        c: guidance.measure({"operator": 2, "task": "tracing", "condition": c, "cohort": 7}, 5)["mean_force_N"]
        for c in ("none", "none_no_haste")
    }
    assert pressed["none_no_haste"] < pressed["none"]


def test_operators_who_yield_less_are_guided_less(yields):
    """A weaker trait reduces the effect of guidance; without forces on the hand the trait has no effect."""
    report = {row["share"]: row["change"] for row in yields if row["task"] == "insertion"}
    assert report[1.0] < report[0.5] < report[0.0]
    all_, not_ = (
        guidance.attempt(2, "ring", "none", 5, assumed=guidance.Assumed(yields=share)) for share in (1.0, 0.0)
    )
    np.testing.assert_array_equal(all_.p_WT, not_.p_WT)


def test_visual_cues_and_contact_forces_have_separate_effects(monkeypatch):
    """Drawn paths reduce the path error, rendered contact reduces the force, and both together reduce both.

    The hands differ so much that few of them show no effect: the intervals of 24 exclude zero.
    """
    monkeypatch.setattr("palpate_lab.studies.guidance.cues.TASKS", {"tracing": TASKS["tracing"]})
    monkeypatch.setattr(guidance_effects, "FEW", 24)
    report = {row["condition"]: row for row in cued(24, sweep=serial)}
    none, both = report["none"], report["visual+haptics"]
    assert none["path_error_mm_more_low"] == none["path_error_mm_more_high"] == 0.0
    for drawn in (report["visual"], both):
        assert drawn["path_error_mm"] < 0.95 * none["path_error_mm"]
        assert drawn["path_error_mm_more_high"] < 0.0
    for felt in (report["haptics"], both):
        assert felt["mean_force_N"] < 0.9 * none["mean_force_N"]
        assert felt["mean_force_N_more_high"] < 0.0


def test_empty_cohort_is_rejected():
    with pytest.raises(ValueError, match="operators must be 2 or more"):
        guidance.run(1)


def test_figures_of_the_cohort_are_in_the_docs():
    images = Path(__file__).resolve().parents[2] / "docs" / "images"
    for name in ("guidance", "guidance_paths", "guidance_registration"):
        assert (images / f"{name}.png").is_file()
