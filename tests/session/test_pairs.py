"""Several pairs in one scene: lockstep, records, and pairs that do not disturb each other."""

import time

import numpy as np
import pytest

import palpate
from palpate.base.errors import PalpateError
from palpate.record import Record
from palpate.record.ticks import as_ticks
from palpate.scene import Scene
from palpate.session import PairsSession
from palpate.session.rates import recorded

TWO = """\
objects: [{shape: organ, triangles: 3000, stiffness: 400, damping: 2}]
operator: {palpate: {force: 1, approach: 0.4, press: 0.3, slide: 0.4, leave: 0.3}, tremor: 2.0e-5}
pairs:
  right:
    arms:
      leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
      follower: {base: {xyz: [-0.120, -0.060, 0.155], rpy_deg: [0, 0, 205]}}
    operator: {palpate: {force: 1, at: [-0.035, -0.012, 0.1], approach: 0.4, press: 0.3, slide: 0.4}}
  left:
    arms:
      leader: {model: mtm_left, base: {xyz: [-0.345, 0.243, 0.219], rpy_deg: [0, 0, 20]}}
      follower: {base: {xyz: [0.060, -0.060, 0.155], rpy_deg: [0, 0, 155]}}
    operator: {palpate: {force: 0.7, length: 0.01, at: [0.03, -0.012, 0.1], approach: 0.4, press: 0.3, slide: 0.4}}
"""


def test_both_pairs_palpate_and_have_the_summary_of_one_pair():
    scene = Scene.parse(TWO)
    session = PairsSession(scene)
    summary = session.run(1.0)
    assert list(summary.pairs) == ["right", "left"]
    assert summary.pairs["right"].peak_force_N > summary.pairs["left"].peak_force_N > 0.2
    assert 0.0 <= summary.instruments.peak_50ms_N <= summary.instruments.peak_force_N
    alone = palpate.Session(scene.pair("right")).run(0.01)
    assert vars(summary.pairs["right"]).keys() == vars(alone).keys()


def test_a_pair_that_meets_nobody_runs_as_it_does_alone():
    scene = Scene.parse(TWO)
    session = PairsSession(scene)
    session.step(400)
    alone = palpate.Session(scene.pair("left"), seed=scene.seed + 1)
    alone.step(400)
    for name in ("t", "q", "v", "tau", "F_H_L", "energy_port"):
        np.testing.assert_array_equal(session.states["left"].tick[name], alone.state.tick[name])


def test_lockstep_records_are_equal_byte_by_byte(tmp_path):
    sums = []
    for k in range(2):
        summary = PairsSession(Scene.parse(TWO), out=tmp_path / str(k)).run(0.3)
        sums.append([one.record_sha256 for one in summary.pairs.values()])
    assert sums[0] == sums[1]
    assert None not in sums[0]
    assert sums[0][0] != sums[0][1]


def test_each_pair_has_a_record_with_the_signals_of_its_meetings(tmp_path):
    summary = PairsSession(Scene.parse(TWO), out=tmp_path).run(0.3)
    for name, one in summary.pairs.items():
        record = Record.open(one.record)
        assert record.path.parent.name == name
        assert record.ticks["instrument_gap"].min() == pytest.approx(summary.instruments.closest_m)
        assert Scene.parse(record.scene).arms.leader.model == Scene.parse(TWO).pair(name).arms.leader.model
    one = palpate.Session(Scene.parse(TWO).pair("right"), out=tmp_path).run(0.3)
    assert "instrument_gap" not in Record.open(one.record).signals


def test_a_stalled_pair_does_not_delay_the_other():
    session = PairsSession(Scene.parse(TWO))
    right, left = session.pairs.values()
    session.start()
    left.simulation.stall(0.1)
    while float(right.latest()["t"]) < 0.3:
        time.sleep(0.01)
    session.stop()
    stalled, other = left.simulation.timing(), right.simulation.timing()
    assert stalled["missed_ticks"] >= 95
    assert other["missed_ticks"] < stalled["missed_ticks"] - 50


def test_the_force_of_a_pair_does_not_depend_on_a_stalled_one():
    # In lockstep the machine's own delays play no part: a pair that never publishes again is a pair that stalls.
    both = PairsSession(Scene.parse(TWO))
    both.step(700)
    session = PairsSession(Scene.parse(TWO))
    session.step(300)
    alone = session.pairs["right"].simulation
    rows = as_ticks(alone.run(400))
    assert rows["F_H_L"][-1].any()
    np.testing.assert_array_equal(rows["F_H_L"][-1], both.states["right"].tick["F_H_L"])


def test_a_run_can_be_interrupted_and_goes_on():
    session = PairsSession(Scene.parse(TWO))
    summary = session.run(1.0, on_progress=lambda states: session.interrupt())
    assert summary.interrupted
    assert summary.duration_s < 1.0


def test_a_pair_cannot_be_removed_while_it_runs():
    session = PairsSession(Scene.parse(TWO))
    session.start()
    with pytest.raises(PalpateError, match="cannot be removed while it runs"):
        session.remove("left")
    with pytest.raises(TypeError):
        del session.pairs["left"]
    assert session.running
    assert list(session.pairs) == ["right", "left"]
    session.stop()
    with pytest.raises(PalpateError, match="no pair 'middle'"):
        session.remove("middle")
    session.remove("left")
    assert list(session.step(10)) == ["right"]
    with pytest.raises(PalpateError, match="last pair"):
        session.remove("right")


def test_rates_of_a_record_name_every_loop_and_its_missed_ticks():
    session = PairsSession(Scene.parse(TWO))
    session.step(100)
    ticks = as_ticks(session.pairs["left"].simulation.run(100))
    lockstep = recorded("left", ticks, 1000.0, None)[0]
    assert (lockstep.name, lockstep.asked_Hz, lockstep.missed) == ("left haptic loop", 1000.0, None)
    assert lockstep.measured_Hz == pytest.approx(1000.0)
    late = recorded("left", ticks, 1000.0, {"missed_ticks": 99})[0]
    assert late.measured_Hz == pytest.approx(500.0, rel=0.01)  # half of the time was missed


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_pair_whose_record_crashes_does_not_stop_the_other(monkeypatch):
    session = PairsSession(Scene.parse(TWO))

    def crash():
        raise RuntimeError("planted")

    monkeypatch.setattr(session.pairs["left"], "_keep_draining", crash)
    summary = session.run(0.3, realtime=True)
    assert summary.pairs["right"].duration_s >= 0.3
    assert summary.pairs["right"].faults == ()
