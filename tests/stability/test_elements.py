"""Virtual coupling and low-pass: closed forms, and the stated lag against the measured lag."""

from __future__ import annotations

import math

import numpy as np
import pytest

from palpate import _core, _verify

DT = 1e-3
COUPLING, LOW_PASS, CAPS = 0, 1, 3


def run(forces, stiffness=0.0, dt=DT, **options):
    """(rendered forces, last output) of requested forces along x, with large caps."""
    o = _core.StabilityOptions()
    for name, value in {"passivity": "off", "force_cap": 1e6, "rate_cap": 1e9, **options}.items():
        setattr(o, name, value)
    stage = _verify.Stability(o, dt)
    out = None
    rows = []
    for F in forces:
        out = stage.step([F, 0, 0, 0.01 * F, 0, 0], np.zeros(3), np.zeros(3), stiffness=stiffness)
        stage.rendered(out.F_H_L)
        rows.append(out.F_H_L)
    return np.array(rows), out


@pytest.mark.parametrize(("K", "Kc"), [(400.0, 1000.0), (2000.0, 500.0), (0.0, 300.0)])
def test_coupling_is_a_spring_in_series(K, Kc):
    rows, out = run([2.0] * 400, K, coupling_stiffness=Kc, coupling_damping=5.0)
    np.testing.assert_allclose(rows[-1, 0], 2.0 * Kc / (K + Kc), rtol=1e-9)
    np.testing.assert_allclose(rows[-1, 3], 0.02 * Kc / (K + Kc), rtol=1e-9)  # moments are proportional
    np.testing.assert_allclose(out.F_coupling[0], 2.0 * K / (K + Kc), rtol=1e-6, atol=1e-12)


def test_damped_coupling_has_its_closed_form():
    """Step: the damper is rigid at first; later F decreases by F K (1 - e^-t/T) / (K + Kc), T = B / (K + Kc)."""
    K, Kc, B = 400.0, 600.0, 4.0
    rows, _ = run([1.0] * 30, K, coupling_stiffness=Kc, coupling_damping=B)
    t = DT * np.arange(1, 31)
    np.testing.assert_allclose(rows[:, 0], 1.0 - K / (K + Kc) * -np.expm1(-t * (K + Kc) / B), rtol=1e-9)


def test_coupling_never_pulls():
    rows, _ = run([3.0] * 50 + [0.3] * 50, 3000.0, coupling_stiffness=300.0, coupling_damping=20.0)
    assert (rows[:, 0] >= 0.0).all()
    assert rows[51, 0] == 0.0


def test_low_pass_has_its_step_response():
    rows, _ = run([1.0] * 40, low_pass=30.0)
    np.testing.assert_allclose(rows[:, 0], 1.0 - np.exp(-2 * math.pi * 30.0 * DT * np.arange(1, 41)), rtol=1e-12)


def measured_lag(forces, rows, slope, gain=1.0):
    """Lag of a ramp in steady state [s]."""
    return (forces[-1] - rows[-1, 0] / gain) / slope


@pytest.mark.parametrize("cutoff", [10.0, 100.0, 400.0])
@pytest.mark.parametrize("dt", [1e-3, 2.5e-4])
def test_stated_lag_of_the_low_pass_is_the_measured_lag(cutoff, dt):
    ramp = 5.0 * dt * np.arange(round(0.3 / dt))
    rows, out = run(ramp, dt=dt, low_pass=cutoff)
    assert measured_lag(ramp, rows, 5.0) == pytest.approx(out.lag[LOW_PASS], rel=1e-6)
    assert out.lag[LOW_PASS] <= 1 / (2 * math.pi * cutoff)


def test_stated_lag_of_the_coupling_is_the_measured_lag():
    K, Kc = 400.0, 600.0
    ramp = 5.0 * DT * np.arange(400)
    rows, out = run(ramp, K, coupling_stiffness=Kc, coupling_damping=8.0)
    # a force held over a period is half a period old on average
    assert measured_lag(ramp, rows, 5.0, Kc / (K + Kc)) == pytest.approx(out.lag[COUPLING], abs=0.5 * DT * K / Kc)
    assert out.lag[COUPLING] < 0


def test_stated_lag_of_the_caps_is_their_time_to_catch_up():
    rows, out = run([0.0] + [1.0] * 5, rate_cap=50.0)
    assert out.lag[CAPS] == pytest.approx((1.0 - rows[-1, 0]) / 50.0)
    assert out.lag[CAPS] == pytest.approx(0.015)  # 5 of 20 ms have passed
