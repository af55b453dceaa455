"""The friction that a device states pays for what sampling creates: a certified wall keeps its force under taps.

Simulated: an exact spring and damper as the hand, a mass with dry and viscous friction, taps of 2 N on a wall of 2000
N/m without delay. Nothing is shared with the account of the layer but the force.
"""

from __future__ import annotations

import numpy as np
import pytest

import palpate
from palpate.arm.hands import PRESETS
from palpate.base.errors import DeviceError

K, FORCE, DT, ABOVE = 2000.0, 2.0, 1e-3, 4e-3
MASS, DAMPING, FRICTION = 0.2, 0.6, 0.08


def scene(**stability):
    wall = {"name": "wall", "box": {"size": [0.3, 0.3, 0.1]}, "pose": {"xyz": [0, 0, -0.05]}, "stiffness": K}
    return palpate.Scene.model_validate(
        {
            "objects": [wall | {"damping": 0.0}],
            "contact": {"radius": 0.003},
            "mapping": {"scale": 1.0},
            "arms": {"follower": {"bandwidth": 0}},
            "operator": {"path": [{"t": 0, "xyz": [0, 0, 0.003 + ABOVE]}]},
            "stability": stability,
            "loop_delay": 0.0,
        }
    )


def aim(t, high, low, rate):
    """Position and velocity of the hand's target: minimum jerk to and fro, after .3 s of approach."""
    if t < 0.3:
        return high * t / 0.3, high / 0.3
    turn, s = divmod(2.0 * rate * (t - 0.3), 1.0)
    a, b = (high, low) if turn % 2 == 0 else (low, high)
    return a + (b - a) * s**3 * (10 - 15 * s + 6 * s * s), (b - a) * 30 * s * s * (1 - s) ** 2 * 2.0 * rate


def tapped(hand, rate, stability=None, **stated):
    """Heights (n,) of the handle, and the force (n,) on it."""
    h = PRESETS[hand]
    depth = FORCE / K + FORCE / h.stiffness
    X, z, v, m, dt = np.eye(4), 0.0, 0.0, MASS + h.mass, DT / 10
    at, felt = [], []
    with palpate.Haptics(scene(**stability or {}), rate=1 / DT, **stated) as haptics:
        for k in range(2500):
            X[2, 3] = z
            F = haptics.step(k * DT, X)[2]
            at.append(z)
            felt.append(F)
            for i in range(10):
                p, w = aim(k * DT + i * dt, 0.3 * depth - ABOVE, -ABOVE - depth, rate)
                u = v + dt / m * (F + h.stiffness * (p - z) + h.damping * (w - v) - DAMPING * v)
                v = np.copysign(max(abs(u) - dt / m * FRICTION, 0.0), u)
                z += dt * v
    return np.array(at), np.array(felt)


def taken(at, felt):
    """Share of the contact in which the layer acts, and the mean force over that without the layer on this motion."""
    X, whole = np.eye(4), np.zeros(len(at))
    with palpate.Haptics(scene(passivity="off"), rate=1 / DT) as haptics:
        for k, z in enumerate(at):
            X[2, 3] = z
            whole[k] = haptics.step(k * DT, X)[2]
    touches = whole > 0.01
    return float((whole - felt > 1e-6)[touches].mean()), float(felt[touches].sum() / whole[touches].sum())


STATED = {"resolution": 5e-6, "friction": FRICTION, "damping": DAMPING}


@pytest.mark.parametrize("hand", ["light", "normal", "rigid"])
def test_a_certified_wall_keeps_its_force_on_a_device_that_states_its_friction(hand):
    device = palpate.DeviceModel(mass=MASS, damping=DAMPING, friction=FRICTION)
    assert palpate.certify(device).k_max > 1.5 * K
    share, force = taken(*tapped(hand, 2.5, **STATED))
    assert share <= 0.05
    assert force == pytest.approx(1.0, abs=0.02)


def test_control_without_a_statement_the_layer_takes_force():
    share, force = taken(*tapped("normal", 2.5))
    assert share > 0.1
    assert force < 0.95
    off = taken(*tapped("normal", 2.5, stability={"friction_share": 0.0}, **STATED))
    np.testing.assert_allclose(off, (share, force), rtol=1e-3)


def least_energy(truth, **stated):
    """Least energy [J] put in by a fast motion to and fro at the wall, with true friction [N] and damping [N s/m]."""
    t = DT * np.arange(3000)
    at = -ABOVE * np.minimum(t / 0.3, 1.0) + 1e-3 * np.sin(2 * np.pi * 20.0 * np.maximum(t - 0.3, 0.0))
    X, felt = np.eye(4), np.zeros(len(t))
    with palpate.Haptics(scene(), rate=1 / DT, resolution=1e-6, **stated) as haptics:
        for k, z in enumerate(at):
            X[2, 3] = z
            felt[k] = haptics.step(t[k], X)[2]
    moved = np.diff(at)  # each force is held until the next tick
    return np.cumsum((truth[0] * np.abs(moved) + truth[1] * moved**2 / DT - felt[:-1] * moved)[300:]).min()


def test_the_hand_gets_back_no_more_than_the_allowance_while_the_statement_is_true():
    assert least_energy((0.02, 0.1), friction=0.02, damping=0.1) > -5e-4
    assert least_energy((0.02, 0.1), friction=1.0, damping=5.0) < -5e-3, "control: friction that the device has not"


def test_noise_takes_no_energy():
    """A handle at rest whose position flickers by a count gives no credit, and friction needs the resolution."""
    with pytest.raises(DeviceError, match="only with its resolution"):
        palpate.Haptics(scene(), friction=0.1)
    with pytest.raises(DeviceError, match=r"damping = -1 of the device"):
        palpate.Haptics(scene(), resolution=1e-5, damping=-1.0)
    X, rng, stored = np.eye(4), np.random.default_rng(1), []
    with palpate.Haptics(scene(), rate=1000, resolution=2e-5, friction=1.0, damping=1.0) as haptics:
        for k in range(3000):
            X[2, 3] = 1e-5 * rng.integers(-1, 2)
            haptics.step(k * DT, X)
            stored.append(float(haptics.session.state.tick["energy_stored"]) if k % 100 == 99 else 0.0)
    assert max(stored) <= 5e-4 + 1e-12
