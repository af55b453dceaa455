"""The passivity layer in the cycle: a delayed stiff loop generates no energy; a stable one is unchanged."""

from dataclasses import replace

import numpy as np
import pytest
from loop_rig import HEIGHT, floor, run, simulation

from palpate import _core
from palpate.record.ticks import STATUS
from palpate.scene.rig import build
from palpate.scene.scene import Scene
from palpate.world.surfaces import Box

PASSIVITY = STATUS["passivity"][0]
DELAY, ALLOWANCE = 0.012, 5e-4


def presses(n=4):
    z = [HEIGHT] + [-0.008, HEIGHT] * n
    return _core.HandPath(list(0.1 + 0.35 * np.arange(2 * n + 1)), np.outer(z, [0, 0, 1.0]))


def late(mode):
    o = {
        "loop_delay": DELAY,
        "stability__passivity": mode,
        "stability__delay": DELAY,
        "stability__allowance": ALLOWANCE,
    }
    return run(simulation(floor(K=(1500.0,) * 3), presses(), **o), 3.2)


def test_delayed_stiff_loop_generates_energy_only_without_the_layer():
    off, on = late("off"), late("observer")
    assert off["energy_port"].min() < -5e-3
    assert on["energy_port"].min() >= -ALLOWANCE - 5e-5  # counts of 10 um at 3 N
    assert (on["status"].astype(int) & PASSIVITY).any()
    assert not (off["status"].astype(int) & PASSIVITY).any()


def test_energy_ledger_balances_with_all_elements():
    o = {"stability__low_pass": 30.0, "stability__coupling_stiffness": 900.0, "stability__coupling_damping": 3.0}
    ticks = run(simulation(floor(K=(800.0,) * 3), presses(2), **o), 1.6)
    kept = sum(ticks[f"energy_{name}"] for name in ("port", "cut", "passivity", "low_pass", "coupling"))
    np.testing.assert_allclose(ticks["energy_source"].sum(axis=1), kept, atol=1e-12)
    for name in ("low_pass", "coupling"):
        assert np.abs(ticks[f"energy_{name}"]).max() > 1e-4
    assert ticks["lag_ms"][:, 1].max() == pytest.approx(4.8209, abs=1e-3)
    assert ticks["lag_ms"][:, 0].min() < 0


def test_each_object_has_its_own_energy_account():
    """Two blocks: one is pressed and released, then the other is pressed."""
    material = _core.Material(K=np.full(3, 400.0), B=np.full(3, 4.0), mu=0.0)
    blocks = []
    for name, x in (("left", 0.0), ("right", 0.05)):
        X = np.eye(4)
        X[:3, 3] = x, 0.0, -0.02
        blocks.append(_core.Object(name, Box(np.full(3, 0.04)).core, X, material))
    x, z = [0.0, 0.0, 0.0, 0.05, 0.05], [HEIGHT, -0.005, HEIGHT, HEIGHT, -0.005]
    path = _core.HandPath([0.1, 0.7, 1.3, 1.9, 2.5], np.column_stack([x, np.zeros(5), z]))
    source = run(simulation(_core.Snapshot(blocks), path), 2.7)["energy_source"]
    left, right = source[:, 0], source[:, 1]
    assert left[700] > 1e-3
    assert not right[:1900].any()
    np.testing.assert_array_equal(left[1900:], left[1900])  # the energy dissipated by its damping
    assert right[-1] == pytest.approx(left[700], rel=0.2)
    np.testing.assert_allclose(source[:, 2:], 0.0, atol=1e-12)


def scene(**stability):
    return Scene.model_validate(
        {"objects": [{"plane": {}}], "loop_delay": 0.004, "loop_jitter": 0.002, "stability": stability,
         "arms": {"leader": {"drive_lag": 0.001}}, "operator": {"palpate": {"at": [0, 0, 0]}}}
    )  # fmt: skip


def test_layer_uses_the_options_of_the_scene():
    rig = build(scene())
    o = rig.options()
    assert o.stability.passivity == "observer"
    assert o.stability.delay == pytest.approx(0.006)
    np.testing.assert_allclose(o.stability.friction.coulomb, 0.5 * o.leader.coulomb)
    assert 7.0 < o.stability.acceleration < 11.0  # 3 N on 0.3 kg of a master arm's handle
    assert build(scene(acceleration=2.0)).options().stability.acceleration == 2.0
    assert 5e-6 < o.stability.quantum < 2e-5  # resolution of an MTM at its handle [m]
    assert build(scene(known_delay=0.002)).options().stability.delay == 0.002
    assert not build(scene(friction_share=0.0)).options().stability.friction.coulomb.any()


def test_passivity_layer_does_not_act_in_a_shipped_scene():
    rig, forces = build(Scene.load("scenes/palpation.yaml")), []
    for mode in ("off", "observer"):
        stability = rig.scene.stability.model_copy(update={"passivity": mode})
        other = replace(rig, scene=rig.scene.model_copy(update={"stability": stability}))
        forces.append(run(other.simulation(), 3.5)["F_H_L"])
    assert np.linalg.norm(forces[0], axis=1).max() > 1.0
    np.testing.assert_array_equal(*forces)
