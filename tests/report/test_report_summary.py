"""Numbers of the summary against closed forms of a synthetic run."""

import hashlib
import io
from dataclasses import replace

import numpy as np
import pytest
import synthetic_run
from rich.console import Console

from palpate.base.plotting.style import thin
from palpate.record import Record, Recorder
from palpate.record.ticks import STATUS
from palpate.report.assumptions import slow_motion
from palpate.report.run import Run
from palpate.report.summary import rows, summary_of, summary_table
from palpate.session.summary import summarise

SCENE = "name: floor\nstability: {force_cap: 3.0}\n"


def record_of(tmp_path, ticks, deterministic=False, close=True, **end) -> Record:
    recorder = Recorder(tmp_path / "r.mcap", SCENE, 0, 1000.0, deterministic)
    recorder.append(ticks)
    if close:
        recorder.close(**end)
    return Record.open(tmp_path / "r.mcap")


def test_summary_has_the_known_values(tmp_path):
    ticks = synthetic_run.run(4.0)
    summary = summary_of(record_of(tmp_path, ticks, timing={"missed_ticks": 3}, faults=["leader silent"]))
    speed = synthetic_run.DEPTH / 0.6  # duration of the press: 0.6 s
    assert summary.peak_force_N == pytest.approx(synthetic_run.K * synthetic_run.DEPTH, abs=synthetic_run.B * speed)
    assert summary.max_penetration_m == pytest.approx(synthetic_run.DEPTH)
    assert summary.contact_s == pytest.approx((0.9 - 0.25) * 4.0, abs=0.003)
    # ramp up 0.6 s, hold 1.4 s, ramp down 0.6 s: the mean over the contact is (0.3 + 1.4 + 0.3) / 2.6 of the peak
    assert summary.mean_force_N == pytest.approx(2.0 * 2.0 / 2.6, rel=0.01)
    assert summary.energy_J == ticks["energy_port"][-1]
    assert summary.cycle_p50_us == pytest.approx(np.percentile(ticks["cycle_us"], 50), rel=1e-5)
    assert summary.cycle_p99_us == pytest.approx(np.percentile(ticks["cycle_us"], 99), rel=1e-5)
    assert (summary.missed_ticks, summary.realtime, summary.faults) == (3, True, ("leader silent",))


def test_killed_run_is_a_fault(tmp_path):
    record = record_of(tmp_path, synthetic_run.run(1.0), close=False)
    (fault,) = summary_of(record).faults
    assert "no end" in fault


def test_table_has_units_and_descriptions(tmp_path):
    out = io.StringIO()
    summary = summary_of(record_of(tmp_path, synthetic_run.run(1.0), deterministic=True))
    Console(file=out, width=120).print(summary_table(summary))
    text = out.getvalue()
    for expected in ("peak force", "4.00 mm", " N ", " s ", "mJ"):
        assert expected in text
    assert "haptic cycle" not in text, "a lockstep record has no cycle time"
    assert all(unit for _, unit, _ in rows(summary))


def summary_with(**values):
    """A summary of a run of 8 s, of which 2 s in contact, with other values."""
    given = {"duration_s": 8.0, "contact_s": 2.0, "ticks": 8000, "energy_J": 0.012, "peak_force_N": 1.234}
    return replace(summarise(synthetic_run.run(1.0), 1000.0), **(given | values))


def told(**values):
    """Value and meaning of each row by its name."""
    return {name: (value, meaning) for name, value, meaning in rows(summary_with(**values))}


def test_rows_have_the_values_of_the_summary():
    found = told(max_penetration_m=0.12345, mean_force_N=0.5, capped_s=0.25, passivity_s=0.75, peak_speed_m_s=0.0625)
    assert found["peak force"][0] == "1.23 N"
    assert found["mean force"][0] == "0.50 N"
    assert found["deepest penetration"][0] == "123.45 mm"
    assert found["time in contact"] == ("2.00 s", "25 % of the 8.00 s run")
    assert found["force capped"][0] == "0.25 s"
    assert found["passivity"][0] == "0.75 s"
    assert found["top speed"][0] == "0.062 m/s"
    assert told(contact_s=6.0)["time in contact"] == ("6.00 s", "75 % of the 8.00 s run")
    assert told(duration_s=0.0)["time in contact"][1] == "0 % of the 0.00 s run"


@pytest.mark.parametrize(
    ("joules", "lent", "value", "meaning"),
    [
        (0.012, 0.0, "12.00 mJ", "taken from the hand"),
        (0.0, 0.0, "0.00 mJ", "taken from the hand"),
        (0.9994, 0.0, "999.40 mJ", "taken from the hand"),
        (1.0, 0.0, "1.000 J", "taken from the hand"),
        (-2.5, 0.0, "-2.500 J", "generated: more energy returned than taken"),
        (-0.002, 0.001, "-2.00 mJ", "generated: more energy returned than taken"),
        (-0.002, 0.002, "-2.00 mJ", "given to the hand, within the 2.00 mJ credited when fixtures were switched on"),
    ],
)
def test_energy_is_taken_credited_or_generated(joules, lent, value, meaning):
    assert told(energy_J=joules, energy_lent_J=lent)["energy"] == (value, meaning)


