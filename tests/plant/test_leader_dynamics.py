"""Dynamics of the simulated leader: energy, friction, stiction, end stops, load cell."""

import numpy as np
import pytest
from plant_constants import DT, Q0

from palpate import _core

ZERO = np.zeros(7)


def gravity_only(leader, arm):
    leader.command(ZERO, arm.holding(leader.q), ZERO)


def push(leader, tau_force, hold, X, milliseconds):
    """Apply constant torques, commanded again every millisecond as by a controller."""
    for _ in range(milliseconds):
        leader.command(tau_force, hold, ZERO)
        leader.step(DT, X, n=10)


def test_free_swing_keeps_its_energy(mtm, frictionless, no_hand):
    """0.25 s of free fall before an end stop: the relative drift of kinetic + potential energy is below 1e-6."""
    leader = _core.Leader(mtm, frictionless, no_hand)
    leader.reset(Q0)
    start, X = leader.energy, mtm.fk(Q0)
    swing = mtm.potential_energy(Q0)
    for _ in range(50):
        leader.step(DT, X, n=50)
        swing = max(swing, mtm.potential_energy(Q0) - mtm.potential_energy(leader.q))
        assert abs(leader.energy - start) < 1e-6 * abs(start)
    assert np.abs(leader.v).max() > 0.5  # control: the arm swings


def test_halving_the_step_quarters_the_error(mtm, frictionless, no_hand):
    """The midpoint step has second order: the errors against a ten times finer run decrease by four."""
    X, ends = mtm.fk(Q0), {}
    for dt in (4e-4, 2e-4, 2e-5):
        leader = _core.Leader(mtm, frictionless, no_hand)
        leader.reset(Q0)
        leader.step(dt, X, n=round(0.2 / dt))
        ends[dt] = leader.q
    coarse, fine = (np.abs(ends[dt] - ends[2e-5]).max() for dt in (4e-4, 2e-4))
    assert 3.0 < coarse / fine < 5.0


def test_acceleration_is_forward_dynamics(mtm, frictionless, no_hand):
    """Half a millisecond from rest, v = h (M + rotors + J^T M_hand J)^-1 (tau - G), computed in numpy."""
    no_hand.mass, no_hand.inertia = 0.2, 3e-4
    leader = _core.Leader(mtm, frictionless, no_hand)
    leader.reset(Q0)
    tau = np.array([0.2, -0.1, 0.15, 0.02, -0.01, 0.01, 0.005])
    leader.command(tau, ZERO, ZERO)
    leader.step(1e-6, mtm.fk(Q0))
    J = mtm.jacobian(Q0)
    M = mtm.mass_matrix(Q0) + np.diag(frictionless.rotor_inertia) + J.T @ np.diag([0.2] * 3 + [3e-4] * 3) @ J
    assert np.allclose(leader.v / 1e-6, np.linalg.solve(M, tau - mtm.holding(Q0)), rtol=1e-9)


def test_friction_only_dissipates(mtm, options, no_hand):
    leader = _core.Leader(mtm, options, no_hand)
    leader.reset(Q0)
    energy, X = leader.energy, mtm.fk(Q0)
    for _ in range(1000):
        leader.step(DT, X)
        assert leader.energy <= energy + 1e-9
        energy = leader.energy


def test_work_of_the_drives_and_losses_of_friction_balance(mtm, options, no_hand):
    """Energy gain = work of the torques - dissipation, with the dissipation from the friction law."""
    leader = _core.Leader(mtm, options, no_hand)
    leader.reset(Q0)
    X, start, work = mtm.fk(Q0), leader.energy, 0.0
    tau = 1.5 * options.coulomb
    for _ in range(1000):
        leader.command(tau, mtm.holding(Q0), ZERO)
        before_v, before_q = leader.v, leader.q
        leader.step(DT, X)
        v = 0.5 * (before_v + leader.v)
        work += (tau + mtm.holding(Q0)) @ (leader.q - before_q)
        work -= DT * (options.coulomb @ np.abs(v) + options.viscous @ v**2)
    assert leader.energy - start == pytest.approx(work, rel=2e-3)


