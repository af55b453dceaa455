"""Equations 1 to 5: the master's dynamics in joint space and at the handle."""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate import _core, _reference
from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate_lab.reproduce.checks import Check, outcome
from palpate_lab.reproduce.item import Item, Outcome, Work

_SAMPLES = 40  # poses of each arm [-]
_H = 1e-4  # step of finite differences [rad]
_PINOCCHIO = "Pinocchio's computeAllTerms on the same URDF"
_DIFFERENCES = "central differences of fourth order"


def states(arm: Arm, seed: int, n: int = _SAMPLES) -> list[tuple[Array, Array]]:
    """Random joint positions and velocities (n,) around home, within 70 % of the way to the limits."""
    rng = np.random.default_rng(seed)
    low, high = 0.7 * arm.q_min + 0.3 * arm.home, 0.7 * arm.q_max + 0.3 * arm.home
    return [(rng.uniform(low, high), rng.normal(0.0, 1.0, arm.n)) for _ in range(n)]


@cache
def reference(arm: Arm) -> _reference.AllTerms:
    """Pinocchio's dynamics of the arm."""
    return _reference.AllTerms(arm.urdf, *arm.frames)


def slopes(f: object, q: Array) -> Array:
    """Derivatives of an array function f(q) by each joint, (n, ...), by central differences of fourth order."""
    assert callable(f)
    found = []
    for e in _H * np.eye(len(q)):
        near, far = np.asarray(f(q + e)) - f(q - e), np.asarray(f(q + 2 * e)) - f(q - 2 * e)
        found.append((8 * near - far) / (12 * _H))
    return np.array(found)


def coriolis(arm: Arm, q: Array, v: Array) -> tuple[Array, Array]:
    """C(q, v) by Christoffel symbols from differences of M, and dM/dt, each (n, n)."""
    dM = slopes(arm.mass_matrix, q)
    C = 0.5 * (np.einsum("kij,k->ij", dM, v) + np.einsum("jik,k->ij", dM, v) - np.einsum("ijk,k->ij", dM, v))
    return C, np.einsum("kij,k->ij", dM, v)


def eq1(work: Work) -> Outcome:
    """M, C, G and the law against Pinocchio and finite differences; free swing."""
    arm = Arm.mtm("right")
    pin, rng = reference(arm), np.random.default_rng(work.seed)
    M, bias, law, power, christoffel = [], [], [], [], []
    for q, v in states(arm, work.seed):
        M_pin, bias_pin, G_pin, _ = pin.compute(q, v)
        a = rng.normal(0.0, 2.0, arm.n)
        C, M_rate = coriolis(arm, q, v)
        M.append(np.abs(arm.mass_matrix(q) - M_pin).max())
        bias.append(np.abs(arm.bias(q, v) - bias_pin).max())
        law.append(np.abs(arm.inverse_dynamics(q, v, a) - (M_pin @ a + C @ v + G_pin)).max())
        power.append(abs(v @ (M_rate @ v - 2.0 * (arm.bias(q, v) - arm.gravity(q)))))
        christoffel.append(np.abs(C @ v - (bias_pin - G_pin)).max())
    checks = [
        Check("M(q)", _PINOCCHIO, np.array(M), 1e-12, "kg m²"),
        Check("C(q, q̇) q̇ + G(q)", _PINOCCHIO, np.array(bias), 1e-12, "N m"),
        Check("M q̈ + C q̇ + G = τ − τ_e", "M, G of Pinocchio, C by Christoffel symbols", np.array(law), 1e-8, "N m"),
        Check("C q̇ with a C for which Ṁ − 2C is skew", "Christoffel symbols against Pinocchio", np.array(christoffel),
              1e-8, "N m"),
        Check("C of the core does no work", _DIFFERENCES, np.array(power), 1e-8, "W"),
        Check("energy of a free swing", "kinetic plus potential energy over 0.2 s", _swing(arm), 1e-6),
    ]  # fmt: skip
    why = (
        "Both sides of the law agree to rounding. The Coriolis forces are those of the C for which Ṁ − 2C is "
        "skew-symmetric, so they do no work, and a free swing keeps its energy."
    )
    return outcome(checks, "the dynamic equation, as a definition", why)


