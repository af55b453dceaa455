"""The energy that a hand puts into `palpate.Haptics`, by its own quadrature: force that acted times motion."""

from __future__ import annotations

from collections import deque

import numpy as np
import pytest

import palpate
from palpate.scene.guidance import Fixture, Sphere

ALLOWANCE, CREDIT = 5e-4, 0.03
FLOOR = {"name": "floor", "plane": {}, "stiffness": 1200.0}
FAR = {"name": "far", "sphere": {"radius": 0.005}, "pose": {"xyz": [0.06, 0.0, 0.0]}, "stiffness": 200.0}


def scene(objects, height=0.012, **more):
    return palpate.Scene.model_validate(
        {"objects": objects, "contact": {"radius": 0.002}, "mapping": {"scale": 1.0},
         "arms": {"follower": {"bandwidth": 0.0}}, "operator": {"path": [{"t": 0.0, "xyz": [0, 0, height]}]}, **more}
    )  # fmt: skip


def ease(s):
    s = np.clip(s, 0.0, 1.0)
    return s**3 * (10 - 15 * s + 6 * s * s)


def presses(n, period, depth, dt, gap=0.01):
    """Heights above the start [m] at calls dt apart: n presses of `depth`, from `gap` above the floor and back."""
    phase = np.arange(0.0, n * period, dt) % period / period
    return -(gap + depth) * (ease(phase / 0.4) - ease((phase - 0.5) / 0.4))


def put_in(haptics, z, dt, said=None, late=0, called=None, clutch=None, each=None):
    """Lowest energy that the hand has put in [J], and the forces (n,) [N].

    z: heights [m] at the times k dt; said: period that the caller states [s]; late: calls after which a force acts;
    called: False where a call is lost; clutch: True where its button is pressed; each: called with k before each step.
    """
    X, energy, lowest, F, acting, line, felt = np.eye(4), 0.0, 0.0, 0.0, 0.0, deque([0.0] * late), []
    for k in range(len(z)):
        X[2, 3] = z[k] - z[0]
        if k > 0:
            energy -= acting * (z[k] - z[k - 1])
            lowest = min(lowest, energy)
        if each is not None:
            each(k)
        if called is None or called[k]:
            F = haptics.step(k * (said or dt), X, buttons=0 if clutch is None else int(clutch[k]))[2]
        line.append(F)
        acting = line.popleft()
        felt.append(F)
    return lowest, np.array(felt)


LOOPS = {
    "as said": {"dt": 1e-3}, "500 Hz": {"dt": 2e-3}, "410 Hz": {"dt": 1 / 410}, "2200 Hz": {"dt": 1 / 2200},
    "clock at half speed": {"dt": 1e-3, "said": 5e-4}, "clock at half speed, 500 Hz": {"dt": 2e-3, "said": 1e-3},
    "delay of 1 ms": {"dt": 1e-3, "late": 1}, "delay of 3 ms": {"dt": 1e-3, "late": 3},
}  # fmt: skip


@pytest.mark.parametrize("name", LOOPS)
@pytest.mark.parametrize("period", [0.5, 1.3])
def test_no_loop_feeds_the_hand(name, period):
    """rate=1000 is said; loop and delay are other. Twelve presses without friction."""
    haptics = palpate.Haptics(scene([FLOOR]), rate=1000.0)
    lowest, felt = put_in(haptics, presses(12, period, 0.0014, LOOPS[name]["dt"]), **LOOPS[name])
    haptics.close()
    assert felt.max() > 0.95 * 1200.0 * 0.0014
    assert lowest >= -ALLOWANCE - 1e-6


def test_lost_calls_do_not_feed_the_hand():
    z, rng = presses(20, 0.6, 0.0014, 1e-3), np.random.default_rng(4)
    called = (rng.uniform(size=len(z)) < 0.7) | (np.arange(len(z)) < 100)
    with palpate.Haptics(scene([FLOOR]), rate=1000.0) as haptics:
        lowest, felt = put_in(haptics, z, 1e-3, called=called)
    assert felt.max() > 0.9 * 1200.0 * 0.0014
    assert lowest >= -ALLOWANCE - 1e-4


def test_a_stated_delay_is_exact_and_a_wrong_statement_is_found():
    """The judge finds a delay that the caller denies, and a stated one costs less force than a doubted one."""
    z, lowest = presses(12, 0.5, 0.0014, 1e-3), {}
    for stated in (0.0, 0.003):
        with palpate.Haptics(scene([FLOOR]), rate=1000.0, delay=stated) as haptics:
            lowest[stated], _ = put_in(haptics, z, 1e-3, late=3)
    assert lowest[0.003] >= -ALLOWANCE - 1e-6
    assert lowest[0.0] < -2.0 * ALLOWANCE


def test_a_wall_without_delay_is_felt_as_it_is():
    """A stated delay of zero and presses as of a careful finger: the layer acts in a few percent of the contact."""
    z = presses(8, 1.2, 0.0009, 1e-3)
    stiff = scene([{**FLOOR, "stiffness": 2000.0}])
    with palpate.Haptics(stiff, rate=1000.0, delay=0.0) as haptics:
        lowest, felt = put_in(haptics, z, 1e-3)
        summary = haptics.close()
    assert lowest >= -ALLOWANCE - 1e-6
    assert summary.passivity_s <= 0.05 * summary.contact_s
    assert felt.max() == pytest.approx(1.8, rel=0.02)


