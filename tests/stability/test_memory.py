"""The account forgets energy put in long ago, and takes nothing from springs that return what they took."""

from __future__ import annotations

import math

import numpy as np
import pytest
from effort import examples
from hypothesis import example, given, settings
from hypothesis import strategies as st

from palpate import _core, _verify

DT = 1e-3
UNKNOWN = math.inf


class Port:
    """The stage `stability` on one axis, with the true energy that the hand has put in."""

    def __init__(self, delay=0.0, **changes):
        o = _core.StabilityOptions()
        o.delay = delay
        for name, value in changes.items():
            setattr(o, name, value)
        self.stage = _verify.Stability(o, DT)
        self.line, self.x, self.energy = [0.0] * round(delay / DT), None, 0.0

    def step(self, x, v, requested, potential=UNKNOWN, stiffness=0.0):
        """The force that acts until the next tick [N]."""
        if self.x is not None:
            self.energy -= self.acting * (x - self.x)
        out = self.stage.step([requested, 0, 0], np.array([x, 0, 0]), np.array([v, 0, 0]), potential=potential,
                              stiffness=stiffness)  # fmt: skip
        self.stage.rendered(out.F_H_L)
        self.sent = out.F_H_L[0]
        self.x, self.acting = x, [*self.line, self.sent][0]
        self.line = [*self.line, self.sent][1:]
        return self.acting


def strokes(port, cycles, potential=0.0):
    """Strokes of 20 mm against dry friction of 2 N, beside the wall: 40 mJ each way; and a rest where they began.

    The number of cycles is whole: a hand that jumped to its rest would take back what it put in.
    """
    for k in range(int(cycles) * round(1 / DT)):
        phase = 2 * math.pi * k * DT
        v = 0.02 * math.pi * math.sin(phase)
        port.step(-0.022 + 0.01 * (1 - math.cos(phase)), v, -2.0 * math.tanh(v / 0.002), potential)
    for _ in range(100):
        port.step(-0.022, 0.0, 0.0, potential)


def oscillate(port, known, K=1500.0, seconds=8.0):
    """Largest energy that a hand on a stiff wall with an unmitigated delay gets back [J].

    The hand is a mass of 1.2 kg on a soft spring whose rest position is inside the wall: it accelerates by less than
    the assumed 5 m/s^2.
    """
    x, v, start, lowest, substeps = port.x, 0.0, port.energy, 0.0, 10
    for _ in range(round(seconds / DT)):
        F = port.step(x, v, -K * max(x, 0.0), 0.5 * K * max(x, 0.0) ** 2 if known else UNKNOWN)
        lowest = min(lowest, port.energy - start)
        for _ in range(substeps):
            v += (F + 80.0 * (0.004 - x) - 1.0 * v) / 1.2 * DT / substeps
            x += v * DT / substeps
    return -lowest


def test_energy_put_in_long_ago_feeds_no_oscillation():
    """After 0.5 J of work the hand gets back the reserve at most; without a limit it gets most of the work."""
    got = {}
    for known in (True, False):
        port = Port(delay=0.01)
        strokes(port, 8, 0.0 if known else UNKNOWN)
        assert port.energy > 0.5
        got[known] = oscillate(port, known)
    reserve = port.stage.reserve
    assert got[True] <= reserve + 1e-6
    assert got[False] > 4 * reserve


def speeds_of(distance, speed, a):
    """Speeds of a motion over a distance that starts and ends at rest with the acceleration a."""
    speed = min(speed, math.sqrt(a * distance))
    n = max(round((distance / speed + speed / a) / DT), 4)
    t = (np.arange(n) + 0.5) / n
    ramp = min(speed / a / (n * DT), 0.5)
    v = np.clip(np.minimum(t, 1 - t) / ramp, 0.0, 1.0)
    return v * distance / (v.sum() * DT)


@settings(max_examples=examples(60), deadline=None)
@given(K=st.floats(50, 5000), extra=st.floats(0, 5), press=st.floats(0.05, 0.9),
       releases=st.lists(st.floats(0.001, 0.28), min_size=1, max_size=4), share=st.floats(0.1, 0.95))  # fmt: skip
