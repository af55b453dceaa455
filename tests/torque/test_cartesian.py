"""The arm's dynamics at the handle (Eqs 1-5), against the dynamics in joint space and energy."""

import numpy as np
import pytest

import palpate
from palpate import _core

H = 1e-4
ARMS = ["mtm_right", "six_axis", "delta"]


@pytest.fixture(scope="module", params=ARMS)
def arm(request):
    return palpate.Arm.model(request.param)


def states(arm, n=30, seed=5):
    rng = np.random.default_rng(seed)
    return [(rng.uniform(0.7 * arm.q_min + 0.3 * arm.home, 0.7 * arm.q_max + 0.3 * arm.home), rng.normal(0, 1, arm.n))
            for _ in range(n)]  # fmt: skip


def coriolis(arm, q, v):
    """C(q, v) from Christoffel symbols by fourth-order finite differences of M."""
    M = arm.mass_matrix
    near = [8 * (M(q + H * e) - M(q - H * e)) for e in np.eye(arm.n)]
    far = [M(q + 2 * H * e) - M(q - 2 * H * e) for e in np.eye(arm.n)]
    dM = (np.array(near) - np.array(far)) / (12 * H)
    C = 0.5 * (np.einsum("kij,k->ij", dM, v) + np.einsum("jik,k->ij", dM, v) - np.einsum("ijk,k->ij", dM, v))
    return C, np.einsum("kij,k->ij", dM, v)


def test_mass_matrix_is_symmetric_and_positive(arm):
    for q, _ in states(arm):
        M = arm.mass_matrix(q)
        assert np.abs(M - M.T).max() < 1e-15
        assert np.linalg.eigvalsh(M)[0] > 0


def test_mass_matrix_rate_minus_twice_coriolis_is_skew(arm):
    """C v agrees with the bias of the core (Eq 1)."""
    for q, v in states(arm, 10):
        C, M_rate = coriolis(arm, q, v)
        bias = arm.bias(q, v) - arm.gravity(q)
        assert np.abs(C @ v - bias).max() < 1e-9 * max(1, np.abs(bias).max())
        S = M_rate - 2 * C
        assert np.abs(S + S.T).max() < 1e-10
        assert abs(v @ (M_rate @ v - 2 * bias)) < 1e-8  # the C of the core has no power


def test_gravity_agrees_with_newton_euler(arm):
    for q, _ in states(arm):
        assert np.abs(arm.inverse_dynamics(q, 0 * q, 0 * q) - arm.gravity(q)).max() < 1e-9
        slope = [(8 * (arm.potential_energy(q + H * e) - arm.potential_energy(q - H * e))
                  - (arm.potential_energy(q + 2 * H * e) - arm.potential_energy(q - 2 * H * e))) / (12 * H)
                 for e in np.eye(arm.n)]  # fmt: skip
        assert np.abs(arm.gravity(q) - slope).max() < 1e-9


@pytest.mark.parametrize("task", [3, 6])
def test_cartesian_and_joint_form_give_the_same_acceleration(arm, task):
    """Eqs 2-5 with torques and an external wrench give the tip acceleration J q'' + J' q' of Eq 1."""
    if arm.n < task:
        pytest.skip("an arm of three joints has no six-dimensional task")
    rng = np.random.default_rng(6)
    cartesian = _core.cartesian_place if task == 3 else _core.cartesian
    compared = 0
    for q, v in states(arm):
        rotor = rng.uniform(0, 1e-3, arm.n)
        Lambda, Gamma_v, eta, singular = cartesian(arm, q, v, rotor)
        if singular:
            continue
        compared += 1
        M, bias, _, J, drift = arm.dynamics(q, v)
        M = M + np.diag(rotor)
        J, drift = J[:task], drift[:task]
        F_m, F_e = rng.normal(size=(2, task))
        joint = np.linalg.solve(M, J.T @ (F_m + F_e) - bias)
        expected = J @ joint + drift
        assert np.allclose(Lambda @ expected, F_m + F_e - Gamma_v - eta, atol=1e-8)
        assert np.allclose(
            np.linalg.solve(Lambda, F_m + F_e - Gamma_v - eta), expected, atol=1e-8 * np.abs(expected).max()
        )
    assert compared >= 10


def test_arms_with_invertible_jacobians_follow_the_papers_equations():
    """Eqs 3-5 literally, for an invertible J."""
    arm = palpate.Arm.model("six_axis")
    for q, v in states(arm, 20):
        Lambda, Gamma_v, eta, singular = _core.cartesian(arm, q, v)
        J = arm.jacobian(q)
        if singular or np.linalg.cond(J) > 1e3:
            continue
        inverse = np.linalg.inv(J)
        drift = arm.dynamics(q, v)[4]
        assert np.allclose(Lambda, np.linalg.inv(J @ np.linalg.inv(arm.mass_matrix(q)) @ J.T), rtol=1e-7, atol=1e-8)
        assert np.allclose(Gamma_v, inverse.T @ (arm.bias(q, v) - arm.gravity(q)) - Lambda @ drift, atol=1e-7)
        assert np.allclose(eta, inverse.T @ arm.gravity(q), atol=1e-7)


def test_singular_arm_is_damped_and_reports_it():
    arm = palpate.Arm.model("six_axis")
    q = np.array([0.3, 0.4, 0.0, 0.0, 0.0, 0.0])  # the arm is straight
    Lambda, Gamma_v, eta, singular = _core.cartesian_place(arm, q, np.ones(6))
    assert singular
    assert np.linalg.eigvalsh(Lambda)[-1] == pytest.approx(20.0)
    assert np.isfinite([*Gamma_v, *eta]).all()
    out, status = _core.Torque(_core.TorqueOptions(), arm.tau_max).step(arm, q, np.ones(6), np.zeros(6))
    assert status & palpate.record.ticks.STATUS["singular"][0]
    assert np.isfinite(out.tau).all()
    bent = arm.home
    assert not _core.cartesian_place(arm, bent, np.ones(6))[3]


@pytest.mark.parametrize("name", ARMS)
def test_free_swing_keeps_its_energy(name):
    """Without friction, drives and hand the relative drift is below 1e-6 in two seconds."""
    arm = palpate.Arm.model(name)
    options = arm.leader_options()
    options.coulomb, options.viscous, options.quantised = np.zeros(arm.n), np.zeros(arm.n), False
    hand = _core.HandOptions()
    hand.mass = hand.damping = hand.stiffness = hand.inertia = 0.0
    hand.rotational_damping = hand.rotational_stiffness = 0.0
    leader = _core.Leader(arm, options, hand)
    leader.reset(arm.home + (0.0 if name == "delta" else 0.02))
    X, E = arm.fk(arm.home), []
    scale = 0.0
    for _ in range(40):
        E.append(leader.energy)
        leader.step(2e-5, X, n=250)
        scale = max(scale, abs(leader.energy - arm.potential_energy(leader.q) - arm.elastic_energy(leader.q)))
        if (leader.q <= arm.q_min + 1e-3).any() or (leader.q >= arm.q_max - 1e-3).any():
            break
    assert scale > 1e-3  # control: the arm swings
    assert np.abs(np.array(E) - E[0]).max() < 1e-6 * max(scale, abs(E[0]))
