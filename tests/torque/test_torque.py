"""Torques that render a force: power balance, the paper's reduced mode, limits, the platform controller."""

import numpy as np
import pytest

import palpate
from palpate import _core
from palpate.record.ticks import STATUS

PLATFORM = 3
LIMITED = STATUS["torque_limited"][0]


@pytest.fixture(scope="module")
def mtm():
    return palpate.Arm.mtm("right")


@pytest.fixture
def options():
    options = _core.TorqueOptions()
    options.platform_gain = options.limits.gain = 0.0
    return options


@pytest.fixture
def states(mtm):
    rng = np.random.default_rng(11)
    return [(rng.uniform(mtm.q_min, mtm.q_max), rng.normal(0, 0.5, 7), rng.normal(0, 0.3, 6)) for _ in range(50)]


def test_torque_and_force_deliver_the_same_power(mtm, options, states):
    torque = _core.Torque(options, 1e3 * mtm.tau_max)
    for q, v, F in states:
        out, status = torque.step(mtm, q, v, F)
        tau_force, rendered = out.tau_force, out.F_H_L
        assert tau_force @ v == pytest.approx(F @ (mtm.jacobian(q) @ v), abs=1e-12)
        assert np.array_equal(rendered, F)
        assert np.allclose(out.tau_gravity, mtm.holding(q), atol=1e-15)
        assert np.array_equal(out.tau, out.tau_force + out.tau_gravity)
        assert not status & LIMITED


def test_paper_mode_commands_no_wrist_torque(mtm, options, states):
    """Section 2.3 of the paper: exactly zero, including gravity and platform terms."""
    options.mode, options.platform_gain, options.limits.gain = "paper", 1.0, 0.5
    options.friction.gain, options.friction.coulomb, options.friction.viscous = 0.8, np.ones(7), np.ones(7)
    for law in ("stiffness", "impedance", "admittance"):
        options.law = law
        torque = _core.Torque(options, mtm.tau_max)
        for q, v, F in states:
            out, _ = torque.step(mtm, q, v, F, F_cell_L=np.ones(3))
            for term in (out.tau_force, out.tau_gravity, out.tau_platform, out.tau_friction, out.tau_limits):
                assert not term[3:].any()
            assert not out.F_H_L[3:].any()


def test_paper_mode_uses_the_wrist_centres_jacobian(mtm, options, states):
    options.mode = "paper"
    torque = _core.Torque(options, 1e3 * mtm.tau_max)
    for q, v, F in states:
        out, _ = torque.step(mtm, q, v, F)
        h, J = 1e-6, np.zeros((3, 3))
        for k in range(3):
            step = h * np.eye(7)[k]
            J[:, k] = (mtm.fk(q + step) - mtm.fk(q - step))[:3, 3] / (2 * h)
        assert np.allclose(out.tau_force[:3], J.T @ F[:3], atol=1e-8)
        assert np.allclose(out.tau_gravity[:3], mtm.holding(q)[:3])


def test_pure_force_needs_no_wrist_torque_in_full_mode(mtm, options, states):
    """The wrist axes meet at the handle, so both modes render a pure force equally."""
    torque = _core.Torque(options, 1e3 * mtm.tau_max)
    for q, v, F in states:
        out, _ = torque.step(mtm, q, v, np.r_[F[:3], 0, 0, 0])
        assert np.abs(out.tau_force[3:]).max() < 1e-15


def test_drive_limits_scale_the_force_and_keep_its_direction(mtm, options, states):
    torque = _core.Torque(options, mtm.tau_max)
    for q, v, F in states:
        big = 100.0 * np.r_[F[:3], 0, 0, 0]
        out, status = torque.step(mtm, q, v, big)
        tau, tau_force, rendered = out.tau, out.tau_force, out.F_H_L
        assert status & LIMITED
        assert (np.abs(tau) <= mtm.tau_max + 1e-12).all()
        assert np.linalg.norm(np.cross(rendered[:3], big[:3])) < 1e-9 * np.linalg.norm(big) ** 2
        assert rendered @ big >= 0
        assert np.allclose(tau_force, mtm.jacobian(q).T @ rendered, atol=1e-12)
        assert np.isclose(np.abs(tau) / mtm.tau_max, 1.0).any()  # the drives are at their limit


