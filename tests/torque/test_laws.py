"""The three control laws on a simulated leader: rendered forces, bounds, and rejected options."""

import numpy as np
import pytest
from effort import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from laws_rig import bench

import palpate
from palpate import _core
from palpate.record.ticks import STATUS

LAWS = ["stiffness", "impedance", "admittance"]
TOO_FAST, NO_CELL = STATUS["too_fast"][0], STATUS["no_load_cell"][0]


@pytest.mark.parametrize("name", ["mtm_right", "six_axis", "delta"])
@pytest.mark.parametrize("law", LAWS)
def test_force_at_rest_is_the_rendered_one(law, name):
    """Within 1 % on an arm without friction."""
    b = bench(law, name=name)
    F = np.array([1.2, -0.8, 1.5, 0, 0, 0])
    for _ in range(3000):
        b.tick(F)
    assert np.abs(b.leader.load_cell[:3] - F[:3]).max() < 0.01 * np.linalg.norm(F)


def test_moment_at_rest_is_the_rendered_one():
    b = bench(name="six_axis")
    F = np.array([0.5, 0.2, -0.3, 0.02, -0.03, 0.01])
    for _ in range(3000):
        b.tick(F)
    assert np.abs(b.leader.load_cell - F).max() < 0.01 * np.linalg.norm(F)


def test_shaped_inertia_is_the_mass_at_the_handle():
    """Without the spring of a hand a = F / m, independent of the mass of the arm in this direction."""
    masses = {}
    for shape in (False, True):
        b = bench("impedance", name="six_axis", laws__shape_inertia=shape, laws__virtual_mass=0.8)
        F, t = np.array([0.0, 0.4, 0.0, 0, 0, 0]), 0.0
        X = b.arm.fk(b.arm.home)
        for k in range(60):  # the hand keeps the orientation and follows the position of the handle
            X[:3, 3] = b.arm.fk(b.leader.q)[:3, 3]
            V = np.r_[(b.arm.jacobian(b.leader.q) @ b.leader.v)[:3], 0, 0, 0]
            b.tick(F, X, V)
            t += 1e-3
            if k == 29:
                v, t1 = V[1], t
        a = ((b.arm.jacobian(b.leader.q) @ b.leader.v)[1] - v) / (t - t1)
        masses[shape] = 0.4 / a - 0.15  # the mass of the hand is added to the handle
    assert masses[True] == pytest.approx(0.8, rel=0.1)
    assert abs(masses[False] - 0.8) > 0.1  # control: without shaping the mass differs


def swing(b, f, A, seconds=1.0):
    """(largest neglected force [N], status bits) for a motion of the handle by A sin(2 pi f t) [m] along y of L."""
    X0, worst, seen = b.arm.fk(b.arm.home), 0.0, 0
    for k in range(round(seconds * 1000)):
        t, w = k * 1e-3, 2 * np.pi * f
        X, V = X0.copy(), np.zeros(6)
        X[1, 3] += A * np.sin(w * t)
        V[1] = A * w * np.cos(w * t)
        command = b.tick(np.zeros(6), X, V)
        worst, seen = max(worst, command.F_neglected), seen | b.status
    return worst, seen


def test_fast_motion_is_reported_but_slow_motion_is_not():
    """The estimate agrees with the true inertia force."""
    slow, seen = swing(bench(), 0.5, 0.01)
    assert slow < 0.3
    assert not seen & TOO_FAST
    b = bench()
    fast, seen = swing(b, 4.0, 0.02)
    Lambda = _core.cartesian_place(b.arm, b.arm.home, np.zeros(7), b.arm.leader_options().rotor_inertia)[0]
    assert fast == pytest.approx(np.linalg.norm(Lambda[:, 1]) * 0.02 * (2 * np.pi * 4.0) ** 2, rel=0.45)
    assert seen & TOO_FAST
    assert not swing(bench("admittance"), 4.0, 0.02)[1] & TOO_FAST  # admittance leaves no inertia to the hand


def test_load_cell_noise_has_its_size_and_is_reproducible():
    def read(seed):
        b = bench(noise=0.05)
        options = b.arm.leader_options()
        options.cell_noise, options.seed = 0.05, seed
        leader = _core.Leader(b.arm, options)
        leader.reset(b.arm.home)
        found = []
        for _ in range(800):
            leader.step(1e-4, b.arm.fk(b.arm.home))
            found.append(leader.F_cell_L - leader.load_cell[:3])
        return np.array(found)

    noise = read(3)
    assert noise.std() == pytest.approx(0.05, rel=0.06)
    assert np.array_equal(noise, read(3))
    assert not np.array_equal(noise, read(4))


def test_admittance_without_a_load_cell_equals_stiffness_and_is_reported():
    arm = palpate.Arm.model("mtm_right")
    q, v, F = arm.home, np.full(7, 0.1), np.array([1.0, 0, 0, 0, 0, 0])
    commands = []
    for law in ("stiffness", "admittance"):
        options = _core.TorqueOptions()
        options.law = law
        torque = _core.Torque(options, arm.tau_max)
        for cell in (None, np.full(3, np.nan)):
            command, status = torque.step(arm, q, v, F, F_cell_L=cell)
            commands.append(command.tau)
            assert bool(status & NO_CELL) == (law == "admittance")
    assert all(np.array_equal(commands[0], other) for other in commands[1:])


