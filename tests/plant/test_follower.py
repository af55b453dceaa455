"""The simulated follower: position servos against their closed form."""

import numpy as np
import pytest

import palpate
from palpate import _core


@pytest.fixture(scope="module")
def psm():
    return palpate.Arm.psm()


@pytest.fixture
def options(psm):
    options = psm.follower_options()
    options.encoder_step = np.zeros(6)
    return options


GOAL = np.array([0.01, -0.01, 0.125, 0.02, 0.03, -0.02])


def test_step_response_is_the_critically_damped_one(psm, options):
    """e(t) = (1 + w t) exp(-w t), for any step size."""
    w = 2 * np.pi * options.bandwidth
    for dt in (1e-4, 1e-3):
        follower = _core.Follower(psm, options)
        follower.reset(psm.home)
        follower.command(GOAL)
        for k in range(1, 31):
            follower.step(dt)
            e = (1 + w * k * dt) * np.exp(-w * k * dt)
            assert np.allclose(follower.q, GOAL + e * (psm.home - GOAL), atol=1e-12)


@pytest.mark.parametrize("zeta", [0.3, 0.7, 2.0])
def test_other_damping_ratios_solve_the_servo_equation(psm, options, zeta):
    """Reference: Euler integration of the same law with a thousand times smaller steps."""
    options.damping_ratio, w = zeta, 2 * np.pi * options.bandwidth
    follower = _core.Follower(psm, options)
    follower.reset(psm.home)
    follower.command(GOAL)
    follower.step(1e-3, n=10)
    e, v, h = psm.home - GOAL, np.zeros(6), 1e-7
    for _ in range(100_000):
        e, v = e + h * v, v - h * (w * w * e + 2 * zeta * w * v)
    assert np.allclose(follower.q, GOAL + e, atol=1e-5)


def test_speed_and_joint_limits_hold(psm, options):
    follower = _core.Follower(psm, options)
    follower.reset(psm.home)
    rng = np.random.default_rng(10)
    before = follower.q
    for _ in range(200):
        follower.command(rng.uniform(2 * psm.q_min, 2 * psm.q_max))
        for _ in range(10):
            follower.step(1e-3)
            assert (np.abs(follower.q - before) <= options.v_max * 1e-3 + 1e-12).all()
            before = follower.q
            assert (before >= psm.q_min).all()
            assert (before <= psm.q_max).all()


def test_long_motion_runs_at_full_speed_without_overshoot(psm, options):
    follower = _core.Follower(psm, options)
    follower.reset(psm.home)
    goal = psm.home + np.eye(6)[0]
    follower.command(goal)
    yaw = []
    for _ in range(1500):
        follower.step(1e-3)
        yaw.append(follower.q[0])
    assert max(yaw) <= 1.0 + 1e-9
    assert yaw[-1] == pytest.approx(1.0, abs=1e-6)
    assert np.diff(yaw).max() == pytest.approx(options.v_max[0] * 1e-3, rel=1e-6)


def test_ideal_follower_is_at_its_goal(psm, options):
    options.bandwidth = 0.0
    follower = _core.Follower(psm, options)
    follower.reset(psm.home)
    follower.command(GOAL, 0.3)
    follower.step(1e-3)
    assert np.array_equal(follower.q, GOAL)


def test_encoders_round_to_counts(psm):
    options = psm.follower_options()
    follower = _core.Follower(psm, options)
    follower.reset(GOAL)
    counts = follower.q / options.encoder_step
    assert np.abs(counts - np.round(counts)).max() < 1e-6
    assert (np.abs(follower.q - GOAL) <= 0.5 * options.encoder_step + 1e-15).all()


def test_jaw_opens_at_its_speed(psm, options):
    follower = _core.Follower(psm, options)
    follower.reset(psm.home, 0.0)
    follower.command(psm.home, 1.0)
    follower.step(1e-3, n=10)
    assert follower.jaw == pytest.approx(0.01 * options.jaw_v_max)
    follower.step(1e-3, n=200)
    assert follower.jaw == 1.0


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("v_max", np.ones(5), "need 6 entries"),
        ("v_max", np.zeros(6), "v_max must be above zero"),
        ("bandwidth", -1.0, "bandwidth must be >= 0"),
    ],
)
def test_invalid_options_are_reported(psm, options, field, value, message):
    setattr(options, field, value)
    with pytest.raises(ValueError, match=message):
        _core.Follower(psm, options)
