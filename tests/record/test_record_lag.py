"""The lag of each filter in summaries, reports and the viewer, against the filter's closed form and a ramp."""

import numpy as np
import pytest
import synthetic_run

from palpate import Scene, _core, _verify
from palpate.record.lag import NAMES, Lags, in_words
from palpate.report.summary import filter_lag, rows
from palpate.session import Session
from palpate.session.batch import simulate
from palpate.session.summary import summarise

CUTOFF, RATE = 30.0, 1000.0


def ticks_with(lags, asked=1.0):
    ticks = synthetic_run.run(1.0)[: len(lags)].copy()
    ticks["lag_ms"], ticks["F_asked"] = lags, [asked, asked, 0.0]
    return ticks


def ramp_lag(cutoff, slope=20.0):
    """Delay of a ramp of 20 N/s by the stage `stability` with a low-pass, after it has settled [ms]."""
    options = _core.StabilityOptions()
    options.low_pass, options.passivity, options.force_cap, options.rate_cap = cutoff, "off", 1e3, 1e6
    stage, late = _verify.Stability(options, 1.0 / RATE), 0.0
    for k in range(400):
        t = k / RATE
        F = np.r_[0.0, 0.0, slope * t, 0.0, 0.0, 0.0]
        out = stage.step(F, np.zeros(3), np.zeros(3), t=t, t_leader=t)
        stage.rendered(out.F_H_L)
        late = 1e3 * (t - out.F_H_L[2] / slope)
    return late


def test_summary_states_the_measured_lag_of_the_low_pass():
    scene = Scene.load("palpation")
    stability = scene.stability.model_copy(update={"low_pass": CUTOFF, "passivity": "off"})
    session = Session(scene.model_copy(update={"stability": stability}))
    ticks = np.concatenate([session.step(100) and [session.latest()] for _ in range(30)])
    found = summarise(ticks, RATE).lag_ms["low_pass"]
    assert found["mean_ms"] == pytest.approx(ramp_lag(CUTOFF), rel=1e-3)
    assert found["max_ms"] == pytest.approx(found["mean_ms"])
    session.close()


def test_mean_and_largest_lag_of_the_ticks_with_a_force():
    lags = np.zeros((4, len(NAMES)))
    lags[:, 0], lags[:, 3] = -5.0, [0.0, 1.0, 2.0, 0.0]
    total = Lags()
    total.add(ticks_with(lags[:2]))
    total.add(ticks_with(lags[2:]))
    total.add(ticks_with(np.full((3, len(NAMES)), 99.0), asked=0.0))
    found = total.figures()
    assert found == {"coupling": {"mean_ms": -5.0, "max_ms": -5.0}, "caps": {"mean_ms": 0.75, "max_ms": 2.0}}


def test_no_filter_has_no_lag():
    summary = summarise(ticks_with(np.zeros((5, len(NAMES)))), RATE)
    assert summary.lag_ms == {}
    assert filter_lag(summary) == "none"
    assert in_words(np.zeros(len(NAMES))) == "none"


def test_lags_are_in_the_table_of_a_run():
    summary = summarise(ticks_with(np.tile([0.0, 4.8, 0.0, 1.5], (5, 1))), RATE)
    (row,) = (row for row in rows(summary) if row[0] == "filter lag")
    assert row[1] == "low-pass 4.8, 4.8 ms; caps 1.5, 1.5 ms"


def test_lags_of_a_tick_in_words():
    assert in_words(np.array([-5.3, 1.144, 0.001, np.nan])) == "virtual coupling -5.3 ms, low-pass 1.1 ms"


def test_runs_of_many_have_the_same_lags():
    scene = Scene.load("palpation")
    stability = scene.stability.model_copy(update={"low_pass": CUTOFF})
    found = simulate([scene.model_copy(update={"stability": stability})], 2.0, signals=["lag_ms"], signal_rate=RATE)
    assert found.signals["lag_ms"][0][-1][1] == pytest.approx(ramp_lag(CUTOFF), rel=1e-3)