def _swing(arm: Arm) -> Array:
    """Relative change of energy of the arm without friction, drives and hand (40,)."""
    options = arm.leader_options()
    options.coulomb, options.viscous, options.quantised = np.zeros(arm.n), np.zeros(arm.n), False
    hand = _core.HandOptions()
    hand.mass = hand.damping = hand.stiffness = hand.inertia = 0.0
    hand.rotational_damping = hand.rotational_stiffness = 0.0
    leader = _core.Leader(arm, options, hand)
    leader.reset(arm.home + 0.02)
    X, E, scale = arm.fk(arm.home), [], 0.0
    for _ in range(40):
        E.append(leader.energy)
        leader.step(2e-5, X, n=250)
        scale = max(scale, abs(leader.energy - arm.potential_energy(leader.q) - arm.elastic_energy(leader.q)))
    return np.abs(np.array(E) - E[0]) / max(scale, abs(E[0]))


def eq2(work: Work) -> Outcome:
    """The Cartesian form gives the acceleration of the joint form."""
    rng = np.random.default_rng(work.seed + 1)
    checks, damped = [], {}
    for name, task in (("mtm_right", 3), ("six_axis", 6)):
        arm, errors, singular_poses = Arm.model(name), [], 0
        pin = reference(arm)
        for q, v in states(arm, work.seed):
            Lambda, Gamma_v, eta, singular = (_core.cartesian_place if task == 3 else _core.cartesian)(arm, q, v)
            singular_poses += singular
            if singular:
                continue
            M, bias, _, J = pin.compute(q, v)
            drift = np.einsum("kij,k,j->i", slopes(arm.jacobian, q), v, v)[:task]
            F = rng.normal(size=task)
            joint = np.linalg.solve(M, J[:task].T @ F - bias)
            expected = J[:task] @ joint + drift
            ours = np.linalg.solve(Lambda, F - Gamma_v - eta)
            errors.append(np.abs(ours - expected).max() / max(1.0, np.abs(expected).max()))
        what = f"a of {name}, {task} dimensions"
        checks.append(Check(what, "a = J q̈ + J̇ q̇, q̈ of Pinocchio's joint dynamics", np.array(errors), 1e-7))
        damped[f"singular_poses_of_{name}"] = singular_poses
    why = (
        "Away from singular poses both forms give the same acceleration. At the others the inverse is damped, and the "
        "state says so."
    )
    return outcome(checks, "the dynamics at the end-effector", why, more={"poses": _SAMPLES, **damped})


def _six_axis(seed: int) -> list[tuple[Array, Array, Array, tuple[Array, Array, Array]]]:
    """States of an arm with an invertible Jacobian: q, v, J^-1 of Pinocchio, and (Lambda, Gamma v, eta) of the core."""
    arm, found = Arm.model("six_axis"), []
    for q, v in states(arm, seed, 3 * _SAMPLES):
        Lambda, Gamma_v, eta, singular = _core.cartesian(arm, q, v)
        J = reference(arm).compute(q, v)[3]
        if not singular and np.linalg.cond(J) < 1e3:
            found.append((q, v, np.asarray(np.linalg.inv(J), dtype=float), (Lambda, Gamma_v, eta)))
    return found[:_SAMPLES]


def eq3(work: Work) -> Outcome:
    """Lambda by the paper's formula with Pinocchio's M and J."""
    arm, mtm = Arm.model("six_axis"), Arm.mtm("right")
    six = []
    for q, v, inverse, (Lambda, _, _) in _six_axis(work.seed):
        expected = inverse.T @ reference(arm).compute(q, v)[0] @ inverse
        six.append(np.abs(Lambda - expected).max() / np.abs(expected).max())
    three = []
    for q, v in states(mtm, work.seed):
        Lambda, _, _, singular = _core.cartesian_place(mtm, q, v)
        M, _, _, J = reference(mtm).compute(q, v)
        expected = np.asarray(np.linalg.inv(J[:3] @ np.linalg.inv(M) @ J[:3].T), dtype=float)
        if not singular:
            three.append(np.abs(Lambda - expected).max() / np.abs(expected).max())
    checks = [
        Check("Λ of six_axis (6×6)", "J⁻ᵀ M J⁻¹ with Pinocchio's M, J", np.array(six), 1e-8),
        Check("Λ of the MTM's handle (3×3)", "(J M⁻¹ Jᵀ)⁻¹ with Pinocchio's M, J", np.array(three), 1e-8),
    ]
    return outcome(checks, "Λ = (J M⁻¹ Jᵀ)⁻¹", "The core's Λ is the paper's formula to rounding.")


