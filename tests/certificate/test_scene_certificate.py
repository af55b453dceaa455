"""Certificates of scenes: agreement with the full simulation, the scene's hand, and unsupported laws."""

import re
import warnings
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import palpate
from palpate import _core
from palpate.base.errors import PalpateError, PalpateWarning
from palpate.devices.certificate import certify_all
from palpate.devices.certificate.arms import HeldLeader
from palpate.devices.certificate.scene import _DIRECTIONS, _Arms, _settled, warn_outside
from palpate.devices.certificate.touched import touched
from palpate.scene.rig import build
from palpate.viewer.staging import stable_below
from palpate_lab.studies.certificate import arms as certificate_arms

SCENE = """
objects: [{name: table, plane: {size: 0.3}, stiffness: 800, damping: 1}]
operator: {path: [{t: 0, xyz: [0, 0, 0.02]}, {t: 1, xyz: [0, 0, -0.001]}]}
"""


def scene(text="", **update):
    return palpate.Scene.parse(SCENE + text).model_copy(update=update)


@pytest.fixture(scope="module")
def rig():
    return build(scene())


def test_full_simulation_oscillates_above_the_limit_and_settles_below(rig):
    """The simulation has seven joints, a hand, the follower's servo and a delay, and uses no code of the analysis."""
    n_W = np.array([0.6, 0.0, 0.8])
    delayed = build(scene(loop_delay=0.006))
    k, _ = certificate_arms.limit(delayed, n_W, 5.0)
    assert not certificate_arms.swings(delayed, n_W, 0.95 * k, 5.0)
    assert certificate_arms.swings(delayed, n_W, 1.05 * k, 5.0)


def test_advised_changes_raise_the_limit(rig):
    k = certify_all(rig.scene, rig=rig)[0].k_max
    assert palpate.certify(scene(loop_delay=0.01)).k_max < 0.7 * k
    assert palpate.certify(scene("arms: {follower: {bandwidth: 60}}")).k_max > 1.2 * k
    assert palpate.certify(scene("arms: {leader: {drive_lag: 0.004}}")).k_max < 0.95 * k
    assert palpate.certify(scene("stability: {low_pass: 10}")).k_max < 0.8 * k
    assert palpate.certify(scene(mapping=rig.scene.mapping.model_copy(update={"scale": 0.25}))).k_max == pytest.approx(
        2 * k, rel=0.05
    )


def test_the_scenes_own_hand_sets_the_limit(rig):
    hands = certify_all(rig.scene, rig=rig)[0].hands
    assert hands["normal"] == pytest.approx(certify_all(rig.scene, rig=rig)[0].k_max, rel=1e-6)
    assert list(np.argsort(list(hands.values()))) == list(range(5))
    light = SCENE.replace("operator: {", "operator: {hand: light, ")
    assert palpate.certify(palpate.Scene.parse(light)).k_max == pytest.approx(hands["light"], rel=0.02)


def test_each_region_has_a_certificate():
    nodule = palpate.Scene.load("scenes/nodule.yaml")
    assert [surface.name for surface in touched(build(nodule))] == ["liver", "liver, nodule"]


def test_unstable_object_warns_with_location_and_remedy():
    late = palpate.Scene.parse(SCENE + "loop_delay: 0.04\n", "late.yaml")
    with pytest.warns(PalpateWarning, match=r"late.yaml:2: table: unstable: 40 ms of delay .* would give"):
        warn_outside(build(late))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_outside(build(scene()))


def test_admittance_law_has_no_certificate():
    admittance = scene("torque: {law: admittance}")
    shaped = scene("torque: {law: impedance, shape_inertia: true}")
    with pytest.raises(PalpateError, match=r"there is no certificate for torque\.law impedance with shape_inertia"):
        palpate.certify(shaped)
    for law in ("impedance", "stiffness, shape_inertia: true"):
        assert palpate.certify(scene(f"torque: {{law: {law}}}")).verdict == "stable"
    with pytest.raises(PalpateError, match=r"there is no certificate for torque\.law admittance"):
        palpate.certify(admittance)
    warn_outside(build(admittance))  # no warning without an analysis


def test_drive_based_force_source_has_no_certificate():
    bilateral = palpate.Scene.load("scenes/bilateral.yaml")
    with pytest.raises(PalpateError, match=r"there is no certificate for force\.source both"):
        palpate.certify(bilateral)


