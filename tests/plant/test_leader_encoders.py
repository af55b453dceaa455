"""Measurements of the leader (encoder counts, edge-timed velocities), and its drives."""

import numpy as np
import pytest
from driven_leader import driven_leader
from plant_constants import DT, Q0

from palpate import _core

ZERO = np.zeros(7)


def moving_leader(mtm, options, seconds, V):
    """The hand pulls the handle along V; the leader every millisecond after it caught up."""
    return driven_leader(mtm, options, V, seconds, stiffness=2000.0, damping=40.0, settled=300)


def test_positions_are_whole_counts_of_the_motors(mtm, options):
    A = np.array(options.coupling)
    for leader in moving_leader(mtm, options, 0.5, np.array([0.03, 0.02, -0.04, 0, 0, 0])):
        counts = np.linalg.solve(A, leader.q_measured) / options.encoder_step
        assert np.abs(counts - np.round(counts)).max() < 1e-6
        # The error is at most half a count of each motor, mapped by the coupling.
        assert (np.abs(leader.q_measured - leader.q) <= 0.5 * np.abs(A) @ options.encoder_step + 1e-12).all()


def test_velocity_between_edges_is_right_on_average_and_close_on_the_fine_joints(mtm, options):
    errors, speeds = [], []
    for leader in moving_leader(mtm, options, 0.8, np.array([0.05, 0.03, -0.02, 0, 0, 0])):
        errors.append(leader.v_measured - leader.v)
        speeds.append(leader.v)
    errors, speeds = np.array(errors), np.array(speeds)
    # Joints 1 to 3 have counts of 25 to 31 microradians, so edges come within a millisecond.
    assert np.abs(errors[:, :3]).max() < 0.02 * np.abs(speeds[:, :3]).max() + 2e-3
    assert np.abs(errors[:, :3].mean(axis=0)).max() < 1e-3


def test_velocity_decays_when_no_edge_comes(mtm, options):
    """A wrist joint that stops between two counts: |v| <= step / time since the last edge."""
    hand = _core.HandOptions()
    leader = _core.Leader(mtm, options, hand)
    leader.reset(Q0)
    X = mtm.fk(Q0)
    spin = X.copy()
    for k in range(200):  # rotation about the roll axis, then a stop
        c, s = np.cos(1e-2 * k), np.sin(1e-2 * k)
        spin[:3, :3] = X[:3, :3] @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        leader.command(ZERO, mtm.holding(leader.q), ZERO)
        leader.step(DT, spin, n=10)
    assert abs(leader.v_measured[6]) > 1.0
    for _ in range(1000):
        leader.command(ZERO, mtm.holding(leader.q), ZERO)
        leader.step(DT, spin, n=10)
    assert not leader.v.any()
    # At least 0.5 s without an edge means at most one count in this time.
    assert np.abs(leader.v_measured[4:]).max() <= options.encoder_step[4:].max() / 0.5


def test_encoders_without_quantisation_are_exact(mtm, options):
    options.quantised = False
    for leader in moving_leader(mtm, options, 0.4, np.array([0.03, 0.02, -0.04, 0, 0, 0])):
        assert np.array_equal(leader.q_measured, leader.q)
        assert np.array_equal(leader.v_measured, leader.v)


def test_pinch_is_reported(mtm, options):
    leader = _core.Leader(mtm, options)
    leader.reset(Q0)
    leader.pinch(0.4)
    leader.step(DT, mtm.fk(Q0))
    assert leader.gripper == 0.4
    assert leader.t == pytest.approx(DT)


# ---------------------------------------------------------------- drives
def first_motion(mtm, options, no_hand, dt):
    """Servo periods between a force command and the first motion of joint 1."""
    leader = _core.Leader(mtm, options, no_hand)
    leader.reset(Q0)
    tau = np.zeros(7)
    tau[0] = 0.5
    leader.command(tau, mtm.holding(Q0), ZERO)
    for k in range(1000):
        leader.step(dt, mtm.fk(Q0))
        if leader.v[0] > 1e-4:
            return k
    return None


@pytest.mark.parametrize(
    ("delay", "dt", "periods"), [(0.0, 1e-4, 0), (1e-4, 1e-4, 1), (0.01, 1e-4, 100), (0.01, 5e-5, 200)]
)
def test_force_command_is_delayed_by_whole_periods(mtm, options, no_hand, delay, dt, periods):
    options.loop_delay = delay
    assert first_motion(mtm, options, no_hand, dt) == periods


def test_missing_commands_ramp_the_force_down_and_keep_gravity_compensation(mtm, frictionless):
    leader = _core.Leader(mtm, frictionless, _core.HandOptions())
    leader.reset(Q0)
    X, F = mtm.fk(Q0), np.array([0, 0, 2.0, 0, 0, 0])
    for _ in range(1000):
        leader.command(mtm.jacobian(leader.q).T @ F, mtm.holding(leader.q), ZERO)
        leader.step(DT, X, n=10)
    assert leader.load_cell[2] == pytest.approx(2.0, rel=0.02)
    leader.step(DT, X, n=295)  # 30 ms of silence are allowed
    assert leader.load_cell[2] == pytest.approx(2.0, rel=0.02)
    leader.step(DT, X, n=8000)
    # The 2 N are gone. The remaining error is the gravity of the pose at the last command, which differs a little here.
    assert abs(leader.load_cell[2]) < 0.3


def test_drive_limits_bound_the_torque(mtm, frictionless, no_hand):
    leader = _core.Leader(mtm, frictionless, no_hand)
    leader.reset(Q0)
    leader.command(np.full(7, 100.0), ZERO, ZERO)
    leader.step(1e-6, mtm.fk(Q0))
    M = mtm.mass_matrix(Q0) + np.diag(frictionless.rotor_inertia)
    J = mtm.jacobian(Q0)
    M += J.T @ np.diag([no_hand.mass] * 3 + [no_hand.inertia] * 3) @ J
    tau = M @ leader.v / 1e-6 + mtm.holding(Q0)
    assert np.allclose(tau, frictionless.tau_max, atol=1e-6)


def test_command_that_is_not_finite_is_rejected(mtm, options, no_hand):
    leader = _core.Leader(mtm, options, no_hand)
    leader.reset(Q0)
    leader.command(ZERO, mtm.holding(Q0), ZERO)
    leader.command(np.full(7, np.nan), mtm.holding(Q0), ZERO)
    leader.step(DT, mtm.fk(Q0), n=100)
    assert np.array_equal(leader.q, Q0)
