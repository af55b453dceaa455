"""The account over a whole session: sums are bounded, whatever is switched, clutched, lost or late.

The judge is its own quadrature of the force that acted times the motion, at the hand.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core, _verify

DT, ALLOWANCE, CAPACITY, A = 1e-3, 5e-4, 0.03, 5.0


class Hand:
    """A prescribed hand on the stage `stability`, and the energy that it has put in [J]."""

    def __init__(self, delay=0.0, **changes):
        o = _core.StabilityOptions()
        for name, value in changes.items():
            setattr(o, name, value)
        self.stage, self.delay = _verify.Stability(o, DT), delay
        self.t, self.x, self.energy, self.lowest, self.sent = 0.0, 0.0, 0.0, 0.0, [(-1.0, 0.0)]

    def step(self, x, dt, wanted, **inputs):
        """Move to x [m] within dt [s], at constant speed; the wanted force is that of the new position [N]."""
        begin, end = self.t, self.t + dt
        times = [begin, *[s + self.delay for s, _ in self.sent if begin < s + self.delay < end], end]
        for a, b in itertools.pairwise(times):
            F = [f for s, f in self.sent if s + self.delay <= 0.5 * (a + b)][-1]
            self.energy -= F * (x - self.x) * (b - a) / dt
            self.lowest = min(self.lowest, self.energy)
        v = (x - self.x) / dt
        self.t, self.x = end, x
        out = self.stage.step([wanted, 0, 0], np.array([x, 0, 0]), np.array([v, 0, 0]), dt=dt, **inputs)
        self.stage.rendered(out.F_H_L)
        self.sent = [*self.sent, (end, out.F_H_L[0])][-60:]
        return out.F_H_L[0]


def motion(rng, seconds, dts):
    """Positions [m] at the ends of periods dts [s] whose acceleration stays below the bound."""
    fine = 1e-4
    a = np.repeat(rng.uniform(-0.9, 0.9, int(seconds / 0.02) + 1), int(0.02 / fine)) * A
    v = np.cumsum(a) * fine
    x = np.cumsum(v - 2.0 * np.cumsum(np.cumsum(v) * fine * fine)) * fine  # drifts back
    return np.interp(np.cumsum(dts), np.arange(len(x)) * fine, x)


@settings(max_examples=examples(10), deadline=None)
@given(seed=st.integers(0, 10**6), K=st.floats(100, 4000))
def test_switches_and_clutches_are_bounded_in_all(seed, K):
    """Random toggles of a potential and random clutches for 8 s: never more than allowance and credit."""
    rng = np.random.default_rng(seed)
    dts = np.full(8_000, DT)
    x = motion(rng, 8.0, dts)
    hand, on, engaged = Hand(), False, True
    for k in range(len(x)):
        credit = 0.0
        if rng.uniform() < 0.005:
            on = not on
            credit = 0.5 * K * min(x[k] ** 2, (3.0 / K) ** 2) if on else 0.0
        engaged = engaged != (rng.uniform() < 0.003)
        hand.step(x[k], DT, -K * x[k] if on else 0.0, credit=credit, engaged=bool(engaged), stiffness=K,
                  potential=0.5 * K * x[k] ** 2 if on else 0.0)  # fmt: skip
        assert hand.stage.credited <= CAPACITY + 1e-12
    assert hand.lowest >= -ALLOWANCE - CAPACITY - 1e-9


def test_credit_is_repaid_only_by_energy_that_the_hand_put_in():
    hand = Hand()
    hand.step(0.0, DT, 0.0, credit=0.02, potential=0.02)
    assert hand.stage.credited == pytest.approx(0.02)
    hand.step(0.0, DT, 0.0, credit=0.02, potential=0.04)
    assert hand.stage.credited == pytest.approx(CAPACITY)
    for k in range(1, 2001):  # against a friction of 2 N: 40 mJ
        hand.step(1e-5 * k, DT, -2.0, potential=0.0)
    repaid = CAPACITY - hand.stage.credited
    assert 0.02 < repaid <= hand.energy


@pytest.mark.parametrize("ratio", [0.4, 0.5, 1.0, 2.0, 2.5])
@pytest.mark.parametrize("lost", [0.0, 0.3])
@pytest.mark.parametrize("delay", [0.0, 0.0037])
def test_slow_and_uneven_loops(ratio, lost, delay):
    """Periods of 0.4 to 2.5 times the nominal one, also with lost calls: a force acts until the next one does."""
    rng = np.random.default_rng(round(100 * ratio + 10 * lost))
    for K in (500.0, 2000.0):
        dts = ratio * DT * (1 + rng.geometric(1 - lost, 4000) - 1)
        t = np.cumsum(dts)
        x = 0.004 * np.sin(2 * np.pi * 1.3 * t) - 0.002
        hand = Hand(delay, rate_cap=1e3)
        hand.stage = _verify.Stability(_options(delay), DT)
        for k in range(len(x)):
            hand.step(x[k], dts[k], -K * max(x[k], 0.0), stiffness=K, potential=0.5 * K * max(x[k], 0.0) ** 2)
        # A gap longer than all before is not foreseen; later ones are.
        longest = dts.max()
        assert hand.lowest >= -ALLOWANCE - (3.0 * 0.033 * longest if lost else 1e-9)


def _options(delay, **changes):
    o = _core.StabilityOptions()
    o.delay = delay
    for name, value in changes.items():
        setattr(o, name, value)
    return o


@pytest.mark.parametrize("true", [0.0, 0.001, 0.0024, 0.003])
def test_a_doubted_delay_is_paid_for(true):
    """The layer knows only that the delay is at most 3 ms; strokes at 40 mm/s and wall of 1000 N/m."""
    hand = Hand(true)
    hand.stage = _verify.Stability(_options(0.0, delay_doubt=0.003), DT)
    sure = Hand(true)
    sure.stage = _verify.Stability(_options(0.0), DT)
    t = np.arange(0, 4, DT)
    x = 0.002 * np.sin(2 * np.pi * 3 * t) - 0.001
    for k in range(len(x)):
        for one in (hand, sure):
            one.step(x[k], DT, -1000.0 * max(x[k], 0.0), stiffness=1000.0, potential=500.0 * max(x[k], 0.0) ** 2)
    assert hand.lowest >= -ALLOWANCE - 1e-9
    if true > 0.0:
        assert sure.lowest < -ALLOWANCE - 2e-4  # the judge finds the delay that nobody stated


def test_a_deficit_is_repaid_by_work_and_never_forgiven():
    """A handle snatched away leaves a deficit; a clutch does not forgive it, presses repay it."""
    K, hand = 800.0, Hand()
    wall = {"stiffness": K}

    def go(path, engaged=True):
        return [hand.step(x, DT, -K * max(x, 0.0) if engaged else 0.0, engaged=engaged,
                          potential=0.5 * K * max(x, 0.0) ** 2, **wall) for x in path]  # fmt: skip

    go(np.linspace(-0.001, 0.003, 400))
    go([0.003] * 200)
    hand.stage.rendered([-2.4, 0, 0])  # a device that does not obey: the force acts on
    hand.sent[-1] = (hand.t, -2.4)
    go([-0.002])
    deficit = hand.stage.stored
    assert deficit < -1e-3
    go([-0.002] * 300, engaged=False)
    assert hand.stage.stored == deficit
    moving, resting = [], []
    for _ in range(12):
        moving.append(-min(go(np.linspace(-0.002, 0.002, 50))))
        resting.append(-go([0.002] * 100)[-1])
        go(np.linspace(0.002, -0.002, 400))
    assert moving[0] > 0.5  # it resists a fast motion ...
    assert resting[0] == 0.0  # ... and lets go when the hand rests, until the deficit is repaid
    assert resting[-1] == pytest.approx(K * 0.002)
    assert hand.lowest == pytest.approx(deficit - ALLOWANCE)


def test_force_falls_with_its_spring_and_rises_at_the_rate_cap():
    """The limiter does not hold up a force whose fall the motion explains; a stiff wall returns what it stored."""
    K, v = 3000.0, 0.2
    limiter = _verify.Limiter(_core.StabilityOptions(), DT)
    F = np.array([limiter.step([-2.0, 0, 0])[0][0] for _ in range(60)])
    assert np.diff(F, prepend=0.0).min() >= -0.05 - 1e-12
    assert F[-1] == -2.0
    x = 2.0 / K - v * DT * np.arange(1, 6)
    fallen = [limiter.step([-K * max(one, 0.0), 0, 0], explained=K * v * DT)[0][0] for one in x]
    np.testing.assert_allclose(fallen, [-K * max(one, 0.0) for one in x], atol=1e-12)
    limiter.step([-2.0, 0, 0])
    assert limiter.step([0.0, 0, 0], explained=0.0)[0][0] == 0.0  # 0.05 N are within one step of the rate cap
