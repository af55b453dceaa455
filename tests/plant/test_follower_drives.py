"""A follower with simulated drives: holding, compliance, and drive torques."""

import numpy as np
import pytest

import palpate
from palpate import _core

ARM = palpate.Arm.psm()
Q0 = np.array([0.2, -0.3, 0.12, 0.4, 0.2, -0.3])


def driven(friction: bool = True, bandwidth: float = 30.0) -> _core.Follower:
    options = ARM.follower_options()
    options.driven, options.bandwidth, options.encoder_step = True, bandwidth, np.zeros(6)
    if not friction:
        drives = options.drives
        drives.coulomb = drives.viscous = np.zeros(6)
        options.drives = drives
    follower = _core.Follower(ARM, options)
    follower.reset(Q0)
    follower.command(Q0)
    return follower


def test_drives_at_rest_compensate_gravity():
    follower = driven()
    follower.step(1e-4, 2000)
    np.testing.assert_allclose(follower.q, Q0, atol=1e-12)
    np.testing.assert_allclose(follower.tau, ARM.gravity(Q0), atol=1e-9)


def test_deflection_under_a_push_matches_the_servo_stiffness():
    """Statics: D w^2 (q - q_goal) = J^T F with the inertia D at each drive."""
    follower = driven(friction=False)
    F = np.array([0.5, -0.4, 0.3, 0.0, 0.0, 0.0])
    follower.step(1e-4, 20000, F)
    inertia = ARM.mass_matrix(follower.q).diagonal() + ARM.follower_options().drives.rotor_inertia
    expected = ARM.jacobian(follower.q).T @ F / (inertia * (2 * np.pi * 30.0) ** 2)
    np.testing.assert_allclose(follower.q - Q0, expected, rtol=1e-3, atol=1e-7)
    np.testing.assert_allclose(
        follower.tau, ARM.gravity(follower.q) - ARM.jacobian(follower.q).T @ F, rtol=1e-3, atol=1e-4
    )


def test_dry_friction_holds_a_small_push():
    follower = driven()
    follower.step(1e-4, 5000, np.array([0.02, 0.02, 0.02, 0, 0, 0]))
    np.testing.assert_array_equal(follower.q[:3], Q0[:3])


def test_follower_with_drives_moves_as_the_kinematic_one():
    body, servo = driven(friction=False), _core.Follower(ARM, ARM.follower_options())
    servo.reset(Q0)
    goal = Q0 + np.array([0.05, -0.05, 0.01, 0.1, 0.05, 0.05])
    for follower in (body, servo):
        follower.command(goal)
        follower.step(1e-4, 4000)
    np.testing.assert_allclose(body.q, servo.q, atol=1e-4)


def test_kinematic_follower_reports_no_torque():
    follower = _core.Follower(ARM, ARM.follower_options())
    follower.step(1e-4, 10, np.full(6, 5.0))
    assert follower.tau.size == 0
    assert follower.v.size == 0


def test_ideal_joints_have_no_torque():
    with pytest.raises(ValueError, match="bandwidth above 0 Hz: ideal joints have no torque"):
        driven(bandwidth=0.0)