def test_rows_of_timing_depend_on_the_kind_of_run():
    cycle = {"cycle_p50_us": 5.0, "cycle_p99_us": 14.5, "cycle_p999_us": 20.0, "cycle_max_us": 99.0}
    assert told(**cycle)["haptic cycle"][0] == "5.0 / 14.5 / 20.0 / 99 us"
    assert "haptic cycle" not in told(**(cycle | {"cycle_max_us": 0.0}))
    realtime = told(realtime=True, missed_ticks=3, realtime_factor=1.0)
    assert realtime["missed ticks"][0] == "3 of 8003"
    assert "speed" not in realtime
    lockstep = told(realtime=False, realtime_factor=34.5)
    assert lockstep["speed"][0] == "34.5 x"
    assert told(realtime=False, realtime_factor=0.25)["speed"][0] == "0.2 x", "slower than real time"
    assert not {"speed", "missed ticks"} & set(told(realtime=False, realtime_factor=0.0))


def test_states_are_counted_each_for_itself():
    ticks = synthetic_run.run(1.0)
    ticks["status"] = 0
    for bit, first, last in (("force_capped", 0, 100), ("passivity", 50, 250), ("too_fast", 400, 700)):
        ticks["status"][first:last] |= STATUS[bit][0]
    found = summarise(ticks, 1000.0)
    assert (found.capped_s, found.passivity_s, found.fast_s) == (0.1, 0.2, 0.3)
    assert found.duration_s == len(ticks) / 1000.0


def test_the_scheduler_is_told_of_real_time_only():
    timing = {"missed_ticks": 2, "scheduler": "SCHED_FIFO"}
    ticks = synthetic_run.run(0.1)
    assert summarise(ticks, 1000.0, timing=timing, realtime=True).scheduler == "SCHED_FIFO"
    assert summarise(ticks, 1000.0, timing=timing).scheduler == ""
    assert summarise(ticks, 1000.0).missed_ticks == 0


def test_fast_motion_is_told():
    assert "stayed small" in told(fast_s=0.0)["fast motion"][1]
    assert told(fast_s=0.004)["fast motion"] == ("0.00 s", told(fast_s=0.5)["fast motion"][1])
    assert "too fast" in told(fast_s=0.004)["fast motion"][1]


def test_a_record_notes_its_faults_its_hash_and_whether_it_is_real_time(tmp_path):
    record = record_of(tmp_path, synthetic_run.run(0.5), deterministic=True, faults=["leader silent"])
    summary = summary_of(record)
    assert summary.faults == ("leader silent",)
    assert not summary.realtime
    assert summary.record_sha256 == hashlib.sha256((tmp_path / "r.mcap").read_bytes()).hexdigest()
    assert summary.record == str(tmp_path / "r.mcap")


def test_phases_follow_the_motion(tmp_path):
    ticks = synthetic_run.run(8.0)
    ticks["p_WT"][:, 1] = 0.0  # no lateral motion except the slide
    run = Run(record_of(tmp_path, ticks))
    assert [p.name for p in run.phases] == ["approach", "press", "slide", "leave"]
    approach, press, slide, leave = run.phases
    assert (approach.start, approach.end) == (0.0, pytest.approx(2.0, abs=0.01))
    assert press.end == pytest.approx(0.4 * 8, abs=0.1)
    assert slide.end == pytest.approx(0.75 * 8, abs=0.1)
    assert leave.end == pytest.approx(8.0, abs=0.01)
    assert run.stiffness == pytest.approx(synthetic_run.K)


def test_slow_motion_is_reported_as_found_by_the_cycle():
    ticks = synthetic_run.run(4.0)
    ticks["status"], ticks["F_neglected"], ticks["v_LH"] = 0, 0.1, [0.05, 0.0, 0.0]
    calm = slow_motion(ticks, 1000.0)
    assert calm.kept
    assert calm.peak_speed == pytest.approx(0.05)
    assert "up to 0.10 N (limit 0.30)" in calm.words
    ticks["status"][1500:1700] = STATUS["too_fast"][0]
    ticks["F_neglected"][1600] = 0.7
    fast = slow_motion(ticks, 1000.0)
    assert (fast.kept, fast.first, fast.broken_s) == (False, pytest.approx(1.5), pytest.approx(0.2))
    assert fast.peak_inertia == pytest.approx(0.7)
    assert "too fast" in fast.words


def test_decimation_keeps_every_peak():
    rng = np.random.default_rng(3)
    t, y = np.arange(100_003) / 1e3, rng.normal(size=100_003)
    y[54_321] = 99.0
    few_t, few = thin(t, y, 1000)
    assert len(few) <= 1300
    assert few.max() == 99.0
    assert few.min() == y.min()
    assert (np.diff(few_t) > 0).all()
