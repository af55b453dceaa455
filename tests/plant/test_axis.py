"""The one-axis simulator against closed forms and an independent numerical integrator."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from palpate import _verify


def options(**values):
    o = _verify.AxisOptions()
    o.damping = 0.0
    for name, value in values.items():
        setattr(o, name, value)
    return o


def axis(**values):
    return _verify.Axis(options(**values))


def reference(o, duration, x0, v0, push=0.0, path=()):
    """Positions at the cycles [m] by an adaptive integrator with stops at reversals; delay below a period or whole."""
    T, n = 1 / o.rate, round(duration * o.rate)
    x, v, seen, v_seen = x0, v0, None, 0.0
    share = 1 - np.exp(-2 * np.pi * o.velocity_cutoff * T) if o.velocity_cutoff > 0 else 1.0
    M, sent, out = o.mass + o.hand_mass, [], []

    def motion(t0, t1, u, direction):
        hand = np.interp([t0, t1], np.arange(len(path)) * T, path) if len(path) else np.zeros(2)
        w = (hand[1] - hand[0]) / (t1 - t0)

        def pull(t, x, v):
            p = hand[0] + w * (t - t0)
            return u + push - o.damping * v + o.hand_stiffness * (p - x) + o.hand_damping * (w - v)

        return pull

    for k in range(n):
        out.append(x)
        now = np.round(x / o.quantum) * o.quantum if o.quantum > 0 else x
        seen = now if seen is None else seen
        v_seen += share * ((now - seen) / T - v_seen)
        seen = now
        F = -(o.K * now + o.B * v_seen)
        if not o.bilateral:
            F = min(F, 0.0) if now > 0 else 0.0
        sent.append((k * T + o.delay, np.clip(F, -o.force_max, o.force_max)))
        arrivals = [t for t, _ in sent if k * T + 1e-12 < t < (k + 1) * T - 1e-12]
        stops = [k * T, *arrivals, (k + 1) * T]
        for t0, t1 in itertools.pairwise(stops):
            acting = [F for t, F in sent if t <= t0 + 1e-12]
            pull = motion(t0, t1, acting[-1] if acting else 0.0, 0)
            t = t0
            while t < t1 - 1e-13:
                direction = np.sign(v)
                if direction == 0:
                    if abs(pull(t, x, 0.0)) <= o.coulomb:
                        held = [s for s in np.linspace(t, t1, 2001) if abs(pull(s, x, 0.0)) <= o.coulomb]
                        t = held[-1] if held[-1] < t1 - 1e-13 else t1
                        if t == t1:
                            continue
                    direction = np.sign(pull(t1, x, 0.0))

                def f(t, y, direction=direction, pull=pull):
                    return [y[1], (pull(t, *y) - direction * o.coulomb) / M]

                def stops_moving(t, y, direction=direction, t_begin=t):
                    return direction * y[1] + (1e-9 if t == t_begin else 0.0)

                stops_moving.terminal, stops_moving.direction = o.coulomb > 0, -1
                s = solve_ivp(f, (t, t1), [x, v], rtol=1e-11, atol=1e-13, events=stops_moving)
                t, (x, v) = s.t[-1], s.y[:, -1]
                v = 0.0 if s.status == 1 else v
    return np.array(out)


LOOPS = {
    "bare": {"K": 500.0},
    "delayed by a part of a period": {"K": 900.0, "delay": 0.0013, "B": 1.0, "velocity_cutoff": 40.0},
    "delayed by whole periods": {"K": 300.0, "delay": 0.01, "bilateral": True, "force_max": 1.0},
    "a hand, whole counts": {"quantum": 2e-4, "hand_mass": 0.2, "hand_damping": 4.0, "hand_stiffness": 200.0, "B": 2.0},
    "dry friction": {"coulomb": 0.15, "K": 800.0, "delay": 0.002, "bilateral": True},
    "dry friction and a hand": {"coulomb": 0.3, "hand_damping": 2.0, "hand_stiffness": 400.0, "delay": 0.0025},
}


@pytest.mark.parametrize("name", LOOPS)
def test_positions_agree_with_an_adaptive_integrator(name):
    o = options(**({"rate": 500.0, "mass": 0.25, "damping": 0.4} | LOOPS[name]))
    path = 4e-3 * np.sin(np.arange(60) * 0.15) if "hand" in name else np.zeros(0)
    start = {"duration": 0.3, "x0": -1e-3, "v0": 0.12, "push": 0.4}
    _, rows = _verify.Axis(o).trace(**start, path=path.tolist())
    assert np.abs(rows[:, 1] - reference(o, **start, path=path)).max() < 2e-8


def test_free_motion_has_its_closed_forms():
    fall, rows = axis(K=0.0, mass=2.0).trace(duration=0.5, push=4.0, x0=-0.9)
    assert rows[:, 1] == pytest.approx(-0.9 + rows[:, 0] ** 2, abs=1e-12)
    _, rows = axis(K=0.0, mass=0.5, damping=3.0).trace(duration=0.5, v0=0.8)
    assert rows[:, 2] == pytest.approx(0.8 * np.exp(-6.0 * rows[:, 0]), abs=1e-12)
    assert not fall.oscillates


@pytest.mark.parametrize("damping", [0.0, 1.0, 30.0])
def test_hand_without_device_is_a_spring_and_damper(damping):
    it = axis(K=0.0, mass=0.3, hand_mass=0.2, hand_stiffness=300.0, hand_damping=damping)
    _, rows = it.trace(duration=0.2, x0=0.01, v0=-0.1)
    A = np.array([[0.0, 1.0], [-300.0 / 0.5, -damping / 0.5]])
    for t, x, v, *_ in rows[::37]:
        assert [x, v] == pytest.approx(expm(A * t) @ [0.01, -0.1], abs=1e-12)


def test_block_slides_for_the_friction_distance():
    _, rows = axis(K=0.0, mass=0.4, coulomb=0.2).trace(duration=1.0, x0=-0.5, v0=0.3)
    assert rows[-1, 1] == pytest.approx(-0.5 + 0.4 * 0.3**2 / (2 * 0.2), abs=1e-13)
    assert rows[-1, 2] == 0.0


def test_dry_friction_reduces_every_half_swing_equally():
    it = axis(K=0.0, mass=0.3, hand_stiffness=270.0, coulomb=0.15)
    _, rows = it.trace(duration=1.0, x0=0.01)
    half = np.pi * np.sqrt(0.3 / 270.0)
    x = np.interp(half * np.arange(9), rows[:, 0], rows[:, 1])
    assert np.abs(x) == pytest.approx(0.01 - 2 * 0.15 / 270.0 * np.arange(9), abs=2e-5)


def test_block_breaks_away_when_the_spring_exceeds_friction():
    speed, k, Fc = 0.02, 250.0, 0.5
    path = speed * 1e-3 * np.arange(1000)
    _, rows = axis(K=0.0, hand_stiffness=k, coulomb=Fc).trace(duration=0.2, path=path.tolist())
    away = rows[:, 0] > Fc / (k * speed)
    assert np.all(rows[~away, 1] == 0.0)
    assert np.all(rows[away, 1][1:] > 0.0)


def test_energy_generated_by_the_wall_becomes_kinetic():
    result, rows = axis(mass=0.3, K=600.0, delay=0.003, rate=700.0).trace(duration=0.3, x0=-0.01, v0=0.2)
    assert rows[:, 4] == pytest.approx(0.5 * 0.3 * (0.2**2 - rows[:, 2] ** 2), abs=1e-12)
    assert result.energy_min < -1e-4  # the mass leaves faster than it came


@pytest.mark.parametrize(("b", "rate"), [(0.5, 1000.0), (5.0, 100.0)])
def test_stability_limit_is_that_of_the_jury_criterion(b, rate):
    m, T = 0.3, 1 / rate
    tau, a = m / b, np.exp(-b * T / m)
    limit = b * (1 - a) / (tau * (1 - a) - a * T)  # z^2 + ... + (a + K/b (tau (1 - a) - a T)): product of the roots 1
    kinds = {"mass": m, "damping": b, "rate": rate, "bilateral": True}
    for fraction, oscillates in ((0.99, False), (1.01, True)):
        assert axis(**kinds, K=fraction * limit).run(duration=8.0, v0=0.05).oscillates == oscillates


def test_same_seed_gives_the_same_run_and_delay_is_applied():
    runs = [axis(K=900.0, delay=0.001, jitter=0.004, seed=s, damping=0.2) for s in (1, 1, 2)]
    a, b, c = (it.run(v0=0.1).energy_port for it in runs)
    assert a == b != c
    early, late = (axis(K=600.0, delay=d, damping=0.8).run(v0=0.1).energy_min for d in (0.0, 0.004))
    assert late < early


def test_peak_rest_overshoot_and_settling_of_a_press_have_closed_forms():
    result = axis(K=400.0, damping=1.0, mass=0.3).run(duration=20.0, push=2.0)
    w, zeta = np.sqrt(400 / 0.3), 0.5 * 1.0 / np.sqrt(400 * 0.3)
    assert result.rest == pytest.approx(2.0 / 400.0, rel=1e-3)
    sampled = zeta - w * 5e-4 / 2  # half a period of delay reduces the damping by K T / 2
    assert result.overshoot == pytest.approx(np.exp(-np.pi * sampled), rel=0.02)
    assert result.settling == pytest.approx(np.log(50) / (w * sampled), rel=0.05)
    assert result.frequency == 0.0 or not result.oscillates


def test_mistakes_are_reported():
    with pytest.raises(ValueError, match=r"axis mass = 0\.0+: must be above 0 kg"):
        axis(mass=0.0)
    with pytest.raises(ValueError, match="neither may be below zero"):
        axis(delay=0.6, jitter=0.6)
    with pytest.raises(ValueError, match="hand_stiffness"):
        axis(hand_stiffness=1e-6)
    with pytest.raises(ValueError, match="duration"):
        axis().run(duration=0.0)
