"""`palpate study guidance`: its measures, its statistics, and a small cohort from end to end."""

from dataclasses import replace
from pathlib import Path

import json_contract
import numpy as np
import pytest

from palpate.operators import Trial
from palpate.studies.guidance import effects as guidance_effects
from palpate.studies.guidance import work as guidance
from palpate.studies.guidance.conformance import entered, entry_words
from palpate.studies.guidance.cues import cued
from palpate.studies.guidance.tasks import TASKS, distance, sleeve
from palpate.studies.guidance.words import tables
from palpate.studies.guidance.yields import yielding
from palpate.sweep import sweep
from palpate.verify.conformance import entry


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


def test_hedges_g():
    """Hedges' g against its definition, with the correction for small samples."""
    rng = np.random.default_rng(0)
    a, b = rng.normal(2.0, 1.0, 10), rng.normal(1.0, 1.0, 10)
    spread = np.sqrt((a.var(ddof=1) + b.var(ddof=1)) / 2)
    assert guidance_effects.hedges_g(a, b) == pytest.approx((b.mean() - a.mean()) / spread * (1 - 3 / 71))
    assert guidance_effects.hedges_g(a, a) == 0.0


def test_every_entry_is_counted_once():
    """A short exit within the hysteresis continues an entry; a full exit and return is a second entry."""
    deep = 1e-3 * np.array([-1.0, 1.0, 0.5, -0.01, 0.5, -1.5, 0.4, -2.0])
    task = replace(guidance.task_of("ring"), outside=lambda p: p[:, 0], off=lambda p: np.full(len(p), 3e-3))
    result = guidance.judged(
        task, Trial(np.arange(8.0), deep[:, None] * np.eye(3)[0], np.arange(8.0), np.zeros(8), True)
    )
    assert result["entries"] == 2
    assert result["deepest_mm"] == pytest.approx(1.0)
    assert result["path_error_mm"] == pytest.approx(3.0)
    assert result["peak_force_N"] == 7.0


def serial(fn, grid, seed=0, **more):
    return sweep(fn, grid, seed, executor="serial", where=more.get("where"))


@pytest.fixture(scope="module")
def trials():
    return guidance.run(2, sweep=serial)


def test_small_cohort_has_the_documented_keys_and_tables(trials):
    report = guidance_effects.summary(trials, 7)
    report |= {"yields": yielding(2, sweep=serial), "visual_cues": cued(2, sweep=serial)}
    assert len(trials) == 2 * (
        len(TASKS) * len(guidance.CONDITIONS | guidance.REGISTRATION) + 2 * len(guidance.ABLATION)
    )
    assert all(row["done"] == 1.0 for row in trials)
    assert set(report) == json_contract.keys("study guidance") - {"conformance", "entry"}
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
    """Path error e + 0.5 mm with guidance misplaced by e, against 2 mm without: 1.5 mm; then never, and zero."""

    misplaced = ("haptics+guidance", *guidance.REGISTRATION, "control_wrong")

    def rows(slope, begin):
        errors = {"haptics": 2.0} | {n: begin + slope * guidance.ALL[n].offset_mm for n in misplaced}
        return [
            {"task": "ring", "condition": n, "operator": k, "path_error_mm": v, "peak_force_N": 0.0, "entries": 0.0}
            for n, v in errors.items()
            for k in range(2)
        ]

    for given, at in (((1.0, 0.5), pytest.approx(1.5)), ((0.1, 0.5), None), ((1.0, 3.0), 0.0)):
        assert guidance_effects._break_even(rows(*given), "ring")["break_even_mm"] == at


def test_operators_without_haste_press_less():
    pressed = {
        c: guidance.measure({"operator": 2, "task": "tracing", "condition": c, "cohort": 7}, 5)["mean_force_N"]
        for c in ("none", "none_no_haste")
    }
    assert pressed["none_no_haste"] < pressed["none"]


def test_operators_who_yield_less_are_guided_less():
    """A weaker trait reduces the effect of guidance; without forces on the hand the trait has no effect."""
    report = {row["share"]: row["change"] for row in yielding(4, sweep=serial) if row["task"] == "insertion"}
    assert report[1.0] < report[0.5] < report[0.0]
    all_, not_ = (guidance.attempt(2, "ring", "none", 5, yields=share) for share in (1.0, 0.0))
    np.testing.assert_array_equal(all_.p_WT, not_.p_WT)


def test_visual_cues_and_contact_forces_have_separate_effects():
    """Drawn paths reduce the path error, rendered contact reduces the force, and both together reduce both."""
    report = {row["condition"]: row for row in cued(4, sweep=serial) if row["task"] == "tracing"}
    none, both = report["none"], report["visual+haptics"]
    assert none["path_error_mm_more_low"] == none["path_error_mm_more_high"] == 0.0
    for drawn in (report["visual"], both):
        assert drawn["path_error_mm"] < 0.95 * none["path_error_mm"]
    for felt in (report["haptics"], both):
        assert felt["mean_force_N"] < 0.9 * none["mean_force_N"]


def test_empty_cohort_is_rejected():
    with pytest.raises(ValueError, match="operators must be 2 or more"):
        guidance.run(1)


def test_figures_of_the_cohort_are_in_the_docs():
    images = Path(__file__).resolve().parents[2] / "docs" / "images"
    for name in ("guidance", "guidance_paths", "guidance_registration"):
        assert (images / f"{name}.png").is_file()