@settings(max_examples=examples(50), deadline=None)
@given(st.sampled_from(LAWS), st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=3, max_size=3))
def test_torques_are_finite_and_bounded_for_any_load_cell_values(law, cell):
    arm = palpate.Arm.model("mtm_right")
    options = _core.TorqueOptions()
    options.law, options.laws.shape_inertia = law, True
    torque = _core.Torque(options, arm.tau_max)
    for _ in range(5):
        command, _ = torque.step(arm, arm.home, np.zeros(7), np.zeros(6), F_cell_L=np.array(cell))
        assert np.isfinite(command.tau).all()
        assert (np.abs(command.tau) <= arm.tau_max + 1e-12).all()
        assert np.linalg.norm(command.F_law_L[:3]) <= options.law_cap + 1e-9


def test_terms_of_a_law_fade_when_the_leader_is_silent():
    b = bench("admittance")
    for _ in range(50):
        command = b.tick(np.array([2.0, 0, 0, 0, 0, 0]))
    assert np.linalg.norm(command.F_law_L) > 0.01
    q, added = b.leader.q_measured, [np.linalg.norm(command.F_law_L)]
    for _ in range(600):
        command, _ = b.torque.step(b.model, q, np.zeros(7), np.zeros(6), fresh=False)
        added.append(np.linalg.norm(command.F_law_L))
    assert (np.diff(added) <= 0).all()


@settings(max_examples=examples(60), deadline=None)
@given(st.lists(st.floats(-3, 3), min_size=7, max_size=7), st.floats(0, 1))
def test_friction_compensation_is_weaker_than_friction(v, gain):
    """Its power is below that of the friction at each joint, and zero in the dead band, so it is passive."""
    b = bench(friction__gain=gain)
    truth, v = b.arm.leader_options(), np.array(v)
    tau = b.torque.step(b.model, b.arm.home, v, np.zeros(6))[0].tau_friction
    assert (tau * v <= truth.coulomb * np.abs(v) + truth.viscous * v**2 + 1e-15).all()
    assert (tau * v >= 0).all()
    assert not tau[np.abs(v) <= 0.02].any()


@pytest.mark.parametrize("push", [0.0, 0.4])
def test_released_arm_does_not_creep(push):
    """With all friction compensated and real encoders a free arm stays at rest, and stops after a push."""
    b = bench(friction=True, hand=False, quantised=True, friction__gain=1.0, platform_gain=0.0)
    for k in range(1500):
        b.tick(np.array([push if k < 60 else 0.0, 0, 0, 0, 0, 0]))
    after = b.leader.q.copy()
    for _ in range(1000):
        b.tick(np.zeros(6))
    assert np.linalg.norm(b.arm.fk(b.leader.q)[:3, 3] - b.arm.fk(after)[:3, 3]) < (2e-5 if push == 0 else 0.03)
    assert np.abs(b.leader.v).max() < (1e-3 if push == 0 else 0.1)


def test_soft_stops_push_back_linearly():
    arm = palpate.Arm.model("mtm_right")
    torque = _core.Torque(_core.TorqueOptions(), arm.tau_max)

    def tau(q):
        return torque.step(arm, q, np.zeros(7), np.zeros(6))[0].tau_limits

    assert not tau(arm.home).any()
    for k in range(7):
        q = arm.home.copy()
        for end, sign in ((arm.q_min[k], 1), (arm.q_max[k], -1)):
            q[k] = end
            assert tau(q)[k] == pytest.approx(sign * 0.2 * arm.tau_max[k])
            q[k] = end + sign * 0.031 * (arm.q_max[k] - arm.q_min[k])
            assert tau(q)[k] == 0
            q[k] = end + sign * 0.015 * (arm.q_max[k] - arm.q_min[k])
            assert tau(q)[k] == pytest.approx(sign * 0.1 * arm.tau_max[k])


def test_every_term_can_be_switched_off():
    arm = palpate.Arm.model("mtm_right")
    options = _core.TorqueOptions()
    options.force_gain = options.gravity_gain = options.platform_gain = options.limits.gain = 0.0
    q = arm.q_min.copy()
    command, _ = _core.Torque(options, arm.tau_max).step(arm, q, np.ones(7), np.ones(6))
    assert not command.tau.any()
    assert not command.F_H_L.any()


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("law", "magic", "torque.law = 'magic': the laws are stiffness, impedance, admittance"),
        ("friction__gain", 1.5, "friction_gain = 1.5.*would drive the arm"),
        ("laws__virtual_mass", 0.0, "virtual_mass = 0.0.* 0.05 kg or more"),
        ("limits__margin", 0.9, "limit_margin"),
        ("rotor_inertia", np.ones(3), "need 7 entries"),
    ],
)
def test_invalid_options_are_reported(field, value, message):
    with pytest.raises(ValueError, match=message):
        bench(**{field: value} if field != "law" else {"law": value})


def test_bandwidth_of_the_position_loop_is_checked_only_for_admittance():
    bench("stiffness", laws__servo_bandwidth=80.0)
    with pytest.raises(ValueError, match=r"servo_bandwidth = 80.*a twentieth of the cycle's rate"):
        bench("admittance", laws__servo_bandwidth=80.0)
