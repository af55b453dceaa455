"""What the passivity layer assumes of a device is decided in one place, for simulated arms, devices and ROS 2."""

from __future__ import annotations

import numpy as np
import pytest

from palpate import _core
from palpate.arm.hands import PRESETS
from palpate.base.errors import SceneError
from palpate.devices.handle import AtHandle
from palpate.devices.loop import DELAY_DOUBT, device_options, device_port, device_scene
from palpate.record.ticks import as_ticks
from palpate.scene import Scene, shaping
from palpate.scene.port import Port, apply
from palpate.scene.rig import build
from palpate.scene.shaping import least_mass

LINES = "objects: [{name: ball, sphere: {radius: 0.02}}]\n"


def options(text=""):
    return build(Scene.parse(LINES + text)).options().stability


def test_a_law_that_hides_friction_leaves_none_to_count():
    full = options().friction
    assert full.coulomb.max() > 0.0
    for law in ("law: admittance", "law: impedance, shape_inertia: true, virtual_mass: 1"):
        hidden = options(f"torque: {{{law}}}").friction
        assert not hidden.coulomb.any()
        assert not hidden.viscous.any()
    np.testing.assert_array_equal(options("torque: {law: impedance}").friction.coulomb, full.coulomb)
    part = options("torque: {friction_gain: 0.2}").friction.coulomb
    np.testing.assert_allclose(part, 0.6 * full.coulomb)  # 0.5 - 0.2 instead of 0.5
    assert not options("torque: {friction_gain: 0.6}").friction.coulomb.any()


def device(text="", **stated):
    scene = device_scene(Scene.parse(LINES + text), "loop")
    return device_options(build(scene), device_port(scene, AtHandle(**stated))).stability


@pytest.mark.parametrize(
    ("text", "stated", "delay", "doubt"),
    [("", {}, 0.0, DELAY_DOUBT), ("loop_delay: 0", {}, 0.0, 0.0), ("loop_delay: 0.004", {}, 0.004, 0.0),
     ("", {"delay": 0.002}, 0.002, 0.0), ("loop_delay: 0.004", {"delay": 0.001}, 0.001, 0.0),
     ("stability: {known_delay: 0.005}", {}, 0.005, 0.0),
     ("stability: {known_delay: 0.005, delay_doubt: 0.002}", {"delay": 0.001}, 0.005, 0.002),
     ("stability: {delay_doubt: 0.001}", {}, 0.0, 0.001)],
)  # fmt: skip
def test_delay_of_a_device(text, stated, delay, doubt):
    s = device(text, **stated)
    assert (s.delay, s.delay_doubt) == (delay, doubt)
    assert not s.friction.coulomb.any()


def test_scene_keys_take_precedence_and_the_force_bounds_the_acceleration():
    s = _core.StabilityOptions()
    apply(Scene.parse(LINES).stability, Port(0.001, 0.002, mass=0.1, quantum=1e-5), s)
    assert (s.delay, s.delay_doubt, s.quantum) == (0.001, 0.002, 1e-5)
    assert s.acceleration == pytest.approx(3.0 / (0.1 + PRESETS["relaxed"].mass))
    apply(Scene.parse(LINES + "stability: {acceleration: 7}").stability, Port(0.0, mass=0.1), s)
    assert s.acceleration == 7.0


def test_a_virtual_mass_that_shakes_the_free_handle_is_refused():
    """Independent of the code: the gain of the loop through the load cell, by iteration of its difference equation."""
    for inertia, hand in ((0.5, 0.15), (2.0, 0.05), (0.4, 0.8)):
        least = least_mass(inertia, hand)
        for factor, grows in ((1.0, False), (0.79, True)):
            m, a = factor * least, 1.0
            for _ in range(200):
                a = -(inertia / m - 1.0) * hand * a / (inertia + hand)
            assert (abs(a) > 1.0) == grows
    text = "torque: {law: impedance, shape_inertia: true, virtual_mass: 0.05}\noperator: {hand: firm}\n"
    with pytest.raises(SceneError, match=r"torque\.virtual_mass = 0\.05 kg .*would shake") as refused:
        build(Scene.parse(LINES + text))
    least = float(refused.value.mend.split()[3])
    build(Scene.parse(LINES + text.replace("0.05", f"{1.01 * least:.4f}")))


ROUND = """
objects: [{name: ball, sphere: {radius: 0.01}, pose: {xyz: [-0.035, -0.012, -0.05]}}]
arms: {leader: {model: delta}}
torque: {law: impedance, shape_inertia: true, virtual_mass: MASS}
operator:
  hand: rigid
  path: [{t: 0, xyz: [0, 0, 0.03]}, {t: 0.6, xyz: [0.02, 0.01, 0.05]}, {t: 1.2, xyz: [-0.02, 0, 0.04]}]
"""


def test_the_accepted_virtual_mass_shakes_nowhere_on_the_way():
    """A delta becomes a quarter heavier on this way. Simulated: the force of the cell from tick to tick."""
    with pytest.raises(SceneError) as refused:
        build(Scene.parse(ROUND.replace("MASS", "0.051")))
    least = float(refused.value.mend.split()[3])
    swings = {}
    for mass in (1.01 * least, 0.75 * least):
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(shaping, "check_mass", lambda *_: None)
            rig = build(Scene.parse(ROUND.replace("MASS", f"{mass:.4f}")))
        F = as_ticks(rig.simulation().run(1200))["F_cell_L"]
        swings[mass] = np.abs(np.diff(F[200:], n=2, axis=0)).max()
    accepted, refused_one = swings.values()
    assert accepted < 0.5
    assert refused_one > 5.0, "control"