def eq4(work: Work) -> Outcome:
    """Gamma v with C by Christoffel symbols and dJ/dt by differences."""
    arm, found, printed = Arm.model("six_axis"), [], []
    for q, v, inverse, (Lambda, Gamma_v, _) in _six_axis(work.seed):
        C, _ = coriolis(arm, q, v)
        J_dot = np.einsum("kij,k->ij", slopes(arm.jacobian, q), v)
        V = np.linalg.inv(inverse) @ v
        expected = (inverse.T @ C @ inverse - Lambda @ J_dot @ inverse) @ V
        literal = (inverse.T @ C @ inverse - Lambda @ arm.jacobian(v) @ inverse) @ V
        size = max(1.0, np.abs(expected).max())
        found.append(np.abs(Gamma_v - expected).max() / size)
        printed.append(np.abs(Gamma_v - literal).max() / size)
    check = Check("Γ v with J̇", "C by Christoffel symbols, J̇ by differences", np.array(found), 1e-7)
    why = (
        "Holds with J̇, the rate of the Jacobian. Read literally, as the Jacobian at the joint velocities, it would be "
        f"wrong by {np.median(printed):.1g} of its size (median)."
    )
    more = {"residual_of_the_literal_reading": float(np.median(printed))}
    return outcome([check], "Γ = J⁻ᵀ C J⁻¹ − Λ J(q̇) J⁻¹", why, more=more)


def eq5(work: Work) -> Outcome:
    """Eta with Pinocchio's G and J."""
    arm, six = Arm.model("six_axis"), []
    for q, v, inverse, (_, _, eta) in _six_axis(work.seed):
        expected = inverse.T @ reference(arm).compute(q, v)[2]
        six.append(np.abs(eta - expected).max() / max(1.0, np.abs(expected).max()))
    check = Check("η of six_axis", "J⁻ᵀ G with Pinocchio's G, J", np.array(six), 1e-8)
    return outcome([check], "η = J⁻ᵀ G", "The core's η is the paper's formula to rounding.")


_CODE = ("core/palpate/arm/recursion_body.inl", "core/palpate/torque/cartesian.cpp")
_PSEUDO = (
    "Near singular poses a damped inverse is used and reported, where the paper takes pseudo inverses. The MTM's "
    "handle "
    "is a point of three dimensions (section 2.3); the six-dimensional form is shown on an arm with six joints."
)

ITEMS = (
    Item("eq1", "Dynamics in joint space", "Section 2.3, Eq 1",
         "Inertia, Coriolis and gravity terms balance the torques of the motors and the external torques.",
         eq1, ("R13",), "τ is the torque of the motors; τ_e acts against it.", _CODE[:1]),
    Item("eq2", "Dynamics at the handle", "Section 2.3, Eq 2",
         "The same dynamics hold at the end-effector with a wrench in place of the torques.",
         eq2, ("R14", "R15"), _PSEUDO, _CODE),
    Item("eq3", "Inertia at the handle", "Section 2.3, Eq 3",
         "The inertia at the end-effector follows from the joint inertia and the Jacobian.",
         eq3, ("R14",), _PSEUDO, _CODE),
    Item("eq4", "Coriolis term at the handle", "Section 2.3, Eq 4",
         "The Coriolis term at the end-effector follows from that of the joints, less a term with the Jacobian's rate.",
         eq4, ("R14",), "The printed J(q̇) is read as J̇, the rate of the Jacobian.", _CODE),
    Item("eq5", "Gravity at the handle", "Section 2.3, Eq 5",
         "The gravity term at the end-effector is the joint gravity through the inverse transposed Jacobian.",
         eq5, ("R14",), "η is the Cartesian gravity term; that of the joints is called G here.", _CODE),
)  # fmt: skip