def test_the_most_damped_axis_is_also_checked():
    too_much = palpate.Scene.parse(SCENE.replace("damping: 1", "damping: [1, 1, 3000]"))
    assert palpate.certify(too_much).verdict == "unstable"
    assert (
        palpate.certify(palpate.DeviceModel(mass=0.3, damping=0.5, delay=0.005), K=0.0, B=1000.0).verdict == "unstable"
    )


def test_viewer_limit_is_that_of_the_stiffest_region_and_object():
    """The sliders scale all stiffnesses, so the limit shown for the first object must hold for every object."""
    one = "{name: table, plane: {size: 0.3}, stiffness: 800, damping: 1}"
    stiff = one.replace("table, ", "ceiling, pose: {xyz: [0, 0, 0.2], rpy_deg: [180, 0, 0]}, ").replace("800", "2400")
    alone, both = (build(palpate.Scene.parse(SCENE.replace(one, text))) for text in (one, f"{one}, {stiff}"))
    limits = [stable_below(rig) for rig in (alone, both)]
    assert limits[0] is not None
    assert limits[1] is not None
    assert limits[1](2.0) == pytest.approx(limits[0](2.0) / 3.0, rel=1e-6)


def test_the_direction_found_has_nearly_the_least_limit_of_all(rig):
    """Reference: random directions. A sphere has no single normal, so that the search covers all directions."""
    round_ = palpate.Scene.parse(SCENE.replace("plane: {size: 0.3}", "sphere: {radius: 0.02}"))
    made = build(round_)
    found = certify_all(round_, rig=made)[0]
    n = np.random.default_rng(2).normal(size=(60, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    limits = [held.loop(one).K_max(1.0)[0] for held in _Arms(made).leaders.values() for one in n]
    axes = [held.loop(one).K_max(1.0)[0] for held in _Arms(made).leaders.values() for one in _DIRECTIONS]
    assert 0.8 * min(limits) < found.k_max < 1.03 * min(limits)
    assert found.k_max <= min(axes)


def test_joint_4_has_settled_where_its_controller_rests():
    start = build(scene())
    q = _settled(start)
    o, arm = start.options(), start.arms.leader
    controller = _core.Torque(o.torque, arm.tau_max, 1.0 / o.rate)
    torque = [np.abs(controller.step(arm, one, np.zeros(arm.n), np.zeros(6))[0].tau_platform).max()
              for one in (start.arms.q_leader0, q)]  # fmt: skip
    assert torque[1] < 0.05 * torque[0]
    off = build(scene("torque: {platform_gain: 0}"))
    np.testing.assert_array_equal(_settled(off), off.arms.q_leader0)


def test_energies_of_a_held_leader_are_those_of_arm_rotors_and_hand(rig):
    """Reference: velocity and turn of the handle from two poses, and the hand as a mass, a damper and a spring."""
    o, arm, rng = rig.options(), rig.arms.leader, np.random.default_rng(8)
    o.torque.platform_gain, o.torque.friction.gain = 0.0, 0.25
    assert (o.torque.platform_gain, o.torque.friction.gain) == (0.0, 0.25)
    h, q = o.hand, rig.arms.q_leader0
    M, D, S, J = HeldLeader(arm, q, o, h)._matrices
    for v in rng.normal(size=(4, arm.n)):
        X, Y = arm.fk(q - 1e-6 * v), arm.fk(q + 1e-6 * v)
        x, w = (Y[:3, 3] - X[:3, 3]) / 2e-6, Rotation.from_matrix(Y[:3, :3] @ X[:3, :3].T).as_rotvec() / 2e-6
        np.testing.assert_allclose(J @ v, [*x, *w], rtol=1e-5, atol=1e-8)
        own = v @ arm.mass_matrix(q) @ v + np.sum(o.leader.rotor_inertia * v**2)
        assert v @ M @ v == pytest.approx(own + h.mass * x @ x + h.inertia * w @ w, rel=1e-5)
        heat = 0.75 * np.sum(o.leader.viscous * v**2) + h.damping * x @ x + h.rotational_damping * w @ w
        assert v @ D @ v == pytest.approx(heat, rel=1e-5)
        assert v @ S @ v == pytest.approx(h.stiffness * x @ x + h.rotational_stiffness * w @ w, rel=1e-5)


def test_joint_4_adds_the_stiffness_and_damping_of_its_controller(rig):
    """Reference: the change of its torque along a random displacement and velocity."""
    o, arm, q = rig.options(), rig.arms.leader, _settled(rig)
    controller = _core.Torque(o.torque, arm.tau_max, 1.0 / o.rate)

    def torque(q, v):
        return controller.step(arm, q, v, np.zeros(6))[0].tau_platform.copy()

    D, K = HeldLeader(arm, q, o, o.hand)._platform()
    d, still = np.random.default_rng(9).normal(size=arm.n), np.zeros(arm.n)
    assert max(np.abs(K).max(), np.abs(D).max()) > 1e-3
    np.testing.assert_allclose(K @ d, -(torque(q + 1e-4 * d, still) - torque(q, still)) / 1e-4, rtol=1e-2, atol=1e-4)
    np.testing.assert_allclose(D @ d, -(torque(q, 1e-4 * d) - torque(q, still)) / 1e-4, rtol=1e-2, atol=1e-6)


def test_mode_paper_renders_forces_by_three_joints(rig):
    """Inertia times accelerations are the torques: J^T F in the first three joints, and no moment at all."""
    o = rig.options()
    o.torque.mode = "paper"
    held = HeldLeader(rig.arms.leader, rig.arms.q_leader0, o, o.hand)
    M, _, _, J = held._matrices
    torque = M @ held._space(6)[1][len(M) : 2 * len(M)]
    np.testing.assert_allclose(torque[:3, :3], J[:3, :3].T, atol=1e-9)
    np.testing.assert_allclose(torque[3:, :3], 0.0, atol=1e-9)
    np.testing.assert_allclose(torque[:, 3:], 0.0, atol=1e-9)


def test_advice_for_the_follower_is_the_limit_of_a_scene_with_twice_its_bandwidth():
    hz = scene().arms.follower.bandwidth
    text = palpate.certify(scene(), K=60000.0).reason
    advised = float(re.search(rf"a follower's servo of {2 * hz:g} Hz would give (\d+)", text)[1])
    assert advised == pytest.approx(
        palpate.certify(scene(f"arms: {{follower: {{bandwidth: {2 * hz}}}}}")).k_max, rel=0.01
    )


def test_an_unstable_fixture_warns_with_the_place_of_the_guidance():
    wall = "{name: wall, role: forbid, geometry: {plane: {}}, law: {stiffness: 100000, damping: 1}}"
    late = palpate.Scene.parse(SCENE + f"guidance: [{wall}]\n", "late.yaml")
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        warn_outside(build(late))
    assert [str(one.message).split(": ")[:3] for one in seen][-1] == ["late.yaml:4", "fixture wall", "unstable"]


def test_an_unstable_second_object_warns_with_its_own_place():
    text = """objects:
  - {name: soft, plane: {size: 0.3}, stiffness: 20}
  - {name: hard, plane: {size: 0.3}, stiffness: 800, pose: {xyz: [0, 0, -0.5]}}
operator: {path: [{t: 0, xyz: [0, 0, 0.02]}]}
loop_delay: 0.04
"""
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        warn_outside(build(palpate.Scene.parse(text, "two.yaml")))
    assert str(seen[0].message).split(": ")[:2] == ["two.yaml:3", "hard"]


def test_the_search_turns_towards_the_direction_of_the_least_limit():
    """A limit that grows with the angle to one direction, while the frequency falls."""
    least = np.array([0.6, 0.0, 0.8])

    def K_max(n):
        return 1000.0 + 500.0 * np.arccos(min(n @ least, 1.0)), 1.0 / (2.0 - n @ least)

    held = SimpleNamespace(loop=lambda n: SimpleNamespace(K_max=lambda B: K_max(n)))
    for angle in (0.0, 0.2, 0.5):
        start = Rotation.from_rotvec([0.0, angle, 0.0]).apply(least)
        found = _Arms._steepest(held, start, K_max(start)[0], 1.0)
        assert np.linalg.norm(found) == pytest.approx(1.0)
        assert np.arccos(min(found @ least, 1.0)) <= min(angle, 0.25)