@example(K=909.0, extra=0.0, press=0.5, releases=[0.25], share=0.5)
def test_limit_takes_no_force_from_an_honest_spring(K, extra, press, releases, share):
    """After long work, slow presses and releases at any speed: bit for bit the force of an account without a limit."""
    B = K * DT / 2 + extra  # passive: b + B >= K T / 2 (Colgate and Brown 1994)
    depth = share * 3.0 / K
    slow = min(press * 50.0 / K, 0.28)  # no rate cap acts on the way in
    forces = {}
    for known in (True, False):
        port, felt = Port(), []
        for release in releases:
            strokes(port, 1)
            for v in (speeds_of(0.022 + depth, slow, 2.0), -speeds_of(0.022 + depth, release, 4.0)):
                x0 = -0.022 if v.sum() > 0 else depth
                x = x0 + np.concatenate([[0.0], np.cumsum(v)]) * DT
                for k in range(len(v)):
                    wanted = -max(K * x[k] + B * v[k - 1 if k else 0], 0.0) if x[k] > 0 else 0.0
                    felt.append(port.step(x[k], v[k - 1] if k else 0.0, wanted,
                                          0.5 * K * max(x[k], 0.0) ** 2 if known else UNKNOWN, K))  # fmt: skip
        forces[known] = felt
    assert max(np.abs(forces[False])) > 0.5 * share * 3.0
    assert forces[True] == forces[False]


def test_reserve_pays_for_the_removal_of_every_wrench_within_the_caps():
    o = _core.StabilityOptions()
    o.delay, o.low_pass = 0.004, 40.0
    stage = _verify.Stability(o, DT)
    lag = (1.0 - _core.low_pass_share(o.low_pass, DT)) / _core.low_pass_share(o.low_pass, DT) * DT
    until = o.delay + lag + DT
    cost = o.allowance
    for F, u, a in ((o.force_cap, o.speed, o.acceleration), (o.moment_cap, o.angular_speed, o.angular_acceleration)):
        t = np.linspace(0.0, until + _verify.FADE, 200001)
        force = np.where(t < until, F, F * (1.0 - (t - until) / _verify.FADE))
        cost += np.trapezoid(force * (u + a * DT / 2 + a * t), t)
    assert stage.reserve == pytest.approx(cost, rel=1e-4)


@pytest.mark.parametrize("potential", [0.0, 0.02, math.nan])
def test_account_is_limited_to_potential_and_reserve(potential):
    port = Port()
    strokes(port, 1, UNKNOWN)
    before, limit = port.stage.stored, potential + port.stage.reserve
    assert before > 0.07
    port.step(port.x, 0.0, 0.0, potential)
    assert port.stage.stored == pytest.approx(before if math.isnan(potential) else limit, rel=1e-12)


@pytest.mark.parametrize("K", [100.0, 500.0, 3000.0])
def test_object_that_disappears_for_a_moment_is_released_as_before(K):
    """While the tool presses an object, it is taken away and put back; the release is that of an unlimited account."""
    depth = 2.5 / K
    v = np.concatenate([speeds_of(depth, 0.02, 2.0), np.zeros(600), -speeds_of(depth, 0.05, 2.0)])
    x = np.concatenate([[0.0], np.cumsum(v)]) * DT
    arrived = int(np.argmax(x >= depth * (1 - 1e-9)))
    forces = {}
    for known in (True, False):
        port, felt = Port(), []
        strokes(port, 2, 0.0 if known else UNKNOWN)
        for k in range(len(v)):
            gone = arrived + 200 <= k < arrived + 300
            stored = 0.0 if gone else 0.5 * K * max(x[k], 0.0) ** 2
            wanted = 0.0 if gone else -K * max(x[k], 0.0)
            felt.append(port.step(x[k], v[k - 1] if k else 0.0, wanted, stored if known else UNKNOWN, K))
        forces[known] = felt
    assert min(np.abs(forces[False][arrived + 280 : arrived + 300])) == 0.0
    assert max(np.abs(forces[False][arrived + 400 :])) == pytest.approx(2.5, rel=1e-6)
    assert forces[True] == forces[False]