def test_resting_arm_does_not_move(mtm, options, no_hand):
    """Torques below the Coulomb friction change no bit of the position, and there is no chatter."""
    leader = _core.Leader(mtm, options, no_hand)
    leader.reset(Q0)
    for _ in range(500):
        push(leader, 0.9 * options.coulomb * [1, -1, 1, -1, 1, -1, 1], mtm.holding(Q0), mtm.fk(Q0), 1)
        assert not leader.v.any()
    assert np.array_equal(leader.q, Q0)


def test_joint_moves_above_friction_and_then_stays_at_rest(mtm, options, no_hand):
    leader = _core.Leader(mtm, options, no_hand)
    leader.reset(Q0)
    X = mtm.fk(Q0)
    tau = np.zeros(7)
    tau[0] = 1.5 * options.coulomb[0]
    push(leader, tau, mtm.holding(Q0), X, 100)
    assert leader.v[0] > 1e-3
    push(leader, ZERO, mtm.holding(leader.q), X, 300)
    rest = leader.q
    assert not leader.v.any()
    push(leader, ZERO, mtm.holding(leader.q), X, 200)
    assert np.array_equal(leader.q, rest)


def test_gravity_compensation_holds_the_frictionless_arm(mtm, frictionless, no_hand):
    leader = _core.Leader(mtm, frictionless, no_hand)
    leader.reset(Q0)
    for _ in range(1000):
        gravity_only(leader, mtm)
        leader.step(DT, mtm.fk(Q0), n=10)
    assert np.abs(leader.q - Q0).max() < 1e-9


def test_wrong_gravity_model_lets_the_arm_sink(mtm, frictionless, no_hand):
    model = mtm.with_scaled_masses(np.full(7, 0.8))
    leader = _core.Leader(mtm, frictionless, no_hand)
    leader.reset(Q0)
    for _ in range(100):
        gravity_only(leader, model)
        leader.step(DT, mtm.fk(Q0), n=10)
    assert mtm.potential_energy(leader.q) < mtm.potential_energy(Q0) - 1e-3


@pytest.mark.parametrize("F", [(2, 0, 0), (0, -1.5, 0), (0, 0, 2.5), (-0.7, 1.1, 0.4)])
def test_load_cell_reads_the_rendered_force_at_rest(mtm, frictionless, F):
    """Gravity and J^T F of the present pose, with 1.5 s of settling against the hand."""
    leader = _core.Leader(mtm, frictionless, _core.HandOptions())
    leader.reset(Q0)
    X, wrench = mtm.fk(Q0), np.r_[F, 0, 0, 0]
    for _ in range(1500):
        q = leader.q
        leader.command(mtm.jacobian(q).T @ wrench, mtm.holding(q), ZERO)
        leader.step(DT, X, n=10)
    assert np.linalg.norm(leader.load_cell[:3] - F) < 0.01 * np.linalg.norm(F)
    # The hand's spring deflects by F / K.
    moved = mtm.fk(leader.q)[:3, 3] - X[:3, 3]
    assert np.allclose(moved, np.array(F) / _core.HandOptions().stiffness, atol=1e-4)


def test_friction_hides_small_forces_from_the_load_cell(mtm, options):
    """A force below the friction of the arm (0.04 to 0.2 N) does not reach the hand; a large one does nearly."""
    leader = _core.Leader(mtm, options, _core.HandOptions())
    for F, least, most in ((0.02, 0.0, 0.001), (3.0, 2.6, 3.4)):
        leader.reset(Q0)
        X = mtm.fk(Q0)
        for _ in range(800):
            leader.command(mtm.jacobian(leader.q).T @ [F, 0, 0, 0, 0, 0], mtm.holding(leader.q), ZERO)
            leader.step(DT, X, n=10)
        assert least <= np.linalg.norm(leader.load_cell[:3]) <= most


def test_load_cell_is_newtons_law_for_the_hand(mtm, options, no_hand):
    """Without spring and damper the force of the arm on the hand is mass times acceleration."""
    leader = _core.Leader(mtm, options, no_hand)
    leader.reset(Q0)
    leader.step(DT, mtm.fk(Q0), n=500)
    p = []
    for _ in range(3):
        p.append(mtm.fk(leader.q)[:3, 3])
        cell = leader.load_cell
        leader.step(DT, mtm.fk(Q0))
    acceleration = (p[2] - 2 * p[1] + p[0]) / DT**2
    assert np.allclose(cell[:3], no_hand.mass * acceleration, atol=0.02 * np.linalg.norm(cell[:3]) + 1e-4)


