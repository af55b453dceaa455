"""Measures equal published values and closed forms, whatever the blocks in which a record is read."""

import json
import math

import json_contract
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from palpate import Record, Scene, Session, metrics
from palpate.cli import main
from palpate.metrics import measures
from palpate.metrics.smoothness import movements, sparc
from palpate.record.ticks import STATUS, TICK

GAUSSIAN = np.exp(-5.0 * np.arange(-1.0, 1.0, 0.01) ** 2)


def test_published_values_of_a_gaussian_speed():
    """Balasubramanian's test: 2 s at 100 samples a second."""
    assert metrics.sparc(GAUSSIAN, 100.0) == pytest.approx(-1.41403, abs=1e-4)
    assert metrics.log_dimensionless_jerk(GAUSSIAN, 100.0) == pytest.approx(-5.81636, abs=1e-4)


@given(scale=st.floats(1e-3, 1e3))
def test_smoothness_does_not_depend_on_the_size_of_a_movement(scale):
    assert metrics.sparc(scale * GAUSSIAN, 100.0) == pytest.approx(metrics.sparc(GAUSSIAN, 100.0))
    assert metrics.log_dimensionless_jerk(scale * GAUSSIAN, 100.0) == pytest.approx(
        metrics.log_dimensionless_jerk(GAUSSIAN, 100.0)
    )


def test_jerk_of_a_minimum_jerk_movement_is_its_closed_form():
    """Its speed is 30 u^2 (1 - u)^2: the integral of the squared second derivative is 720, and the peak 1.875."""
    u = np.arange(0.0, 1.0, 1e-4)
    speed = 30.0 * u**2 * (1.0 - u) ** 2
    assert metrics.log_dimensionless_jerk(speed, 1e4) == pytest.approx(-math.log(720.0 / 1.875**2), abs=1e-3)


def test_tremor_makes_a_movement_less_smooth():
    t = np.arange(-1.0, 1.0, 0.01)
    shaken = np.abs(GAUSSIAN + 0.1 * np.sin(2 * np.pi * 8.0 * t))
    assert metrics.sparc(shaken, 100.0) < metrics.sparc(GAUSSIAN, 100.0) - 0.1
    assert metrics.log_dimensionless_jerk(shaken, 100.0) < metrics.log_dimensionless_jerk(GAUSSIAN, 100.0) - 1.0


def test_standing_still_has_no_smoothness():
    assert math.isnan(metrics.sparc(np.zeros(50), 100.0))
    assert math.isnan(metrics.log_dimensionless_jerk(np.zeros(50), 100.0))
    assert metrics.movements(np.zeros(50), 100.0) == []


def test_movements_are_cut_at_pauses_and_twitches_are_left_out():
    speed = np.concatenate([np.zeros(50), GAUSSIAN, np.zeros(50), GAUSSIAN, np.zeros(50), np.ones(20)])
    spans = metrics.movements(speed, 100.0)
    assert len(spans) == 2
    assert [round((a.start + a.stop) / 2) for a in spans] == [150, 400]


def ticks(n=4000):
    """A straight path of 80 mm in the first half, then 2 N for a second, a clutch, two entries, one drop."""
    made = np.zeros(n, dtype=TICK)
    made["t"] = np.arange(n) * 1e-3
    s = np.clip(np.arange(n) / (n / 2), 0.0, 1.0)
    made["p_WT"][:, 0] = 0.08 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    made["p_LH"] = 2.0 * made["p_WT"]
    made["F_T_W"][2500:3500, 2] = 2.0
    made["status"][100:200] = STATUS["clutched"][0]
    made["guidance_gap"], made["guidance_fixture"] = 1.0, -1.0
    made["guidance_fixture"][600:1000] = 0.0
    made["guidance_gap"][650:700] = made["guidance_gap"][800:900] = -1e-3
    made["holding"][1000:3000] = 1.0
    return made


@given(cuts=st.lists(st.integers(1, 3999), max_size=6))
def test_known_motion_gives_its_measures_in_any_blocks(cuts):
    made = ticks()
    taken = measures._Taken(1000.0)
    for block in np.split(made, sorted(cuts)):
        taken.add(block)
    found = taken.measures(need=1.0, harm=3.0, threshold=1.5)
    assert found["time_s"] == 4.0
    assert found["path_tool_m"] == pytest.approx(0.08)
    assert found["path_hand_m"] == pytest.approx(0.16)
    assert (found["clutches"], found["touches"], found["margin_entries"], found["drops"]) == (1, 1, 2, 1)
    assert found["contact_s"] == found["above_threshold_s"] == 1.0
    assert (found["mean_force_N"], found["peak_force_N"], found["peak_50ms_N"]) == pytest.approx((2.0, 2.0, 2.0))
    assert found["impulse_Ns"] == pytest.approx(2.0)
    assert found["force_per_path_N_per_m"] == pytest.approx(25.0)
    assert found["movements"] == 1
    assert (found["excess"], found["peaks"], found["unsteady"]) == pytest.approx((1.0, 0.0, 0.0))
    assert found["force_sensitivity"] == pytest.approx(50.0)


