"""What a device can know: counted positions, a delay in fractions of a period, its own friction."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core

DT, ALLOWANCE = 1e-3, 5e-4


def observe(x, F, v=None, **options):
    """What the observer says was taken from the hand, one point on a line."""
    o = _core.StabilityOptions()
    for name, value in options.items():
        setattr(o, name, value)
    observer = _core.PassivityObserver(o, DT)
    v = np.gradient(x, DT) if v is None else v
    told = [observer.step(np.array([a, 0, 0]), np.array([b, 0, 0]), np.array([c, 0, 0]))
            for a, b, c in zip(x, v, F, strict=True)]  # fmt: skip
    return np.array(told) - ALLOWANCE


def test_a_sampled_wall_makes_half_K_dx2_on_the_way_in_and_on_the_way_out():
    """Closed form: a spring held for a period T at speed v is off by K (v T)^2 / 2 in each of them (Colgate 1994)."""
    K, step, n = 1000.0, 5e-5, 80
    x = step * np.concatenate([np.arange(n + 1), np.arange(n - 1, -1, -1)])
    told = observe(x, -K * x)
    assert told[n] == pytest.approx(0.5 * K * x.max() ** 2 - n * K * step**2 / 2)
    assert told[-1] == pytest.approx(-2 * n * K * step**2 / 2)


@pytest.mark.parametrize("speed", [1e-4, 1e-3, 5e-3, 0.02, 0.1, 0.3])
@pytest.mark.parametrize("quantum", [1e-5, 1e-4])
def test_counts_lead_to_no_false_alarm_and_hide_nothing(speed, quantum):
    """Presses of a quantised wall, slow and fast: the sum stays at the true one, it does not drift with the counts."""
    K, depth, presses = 1000.0, 3e-3, 4
    t = np.arange(0, presses * 2 * depth / speed, DT)
    x = depth * (1 - np.abs((t * speed / depth) % 2 - 1)) * (1 + 1e-3 * np.sin(1.7 * t)) + 0.37 * quantum
    counted = quantum * np.round(x / quantum)
    F = -K * np.maximum(counted, 0.0)
    true = np.sum(-F[:-1] * np.diff(x))
    told = observe(counted, F, np.gradient(x, DT), quantum=quantum)[-1]
    plain = observe(counted, F)[-1]
    most = K * depth  # largest force
    edge = 2 * most * quantum  # one count at full force, at the beginning and at the end
    assert abs(told - true) <= edge + 0.25 * quantum * presses * 2 * most
    if speed * DT < 0.2 * quantum:  # slow: a plain sum over counts loses K quantum^2 / 2 per count
        assert plain - true == pytest.approx(-0.5 * K * quantum**2 * presses * 2 * depth / quantum, rel=0.15)
        assert abs(told - true) < 0.2 * abs(plain - true)


@settings(max_examples=60, deadline=None)
@given(fifties=st.integers(0, 1500), seed=st.integers(0, 1000))
def test_with_a_delay_the_force_that_acts_is_booked(fifties, seed):
    """Truth: a piecewise constant force, shifted by any delay, along a motion finer than the period."""
    rng = np.random.default_rng(seed)
    n, fine = 300, 50
    delay = fifties * DT / fine
    t = np.arange(n * fine) * DT / fine
    x = sum(1e-3 * rng.normal() * np.sin(w * t + rng.uniform(0, 6)) for w in (3.0, 8.0, 21.0))
    F = 2.0 * np.sin(20.0 * DT * np.arange(n) + rng.uniform(0, 6))
    sent = np.floor((t - delay) * 1000.0 + 1e-9).astype(int)
    acting = np.where(sent >= 0, F[np.clip(sent, 0, n - 1)], 0.0)
    true = np.concatenate([[0], np.cumsum(-acting[:-1] * np.diff(x))])[::fine]
    told = observe(x[::fine], F, delay=delay)
    # within a period the force changes by 0.04 N and the speed by 0.4 mm/s: what is left is their product
    np.testing.assert_allclose(told, true, atol=3e-6)


def test_what_is_in_flight_is_reserved_until_it_has_acted():
    o = _core.StabilityOptions()
    o.delay = 0.005
    observer = _core.PassivityObserver(o, DT)
    costs = []
    for k in range(8):
        F = 1.0 if k == 0 else 0.0
        observer.step(np.zeros(3), np.array([0.2, 0, 0]), np.array([F, 0, 0]))
        costs.append(observer.in_flight)
    # sent at k = 0, it acts for a millisecond 5 ms later: 0.2 m/s and 5 m/s^2 until then; it comes nearer, it is gone
    assert costs[0] == pytest.approx(_core.held_cost(1.0, 0.2 + 0.5 * 5.0 * DT, 5.0, 0.004, 0.005))
    assert costs[4] == pytest.approx(_core.held_cost(1.0, 0.2 + 0.5 * 5.0 * DT, 5.0, 0.0, 0.001))
    assert costs[5:] == [0.0, 0.0, 0.0]


def dissipation(coulomb, viscous, quantum):
    f = _core.CertainFriction()
    f.coulomb, f.viscous, f.quantum = np.array([coulomb]), np.array([viscous]), np.array([quantum])
    return _core.Dissipation(f, DT)


@settings(max_examples=80, deadline=None)
@given(seed=st.integers(0, 10_000), quantum=st.sampled_from([0.0, 1e-5, 2e-4, 3e-3]), size=st.floats(1e-6, 0.05))
def test_friction_is_never_overestimated(seed, quantum, size):
    rng = np.random.default_rng(seed)
    n, fine = 400, 20
    t = np.arange(n * fine) * DT / fine
    x = sum(size * rng.normal() * np.sin(w * t + rng.uniform(0, 6)) for w in (2.0, 9.0, 30.0, 90.0))
    moved = np.abs(np.diff(x))
    true = 0.3 * moved.sum() + 2.0 * (moved**2).sum() / (DT / fine)
    model = dissipation(0.3, 2.0, quantum)
    counts = x[::fine] if quantum == 0.0 else quantum * np.round(x[::fine] / quantum)
    told = sum(model.step(np.array([q])) for q in counts)
    assert told <= true * (1 + 1e-9) + 1e-15
    if quantum < 0.05 * np.ptp(x):
        assert told > 0.4 * true  # and what is certain is most of it


def test_a_flickering_encoder_earns_nothing():
    model = dissipation(0.3, 2.0, 1e-4)
    assert sum(model.step(np.array([q])) for q in [0.0, 1e-4] * 500) <= 1e-20