def test_end_stops_stop_and_release_a_joint(mtm, options, no_hand):
    leader = _core.Leader(mtm, options, no_hand)
    leader.reset(Q0)
    X, tau = mtm.fk(Q0), np.zeros(7)
    for sign, stop in ((1.0, mtm.q_max), (-1.0, mtm.q_min)):
        tau[4] = sign * 0.09
        for _ in range(200):
            push(leader, tau, mtm.holding(leader.q), X, 5)
            assert (leader.q <= mtm.q_max).all()
            assert (leader.q >= mtm.q_min).all()
        assert leader.q[4] == stop[4]
        assert leader.v[4] == 0.0


def test_a_stiff_hand_on_a_light_wrist_is_stable(mtm, options):
    hand = _core.HandOptions()
    hand.stiffness, hand.damping, hand.mass = 1e5, 500.0, 1e-3
    hand.rotational_stiffness, hand.rotational_damping, hand.inertia = 500.0, 5.0, 1e-7
    hand.grip_force_max = 1e6
    leader = _core.Leader(mtm, options, hand)
    leader.reset(Q0)
    X = mtm.fk(Q0)
    X[:3, 3] += [1e-3, -2e-3, 1e-3]
    push(leader, ZERO, mtm.holding(Q0), X, 500)
    assert np.linalg.norm(mtm.fk(leader.q)[:3, 3] - X[:3, 3]) < 1e-4
    assert np.abs(leader.v).max() < 1e-3


def test_the_hand_slips_above_its_grip_force(mtm, options):
    hand = _core.HandOptions()
    hand.grip_force_max = 4.0
    leader = _core.Leader(mtm, options, hand)
    leader.reset(Q0)
    X = mtm.fk(Q0)
    leader.step(DT, X, n=10)
    assert not leader.hand_slipped
    X[:3, 3] += [0, 0, 0.1]  # the spring force would be 300 N/m x 0.1 m = 30 N
    leader.step(DT, X)
    assert leader.hand_slipped
    leader.step(DT, X, n=20000)
    assert np.isfinite(leader.q).all()


def test_hand_path_leads_the_handle(mtm, options):
    """The handle follows a moving hand within the deflection of the hand's spring."""
    leader = _core.Leader(mtm, options, _core.HandOptions())
    leader.reset(Q0)
    X = mtm.fk(Q0)
    V = np.array([0.05, 0, 0, 0, 0, 0])
    for _ in range(500):
        X[:3, 3] += V[:3] * 1e-3
        leader.command(ZERO, mtm.holding(leader.q), ZERO)
        leader.step(DT, X, V, n=10)
    assert np.linalg.norm(mtm.fk(leader.q)[:3, 3] - X[:3, 3]) < 3e-3
    assert np.linalg.norm(mtm.jacobian(leader.q)[:3] @ leader.v - V[:3]) < 5e-3


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("coulomb", np.zeros(6), r"leader coulomb needs 7 entries.*got 6"),
        ("viscous", -np.ones(7), "leader viscous must be at least zero"),
        ("tau_max", np.zeros(7), "leader tau_max must be above zero"),
        ("coupling", np.zeros((7, 7)), "leader coupling must be an invertible 7 x 7"),
        ("loop_delay", 2.0, r"loop_delay must lie in 0..1 s; got 2"),
        ("loop_jitter", -0.1, r"loop_jitter must lie in 0..1 s; got -0.1 s"),
        ("drive_lag", float("nan"), r"drive_lag must lie in 0..1 s; got nan"),
        ("velocity_cutoff", -1.0, r"velocity_cutoff must lie in 0..100000 Hz; got -1 Hz"),
        ("hold_timeout", 0.0, "hold_timeout must be above zero"),
    ],
)
def test_invalid_options_are_reported(mtm, options, field, value, message):
    setattr(options, field, value)
    with pytest.raises(ValueError, match=message):
        _core.Leader(mtm, options)