@pytest.mark.parametrize("every", [1, 10])
def test_measures_of_a_record_are_those_of_its_arrays(tmp_path, every):
    """Over several blocks of the reader, and for a thinned record."""
    scene = Scene.parse(
        "objects: [{sphere: {radius: 0.03}}]\noperator: {palpate: {approach: 0.5, press: 0.5, slide: 1, leave: 0.5}}\n"
        f"record: {{report: false, every: {every}}}\n"
    )
    record = Record.open(Session(scene, out=str(tmp_path)).run(2.5).record)
    found, step = metrics.summary(record), 10 // every
    for name, signal in (("path_tool_m", "p_WT"), ("path_hand_m", "p_LH")):
        p = record[signal][::step]
        assert found[name] == pytest.approx(np.linalg.norm(np.diff(p, axis=0), axis=1).sum(), rel=1e-9)
    F = np.linalg.norm(record["F_T_W"], axis=1)
    assert found["impulse_Ns"] == pytest.approx(F.sum() * every / 1000.0, rel=1e-5)
    assert found["peak_force_N"] == pytest.approx(F.max(), rel=1e-6)


def test_measures_without_their_signals_are_unknown_not_zero(tmp_path):
    scene = Scene.parse("objects: [{sphere: {radius: 0.03}}]\nrecord: {report: false, signals: [p_WT]}\n")
    found = metrics.summary(Session(scene, out=str(tmp_path)).run(0.5).record)
    assert {name for name, value in found.items() if not math.isnan(value)} >= {"time_s", "path_tool_m", "movements"}
    for name in ("path_hand_m", "clutches", "touches", "impulse_Ns", "drops", "margin_entries", "force_sensitivity"):
        assert math.isnan(found[name]), name


def test_nothing_touched_and_nothing_recorded():
    taken = measures._Taken(1000.0)
    found = taken.measures(1.0, 3.0, 1.0)
    assert found["time_s"] == found["path_tool_m"] == found["peak_force_N"] == 0.0
    assert all(math.isnan(found[name]) for name in ("mean_force_N", "force_sensitivity", "sparc"))


def test_command_has_the_documented_keys_and_refuses_impossible_forces(tmp_path, capsys):
    scene = Scene.parse("objects: [{sphere: {radius: 0.03}}]\nrecord: {report: false}\n")
    record = Session(scene, out=str(tmp_path)).run(0.5).record
    assert main(["metrics", record, "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found) == json_contract.keys("metrics")
    assert found["time_s"] == 0.5
    assert main(["metrics", record, "--need", "0"]) == 2
    assert "--need 0: must be above 0" in capsys.readouterr().err


def test_what_is_not_a_number_is_left_out_of_a_motion():
    speed = np.concatenate([np.zeros(10), np.ones(100), [np.nan], np.ones(100), np.zeros(10)])
    assert movements(speed, 100.0) == [slice(10, 110), slice(111, 211)]
    assert movements(np.full(5, np.nan), 100.0) == movements(np.zeros(0), 100.0) == []
    assert math.isnan(sparc(np.zeros(0), 100.0))
    assert math.isnan(metrics.Wanted(path=np.zeros((1, 3))).path_error(np.full((4, 3), np.nan)))


def test_scores_of_the_field():
    assert metrics.fls_peg_transfer(120.0, 0) == 180.0
    assert metrics.fls_peg_transfer(120.0, 3) == 130.0
    assert metrics.fls_peg_transfer(400.0, 0) == 0.0
    with pytest.raises(ValueError, match="7 of 6"):
        metrics.fls_peg_transfer(120.0, 7)
    with pytest.raises(ValueError, match="0 of 0"):
        metrics.fls_peg_transfer(120.0, 0, objects=0)
    assert metrics.simulator_score({"time_s": 50.0, "drops": 1}, {"time_s": (45, 6), "drops": (0, 0.5)}) == {
        "time_s": True,
        "drops": False,
    }


def test_the_benchmark_of_experts_is_their_mean_and_one_deviation():
    experts = [{"time_s": t, "drops": 0.0, "sparc": s} for t, s in ((40.0, -2.0), (50.0, float("nan")), (60.0, -2.5))]
    found = metrics.benchmark(experts)
    assert found == {"time_s": (50.0, 10.0), "drops": (0.0, 0.0)}
    assert metrics.simulator_score({"time_s": 60.0, "drops": 1.0}, found) == {"time_s": True, "drops": False}
    with pytest.raises(ValueError, match="1 trials of experts"):
        metrics.benchmark(experts[:1])


def test_errors_of_force_and_path_are_those_of_the_task():
    """The tool of `ticks` runs along x at y = z = 0; the path lies 3 mm beside and 4 mm above it."""
    taken = measures._Taken(1000.0)
    taken.add(ticks())
    path = np.array([[0.0, 0.003, 0.004], [0.08, 0.003, 0.004]])
    found = taken.measures(1.0, 3.0, 1.0, metrics.Wanted(1.5, path))
    assert found["force_error_N"] == pytest.approx(0.5)
    assert found["path_error_m"] == pytest.approx(0.005)
    flat = taken.measures(1.0, 3.0, 1.0, metrics.Wanted(None, path, np.array([0.0, 0.0, 1.0])))
    assert flat["path_error_m"] == pytest.approx(0.003)
    assert math.isnan(flat["force_error_N"])
