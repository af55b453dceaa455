"""Force estimates from drive torques, against a simulated follower under a known wrench."""

import numpy as np
import pytest

import palpate
from palpate import _core

ARM = palpate.Arm.psm()
Q0 = np.array([0.2, -0.3, 0.12, 0.4, 0.2, -0.3])


def drives(**values) -> _core.FollowerOptions:
    options = ARM.follower_options()
    options.driven, options.encoder_step = True, np.zeros(6)
    parts = options.drives
    for name, value in values.items():
        setattr(parts, name, value)
    options.drives = parts
    return options


def follower(**values) -> _core.Follower:
    f = _core.Follower(ARM, drives(**values))
    f.reset(Q0)
    f.command(Q0)
    return f


FREE = {"coulomb": np.zeros(6), "viscous": np.zeros(6)}
ROTORS = ARM.follower_options().drives.rotor_inertia


def test_residual_in_steady_state_is_the_joint_torque_of_the_wrench():
    f = follower(**FREE)
    observer = _core.MomentumObserver(ARM, np.diag(ROTORS), 20.0)
    F = np.array([1.0, -2.0, 3.0, 0.02, -0.01, 0.03])
    r = np.zeros(6)
    for _ in range(1500):
        f.step(1e-4, 10, F)
        r = observer.run(f.q[None], f.v[None], f.tau[None], 1000.0)[0]
    np.testing.assert_allclose(r, ARM.jacobian(f.q).T @ F, atol=2e-4)


def test_residual_of_a_moving_arm_is_the_filtered_wrench():
    """Inertia, Coriolis and gravity torques of a fast motion do not enter the first-order response to the wrench."""
    f, bandwidth, rate = follower(**FREE), 15.0, 1000.0
    rows, expected, low = [], [], np.zeros(6)
    k = 2 * np.pi * bandwidth / rate
    last = np.zeros(6)
    for i in range(2000):
        t = i / rate
        F = np.zeros(6)
        F[:3] = 3.0 * np.sin(2 * np.pi * np.array([0.7, 1.1, 1.7]) * t)
        f.command(
            Q0
            + 0.3
            * min(t, 1.0)
            * np.sin(2 * np.pi * np.array([0.5, 0.8, 0.3, 1.0, 1.2, 0.9]) * t)
            * [1, 1, 0.1, 1, 1, 1]
        )
        f.step(1e-4, 10, F)
        rows.append(np.concatenate([f.q, f.v, f.tau]))
        now = ARM.jacobian(f.q).T @ F
        low = (low + 0.5 * k * (now + last)) / (1 + k)
        last = now
        expected.append(low)
    data = np.array(rows)
    observer = _core.MomentumObserver(ARM, np.diag(ROTORS), bandwidth)
    r = observer.run(data[:, :6], data[:, 6:12], data[:, 12:], rate)
    scale = np.abs(expected).max(axis=0) + 1e-3
    error = np.abs(r - expected)[300:].max(axis=0)  # after the transient of the observer
    assert (error < 0.06 * scale).all(), error / scale  # torques are sampled once a period


def test_estimated_tip_force_explains_the_torques():
    f = follower(**FREE)
    options = _core.EstimateOptions()
    options.rotor_inertia = ROTORS
    estimate = _core.Estimate(ARM, options)
    F = np.array([0.5, 1.5, -2.0, 0, 0, 0])
    for _ in range(1500):
        f.step(1e-4, 10, F)
        F_tip = estimate.step(f.t, f.q, f.v, f.tau)
    np.testing.assert_allclose(F_tip, F[:3], atol=0.01)


def test_dead_band_and_invalid_states():
    options = _core.EstimateOptions()
    options.dead_band = 1e3
    estimate = _core.Estimate(ARM, options)
    for k in range(50):
        np.testing.assert_array_equal(estimate.step(1e-3 * k, Q0, np.zeros(6), np.full(6, 0.1)), np.zeros(3))
    wide = _core.Estimate(ARM, _core.EstimateOptions())
    pushed = push(wide, 0.0, 50)
    assert np.linalg.norm(pushed) > 0.1
    for broken in (np.nan, 1e300, 11 * float(ARM.v_max.min())):
        np.testing.assert_array_equal(wide.step(0.05, Q0, np.full(6, broken), np.zeros(6)), np.zeros(3))
        assert np.linalg.norm(push(wide, 0.1, 1)) < 1e-9, "the estimate starts again"
        np.testing.assert_allclose(push(wide, 0.101, 50), pushed, rtol=0.05)


def push(estimate: _core.Estimate, t0: float, n: int) -> np.ndarray:
    """Estimate after n states at 1 ms of an arm at rest with 0.1 N m more than gravity; (3,) [N]."""
    for k in range(n):
        F_tip = estimate.step(t0 + 1e-3 * k, Q0, np.zeros(6), ARM.gravity(Q0) + 0.1)
    return F_tip


def test_late_or_repeated_samples_change_the_estimate_little():
    """100 ms of a constant push, sampled regularly, with every sample twice, or at random times."""
    reference = push(_core.Estimate(ARM, _core.EstimateOptions()), 0.0, 100)
    stamps = np.sort(np.random.default_rng(0).uniform(0.0, 0.099, 98))
    for times in (np.repeat(np.arange(100) * 1e-3, 2), np.concatenate([[0.0], stamps, [0.099]])):
        estimate = _core.Estimate(ARM, _core.EstimateOptions())
        for t in times:
            F_tip = estimate.step(t, Q0, np.zeros(6), ARM.gravity(Q0) + 0.1)
        np.testing.assert_allclose(F_tip, reference, rtol=1e-3)
    np.testing.assert_array_equal(estimate.step(0.3, Q0, np.zeros(6), ARM.gravity(Q0) + 0.1), np.zeros(3))


def test_identified_links_offset_and_spring_replace_those_of_the_model():
    """For an arm with other links, an offset and a spring, the estimate is zero only if the options include them."""
    pi = ARM.inertial_parameters * 1.2
    other = ARM.with_inertial_parameters(pi)
    offset, spring = np.full(6, 0.05), np.full(6, 0.2)
    tau = other.gravity(Q0) + offset + spring * Q0
    options = _core.EstimateOptions()
    for modelled, force in ((False, 0.1), (True, 0.0)):
        if modelled:
            options.links, options.offset, options.spring = pi, offset, spring
        estimate = _core.Estimate(ARM, options)
        for k in range(100):
            F = estimate.step(1e-3 * k, Q0, np.zeros(6), tau)
        assert np.linalg.norm(F) == pytest.approx(0.0, abs=1e-9) if modelled else np.linalg.norm(F) > force


def test_invalid_options_are_reported():
    with pytest.raises(ValueError, match="bandwidth must lie between 0 and 1000 Hz"):
        _core.MomentumObserver(ARM, np.zeros((6, 6)), 0.0)
    with pytest.raises(ValueError, match=r"drive_inertia must have shape \(6, 6\)"):
        _core.MomentumObserver(ARM, np.zeros((5, 5)), 20.0)
    options = _core.EstimateOptions()
    options.coulomb = np.full(6, -1.0)
    with pytest.raises(ValueError, match="estimate coulomb needs 6 finite entries, one per joint, none below zero"):
        _core.Estimate(ARM, options)