def test_fixtures_that_engage_by_distance_pay_nothing():
    """A hand approaches before the fixture engages and leaves before it releases, forty times."""
    law = {"name": "potential", "stiffness": 250.0, "force": 2.5, "range": 0.012, "damping": 0.0}
    fixture = {
        "geometry": {"sphere": {"radius": 0.02}},
        "role": "forbid",
        "law": law,
        "engage": 0.005,
        "release": 0.013,
    }
    phase = np.arange(0.0, 40 * 1.1, 1e-3) % 1.1 / 1.1
    z = 0.037 - 0.0128 * (ease(phase / 0.3) - ease((phase - 0.55) / 0.3))
    z = np.concatenate([np.linspace(0.05, z[0], 500), z])
    with palpate.Haptics(scene([FAR], 0.05, guidance=[fixture]), rate=1000.0) as haptics:
        lowest, felt = put_in(haptics, z, 1e-3)
        summary = haptics.close()
    assert felt.max() > 0.1
    assert summary.energy_lent_J == 0.0
    assert lowest >= -ALLOWANCE - 1e-6


@pytest.mark.parametrize("how", ["pedal", "list"])
def test_switched_fixtures_pay_their_credit_once(how):
    """A spring pulls towards a point; it is switched on far from the point and off near it, thirty times."""
    law = {"name": "spring", "stiffness": 300.0, "damping": 0.0}
    spring = Fixture(Sphere(radius=0.0005, at=(0.0, 0.0, 0.0)), role="guide", law=law)
    n, period = 30, 1.0
    phase = np.arange(0.0, n * period, 1e-3) % period / period
    z = -0.011 + 0.009 * np.cos(2 * np.pi * phase)  # away at the beginning of a period, near the point at its middle
    z = z - z[0]
    haptics = palpate.Haptics(scene([FAR], 0.012), rate=1000.0)
    if how == "pedal":
        haptics.session.fixtures = [spring]

    def switch(k):
        on = phase[k] < 0.5
        if k % 10 == 0 and how == "pedal":
            haptics.session.change(guidance=1.0 if on else 0.0)
        elif how == "list" and (k == 0 or (phase[k - 1] < 0.5) != on):
            haptics.session.fixtures = [spring] if on else []

    lowest, felt = put_in(haptics, z, 1e-3, each=switch)
    summary = haptics.close()
    assert np.abs(felt).max() > 0.3
    assert 0.0 < summary.energy_lent_J <= CREDIT + 1e-12
    assert lowest >= -ALLOWANCE - CREDIT - 1e-6


def test_clutches_do_not_renew_the_allowance():
    """A hand that takes what it can get clutches in free space after each press, forty times."""
    z = presses(40, 0.7, 0.0015, 1e-3)
    at = np.arange(len(z))
    clutch = (at % 700 > 640) & (at > 700)  # it rests there, so the tool does not move against the hand
    with palpate.Haptics(scene([{**FLOOR, "stiffness": 2400.0}]), rate=1000.0, delay=0.0) as haptics:
        lowest, felt = put_in(haptics, z, 1e-3, clutch=clutch)
    assert felt[-700:].max() > 1.0
    assert lowest >= -ALLOWANCE - 1e-6


def test_a_loop_faster_than_real_time_counts_every_step():
    """Without a record, ten seconds are stepped at once: no step is missing, and the energy is that of the last one."""
    z = presses(10, 1.0, 0.001, 1e-3)
    haptics = palpate.Haptics(scene([FLOOR]), rate=1000.0, delay=0.0)
    X, energy, F = np.eye(4), 0.0, 0.0
    for k in range(len(z)):
        if k > 0:
            energy -= F * (z[k] - z[k - 1])
        X[2, 3] = z[k] - z[0]
        F = haptics.step(1e-3 * k, X)[2]
    summary = haptics.close()
    assert summary.faults == ()
    assert summary.ticks == len(z)
    assert summary.energy_J == pytest.approx(energy, abs=1e-9)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_a_pushed_hand_feels_its_share(share):
    """A floor that breathes pushes a hand at rest: the work that the hand receives is paid by the floor's motion."""
    motion = [{"amplitude": [0.0, 0.0, 0.004], "period": 1.25}]
    floor = {**FLOOR, "stiffness": 400.0, "motion": motion}
    X, felt, z = np.eye(4), [], []
    with palpate.Haptics(scene([floor], 0.003, stability={"moving_share": share}), rate=1000.0, delay=0.0) as haptics:
        for k in range(4000):
            X[2, 3] = 0.0008 * np.sin(2 * np.pi * 0.8e-3 * k + 0.6)  # a hand that gives way, out of phase
            felt.append(haptics.step(1e-3 * k, X)[2])
            z.append(X[2, 3])
    got = np.cumsum(np.array(felt)[:-1] * np.diff(z)).max()
    if share == 0.0:
        assert got <= ALLOWANCE + 1e-6
    elif share == 1.0:
        with palpate.Haptics(scene([floor], 0.003, stability={"passivity": "off"}), rate=1000.0) as haptics:
            free = []
            for k in range(4000):
                X[2, 3] = 0.0008 * np.sin(2 * np.pi * 0.8e-3 * k + 0.6)
                free.append(haptics.step(1e-3 * k, X)[2])
        assert max(free) > 0.5
        np.testing.assert_allclose(felt, free, atol=0.02)
