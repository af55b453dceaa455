"""The passivity layer: the true energy of the port is never below the allowance, for any input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core, _verify

DT, ALLOWANCE, A = 1e-3, 5e-4, 5.0
PASSIVITY = 1 << 13


def options(**changes):
    o = _core.StabilityOptions()
    for name, value in changes.items():
        setattr(o, name, value)
    return o


def drive(o, x, requested, delay=0, drive_share=1.0):
    """(commanded force, true port energy) of a stage along a motion x (n,) [m]; `delay` in whole periods."""
    stage = _verify.Stability(o, DT)
    v = np.diff(x, prepend=x[0]) / DT
    F = np.zeros(len(x))
    for k in range(len(x)):
        out = stage.step([requested[k], 0, 0], np.array([x[k], 0, 0]), np.array([v[k], 0, 0]))
        F[k] = drive_share * out.F_H_L[0]
        stage.rendered([F[k], 0, 0])
    acting = np.concatenate([np.zeros(delay), F[: len(F) - delay]])
    return F, np.concatenate([[0.0], np.cumsum(-acting[:-1] * np.diff(x))])


def smooth_motion(accelerations, scale=A):
    """Positions of a handle [m] with a constant acceleration below the bound in each period."""
    return np.cumsum(np.cumsum(scale * np.repeat(accelerations, 25)) * DT) * DT


motions = st.lists(st.floats(-0.9, 0.9), min_size=4, max_size=40).map(smooth_motion)


@settings(max_examples=150, deadline=None)
@given(x=motions, forces=st.lists(st.floats(-20, 20), min_size=3, max_size=20), delay=st.integers(0, 30),
       mode=st.sampled_from(["observer", "tank"]))  # fmt: skip
def test_no_force_and_no_motion_generate_energy(x, forces, delay, mode):
    """For any requested force, motions within the stated acceleration, and any stated delay of whole periods."""
    requested = np.resize(np.repeat(forces, 17), len(x))
    o = options(passivity=mode, delay=delay * DT, rate_cap=200.0)
    _, energy = drive(o, x, requested, delay)
    assert energy.min() >= -ALLOWANCE - 1e-9


@settings(max_examples=60, deadline=None)
@given(x=motions, K=st.floats(50, 5000), delay=st.integers(0, 50), share=st.floats(0.2, 1.0))
def test_wall_generates_no_energy_with_weak_motors(x, K, delay, share):
    _, energy = drive(options(delay=delay * DT), x, -K * np.maximum(x, 0.0), delay, share)
    assert energy.min() >= -ALLOWANCE - 1e-9


@settings(max_examples=60, deadline=None)
@given(x=motions, K=st.floats(50, 5000))
def test_force_never_grows_faster_than_the_rate_cap(x, K):
    F, _ = drive(options(), x, -K * np.maximum(x, 0.0))
    assert np.diff(np.abs(F), prepend=0.0).max() <= 50.0 * DT * (1 + 1e-9)
    assert np.abs(F).max() <= 3.0
    F, _ = drive(options(passivity="off"), x, -K * np.maximum(x, 0.0))
    assert np.abs(np.diff(F, prepend=0.0)).max() <= 50.0 * DT * (1 + 1e-9)  # and falls no faster by itself


def press(depth, seconds, n=1):
    """Positions of n half waves into a wall and back [m]."""
    t = np.arange(0, n * seconds, DT)
    return depth * np.abs(np.sin(np.pi * t / seconds))


def test_delayed_wall_generates_energy_only_without_the_layer():
    x = press(0.006, 0.5, 8)
    requested = -400.0 * np.maximum(x, 0)
    delay = 10
    off, made = drive(options(passivity="off"), x, requested, delay)
    _, kept = drive(options(delay=0.010), x, requested, delay)
    # K v tau dx into and out of every press while no cap acts: Gil, Sanchez et al. 2009
    assert made[-1] == pytest.approx(-400.0 * 0.010 * np.sum(np.diff(x) ** 2) / DT, rel=0.05)
    assert kept.min() >= -ALLOWANCE - 1e-9
    assert np.abs(off).max() > 2.0


def test_slow_spring_is_unchanged():
    x = press(0.005, 2.0, 3)
    requested = -400.0 * x
    F, _ = drive(options(), x, requested)
    np.testing.assert_allclose(F, requested, atol=1e-12)


def test_withheld_force_is_reported():
    stage = _verify.Stability(options(allowance=0.0), DT)
    zero = np.zeros(3)
    out = stage.step([-1.0, 0, 0], zero, np.array([-0.1, 0, 0]))  # the hand moves outwards and has put in no energy
    assert out.status & PASSIVITY
    assert out.F_H_L[0] == 0.0
    assert out.F_passivity[0] == out.F_capped[0] == pytest.approx(-50.0 * DT)
    assert out.lag[2] == pytest.approx(abs(out.F_passivity[0]) / 50.0)
    assert out.lag[3] == pytest.approx((1.0 - 50.0 * DT) / 50.0)


def test_tank_discards_excess_energy_but_the_observer_does_not():
    x = np.concatenate([press(0.005, 1.0), np.zeros(100)])
    held = np.where(np.arange(len(x)) < 500, -2.0, 0.0)  # force only during the motion inwards: 10 mJ are left
    for mode, capacity, expected in (("tank", 0.004, 0.004), ("observer", 0.004, 0.01 + ALLOWANCE)):
        stage = _verify.Stability(options(passivity=mode, tank_capacity=capacity, rate_cap=1e4), DT)
        levels = []
        for k in range(len(x)):
            out = stage.step([held[k], 0, 0], np.array([x[k], 0, 0]), np.zeros(3))
            stage.rendered(out.F_H_L)
            levels.append(stage.stored)
        assert levels[-1] == pytest.approx(expected, rel=0.02)
        if mode == "tank":
            assert max(levels) <= capacity


def test_mode_off_changes_nothing():
    x = press(0.006, 0.2, 4)
    requested = -3000.0 * x
    F, _ = drive(options(passivity="off"), x, requested)
    limiter = _verify.Limiter(options(), DT)
    np.testing.assert_array_equal(F, [limiter.step([w, 0, 0])[0][0] for w in requested])


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf, 1e308])
def test_invalid_numbers_do_not_corrupt_the_filters(number):
    o = options(low_pass=20.0, coupling_stiffness=500.0, coupling_damping=3.0)
    stage = _verify.Stability(o, DT)
    for k in range(60):
        F = [number if k == 20 else -1.0, 0, 0]
        out = stage.step(F, np.array([1e-4 * k, 0, 0]), np.array([0.1, 0, 0]), stiffness=300.0)
        stage.rendered(out.F_H_L)
        assert np.isfinite(out.F_H_L).all()
        assert np.isfinite(out.lag).all()
    assert -0.63 < out.F_H_L[0] < -0.3  # 500 of 800 N/m, and the filters have not settled


def numeric(F, u, a, begin, end, span=0.0):
    t = np.linspace(begin, end, 200001)
    fading = 1.0 - (t - begin) / span if span > 0.0 else 1.0
    return np.trapezoid(F * fading * np.maximum(u + a * t, 0.0), t)


@given(
    F=st.floats(0, 10), u=st.floats(-2, 2), a=st.floats(0.1, 100), begin=st.floats(0, 0.1), span=st.floats(1e-4, 0.1)
)
@settings(max_examples=50, deadline=None)
def test_costs_equal_their_integrals(F, u, a, begin, span):
    held = _verify.held_cost(F, u, a, begin, begin + span)
    assert held == pytest.approx(numeric(F, u, a, begin, begin + span), rel=1e-4, abs=1e-9)
    fade = _verify.fade_cost(F, u, a, begin, span)
    assert fade == pytest.approx(numeric(F, u, a, begin, begin + span, span), rel=1e-4, abs=1e-9)


WRONG = {"delay": 2.0, "acceleration": 0.0, "allowance": -1.0, "tank_capacity": 1e-5, "low_pass": -1.0,
         "coupling_stiffness": -1.0, "coupling_damping": math.nan, "quantum": 0.1, "delay_doubt": -1.0}  # fmt: skip


@pytest.mark.parametrize(("name", "value"), WRONG.items())
def test_invalid_options_are_reported(name, value):
    with pytest.raises(ValueError, match=f"stability.{name}"):
        _verify.Stability(options(passivity="tank", **{name: value}), DT)


def test_unknown_mode_is_reported():
    with pytest.raises(ValueError, match="'observer', 'tank' or 'off'; got 'on'"):
        options(passivity="on")