def test_gravity_has_priority_on_the_drives(mtm, options):
    q = np.zeros(7)
    weak = np.full(7, 0.5 * np.abs(mtm.holding(q)).max())
    out, status = _core.Torque(options, weak).step(mtm, q, 0 * q, np.array([0, 0, 5.0, 0, 0, 0]))
    assert status & LIMITED
    assert (np.abs(out.tau) <= weak + 1e-12).all()
    assert np.linalg.norm(out.F_H_L) < 5.0


def test_rounding_on_a_saturated_drive_does_not_reduce_the_force(mtm, options):
    """All wrist axes meet at the tip, so a force loads the saturated platform drive only by rounding."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        q, F = rng.uniform(mtm.q_min, mtm.q_max), np.r_[0.3 * rng.standard_normal(3), 0, 0, 0]
        full = mtm.tau_max.copy()
        full[3] = abs(mtm.holding(q)[3])
        out, _ = _core.Torque(options, full).step(mtm, q, 0 * q, F)
        np.testing.assert_allclose(out.F_H_L[:3], F[:3], rtol=1e-9)


def test_moments_use_the_torque_that_the_force_leaves(mtm, options):
    """A moment beyond the wrist drives does not reduce the force."""
    q = np.array([0, 0, 0, 0, np.pi / 2, 0.3, 0])
    F = np.array([0.5, -1.0, 0.3, 0.4, 0.4, 0.4])
    out, status = _core.Torque(options, mtm.tau_max).step(mtm, q, 0 * q, F)
    assert status & LIMITED
    assert np.array_equal(out.F_H_L[:3], F[:3])
    share = out.F_H_L[3:] / F[3:]
    assert np.ptp(share) < 1e-12
    assert 0 < share[0] < 1
    assert np.allclose(out.tau_force, mtm.jacobian(q).T @ out.F_H_L, atol=1e-12)


def test_gravity_gain_and_wrong_model_scale_the_compensation(mtm, options):
    q = np.array([0.1, 0.3, -0.2, 0.4, 0.8, 0.2, 0.3])
    options.gravity_gain = 0.7
    heavier = mtm.with_scaled_masses(np.full(7, 1.1))
    out, _ = _core.Torque(options, mtm.tau_max).step(heavier, q, 0 * q, np.zeros(6))
    assert np.allclose(out.tau_gravity, 0.7 * (1.1 * mtm.gravity(q) + mtm.elastic(q)))


@pytest.mark.parametrize(
    ("q5", "q6", "v4", "expected"),
    [
        (0.0, 0.1, 0.0, 0.5 * 0.1),  # error = q6 cos(q5)
        (np.pi / 2, 0.1, 0.0, 0.0),  # the platform is aligned, so the torque is zero
        (0.0, 0.7, 0.0, 0.5 * 0.05 * np.pi),  # the error is limited to 9 degrees
        (0.0, 0.0, 0.4, -0.5 * 0.1 * 0.4),
        (0.0, 0.0, -1e3, 0.4),  # limited torque
    ],
)
def test_platform_controller_agrees_with_the_real_one(mtm, q5, q6, v4, expected):
    q, v = np.zeros(7), np.zeros(7)
    q[4], q[5], v[3] = q5, q6, v4
    out, _ = _core.Torque(_core.TorqueOptions(), 1e3 * mtm.tau_max).step(mtm, q, v, np.zeros(6))
    tau_platform = out.tau_platform
    assert tau_platform[PLATFORM] == pytest.approx(expected, abs=1e-12)
    assert not np.delete(tau_platform, PLATFORM).any()


def test_invalid_options_are_reported(mtm):
    options = _core.TorqueOptions()
    with pytest.raises(ValueError, match=r"torque mode must be 'full' or 'paper'.*got 'fancy'"):
        options.mode = "fancy"
    with pytest.raises(ValueError, match="tau_max must be above zero"):
        _core.Torque(options, np.zeros(7))
    options.platform_gain = 2.0
    with pytest.raises(ValueError, match=r"platform_gain = 2.0+: must lie in 0\.\.1"):
        _core.Torque(options, mtm.tau_max)
