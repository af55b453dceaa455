"""Equations 6 to 9 and 13: the haptic force, its frames, and the controller."""

from __future__ import annotations

import numpy as np

from palpate import _core
from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate_lab.reproduce.checks import Check, outcome
from palpate_lab.reproduce.item import Item, Outcome, Work
from palpate_lab.reproduce.items.dynamics import reference, states
from palpate_lab.reproduce.items.palpation import palpation, rotations

_SAMPLES = 200  # random contacts [-]


def _law(K: Array, B: Array, n: Array, delta_x: Array, v: Array) -> tuple[Array, Array, Array]:
    """Force, spring and damping part of one contact at rest, each (3,), by the core's force stage."""
    F, spring, damping, _ = _core.force(K[None], B[None], n[None], delta_x[None], v, np.zeros((1, 3)))
    return F, spring, damping


def _contacts(seed: int) -> list[tuple[Array, Array, Array, Array, Array]]:
    """Random contacts: K (3,) [N/m], B (3,) [N s/m], normal, deflection [m], and velocity of the tool [m/s]."""
    rng, found = np.random.default_rng(seed), []
    for _ in range(_SAMPLES):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        found.append((rng.uniform(100, 800, 3), rng.uniform(0, 10, 3), n, rng.uniform(1e-3, 1e-2) * n,
                      rng.normal(0, 0.02, 3)))  # fmt: skip
    return found


def eq6(work: Work) -> Outcome:
    """Spring and damper of random contacts, and the sign of the damping power."""
    spring_error, equal_gains, unequal_gains, power, printed = [], [], [], [], 0
    for K, B, n, delta_x, v in _contacts(work.seed):
        along = n * (n @ v)  # Algorithm 1, line 8
        _, spring, damping = _law(K, B, n, delta_x, v)
        spring_error.append(np.abs(spring - K * delta_x).max())
        unequal_gains.append(np.abs(damping + B * along).max())
        equal = np.full(3, B[0])
        damping = _law(K, equal, n, delta_x, v)[2]
        if n @ (spring - equal * along) >= 0.0:  # otherwise the law would pull, and the core renders nothing
            equal_gains.append(np.abs(damping + equal * along).max())
        power.append(max(0.0, float(damping @ along)))
        printed += float((equal * along) @ along) > 0.0
    p = palpation(work.seed)
    touching = p["depth"] > 0.0
    recorded = np.abs(p["F_T_W"] - p["F_spring_W"] - p["F_damping_W"])[touching].max(axis=1)
    checks = [
        Check("K δx", "numpy, component by component", np.array(spring_error), 1e-12, "N"),
        Check("−B ẋ, equal gains", "numpy, component by component", np.array(equal_gains), 1e-12, "N"),
        Check("power of the damping, positive part", "its work on the tool must not be positive", np.array(power),
              1e-15, "W"),
        Check("F in the record of a palpation", "sum of its recorded spring and damping parts", recorded, 1e-12, "N"),
    ]  # fmt: skip
    why = (
        "The law holds with the damping against the motion. With the printed plus sign and the velocity of the tool, "
        f"the damping would drive the tool in {100 * printed / _SAMPLES:.0f} % of the contacts. For unequal damping "
        "gains, which the paper does not try, the core keeps the damping along the normal, and a force that would pull "
        f"is zero (up to {max(unequal_gains):.2g} N apart in {_SAMPLES} random contacts)."
    )
    more = {
        "contacts_driven_by_the_printed_sign_percent": 100 * printed / _SAMPLES,
        "difference_for_unequal_damping_N": max(unequal_gains),
    }
    return outcome(checks, "F = H K δx + H B δẋ", why, more=more)


def eq7(work: Work) -> Outcome:
    """The chain of frames, from Pinocchio's kinematics and from a record."""
    p = palpation(work.seed)
    arm, touching = p.setup.arms.leader, p["depth"] > 0.0
    R_LH, F_L, F_H = rotations(p["quat_LH"])[touching], p["F_H_L"][touching], p["F_H_H"][touching]
    R_WL = p.setup.arms.X_WL[:3, :3]
    body = np.abs(F_H - np.einsum("kji,kj->ki", R_LH, F_L)).max(axis=1)
    norms = np.abs(np.linalg.norm(F_H, axis=1) - np.linalg.norm(F_L, axis=1))
    own = np.array([arm.fk(q)[:3, :3] for q in p["q"][touching]])
    pose = np.abs(own - R_LH).reshape(len(own), -1).max(axis=1)
    direction = _angles(F_L @ R_WL.T, p["F_T_W"][touching])
    wrist = _turned_wrist(work.seed)
    checks = [
        Check("F_H = R_HL(q) F_L", "the recorded attitude of the handle", body, 1e-12, "N"),
        Check("|F_H| = |F_L|", "norms in both frames", norms, 1e-12, "N"),
        Check("attitude of the handle", "forward kinematics of the recorded joints", pose, 1e-9),
        Check("F_L is the tool's force through the constant H_ps^ms", "angle to R_WLᵀ F_T_W", direction, 1e-6, "rad"),
        Check("turning the wrist leaves F_L", "spatial force at 200 wrist attitudes, same F_T_W", wrist, 1e-15, "N"),
    ]
    why = (
        "The transformation is the product of a constant one between the bases and one that depends on the joints. "
        "Only the body-frame force turns with the wrist."
    )
    return outcome(checks, "H_ps^mb(q) = H_ms^mb(q) H_ps^ms", why)


def _angles(a: Array, b: Array) -> Array:
    """Angles (n,) between the rows of two arrays (n, 3) [rad]; rows of no length give 0."""
    cross, dot = np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1)
    return np.where(np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1) > 0.0, np.arctan2(cross, dot), 0.0)


def _turned_wrist(seed: int) -> Array:
    """Spread (200,) of the spatial force of one tool force over wrist attitudes [N]."""
    arm, rng = Arm.mtm("right"), np.random.default_rng(seed)
    options = _core.MappingOptions()
    mapping = _core.Mapping(options, np.eye(3), 1e-3)
    F_T_W = np.array([0.3, -0.7, 1.1])
    first, spread = mapping.force_on_hand(F_T_W), []
    for _ in range(200):
        q = arm.home.copy()
        q[3:] = rng.uniform(arm.q_min, arm.q_max)[3:]
        X = arm.fk(q)
        mapping.step(X, np.zeros(3), 0.0, np.eye(4))
        spread.append(np.abs(mapping.force_on_hand(F_T_W) - first).max())
    return np.array(spread)


def eq8(work: Work) -> Outcome:
    """Pushes along each axis, and the cross terms."""
    rng = np.random.default_rng(work.seed)
    own, cross, damped = [], [], []
    for _ in range(_SAMPLES):
        K, B, axis = rng.uniform(100, 800, 3), rng.uniform(0.5, 10, 3), int(rng.integers(3))
        n, depth, speed = np.eye(3)[axis] * rng.choice([-1.0, 1.0]), rng.uniform(1e-3, 1e-2), rng.uniform(0.005, 0.05)
        _, spring, damping = _law(K, B, n, depth * n, -speed * n)
        own.append(abs(spring @ n / (K[axis] * depth) - 1.0))
        damped.append(abs(damping @ n / (B[axis] * speed) - 1.0))
        cross.append(np.abs(np.delete(spring + damping, axis)).max())
    checks = [
        Check("F_i = K_i δ_i", "closed form, along each axis", np.array(own), 1e-3),
        Check("F_i = B_i v_i", "closed form, along each axis", np.array(damped), 1e-3),
        Check("cross terms", "must be zero for diagonal K and B", np.array(cross), 1e-15, "N"),
    ]
    return outcome(checks, "K and B are diagonal", "Each axis has its own spring and damper, and none acts on another.")


def eq9(work: Work) -> Outcome:
    """The load cell in the simulated hand against the rendered force, at rest and on the whole run."""
    from palpate_lab.studies.wall.bench import KP, Setting, WallPress, press

    hand, errors = WallPress.fitted(), []
    for kd in (5.0, 10.0):
        for push in (0.8, 1.2, 2.4):
            setting = Setting(kd, coulomb_scale=0.0)
            trace = press(setting, hand.scaled(push_N=push / hand.push_N, delay_s=0.1), follow=False)
            last = trace.t > trace.t[-1] - 0.2
            depth = trace.y[last] - 0.385
            errors.append(abs(float(trace.F_cell[last].mean()) / (KP * float(depth.mean())) - 1.0))
    arm, rng = Arm.mtm("right"), np.random.default_rng(work.seed)
    torque = _core.Torque(_zeroed(), 1e3 * arm.tau_max)
    reaction = []
    for q, _ in states(arm, work.seed):
        F = np.r_[rng.normal(0.0, 2.0, 3), 0.0, 0.0, 0.0]
        tau = torque.step(arm, q, np.zeros(arm.n), F)[0].tau
        M, _, G, J = reference(arm).compute(q, np.zeros(arm.n))
        held = tau - G - arm.elastic(q) - J.T @ F  # the hand pushes back with -F: the arm stays at rest
        reaction.append(np.abs(np.linalg.solve(M, held)).max())
    checks = [
        Check("load cell over 400 N/m times depth, at rest", "six presses of the wall on an arm without dry friction",
              np.array(errors), 0.01),
        Check("acceleration of an arm that renders F on a hand that holds it", "Pinocchio's M, G, J",
              np.array(reaction), 1e-9, "rad/s²"),
    ]  # fmt: skip
    why = (
        "At rest the hand feels the haptic force, and the arm carries its own weight. With the dry friction of the MTM "
        "the load cell may differ by that friction: the study of the wall measures 400 to 470 N/m."
    )
    return outcome(checks, "Λ a + Γ v + η = F − H⁻¹ F_haptic", why)


def _zeroed() -> _core.TorqueOptions:
    """Torque options with the force and gravity terms alone."""
    options = _core.TorqueOptions()
    options.platform_gain = options.limits.gain = 0.0
    limits = options.limits
    limits.gain = 0.0
    options.limits = limits
    return options


def eq13(work: Work) -> Outcome:
    """Both terms of the controller in a record, against Pinocchio."""
    p = palpation(work.seed)
    arm, n = p.setup.arms.leader, p.setup.arms.leader.n
    ticks = np.flatnonzero(p["depth"] > 0.0)[::10]
    force, gravity, wrist = [], [], []
    for k in ticks:
        q = p["q"][k][:n]
        _, _, G, J = reference(arm).compute(q, np.zeros(n))
        expected = (J[:3].T @ p["F_H_L"][k])[:3]
        force.append(np.abs(p["tau_force"][k][:3] - expected).max())
        gravity.append(np.abs(p["tau_gravity"][k][:3] - (G + arm.elastic(q))[:3]).max())
        wrist.append(np.abs(p["tau"][k][3:]).max())
    terms = ("tau_force", "tau_gravity", "tau_platform", "tau_friction", "tau_limits")
    total = np.abs(p["tau"] - sum(p[name] for name in terms)).max(axis=1)
    checks = [
        Check("Jᵀ F, first three joints", "Pinocchio's Jacobian and the recorded force", np.array(force), 1e-9, "N m"),
        Check("Υ Π_E, first three joints", "Pinocchio's G and the model's counterbalance", np.array(gravity), 1e-9,
              "N m"),
        Check("torques of the wrist", "exactly zero: forces only (section 2.3)", np.array(wrist), 0.0, "N m"),
        Check("τ is the sum of its recorded terms", "numpy", total, 1e-12, "N m"),
    ]  # fmt: skip
    share = float(np.mean(p["F_neglected"][ticks])) if len(ticks) else 0.0
    why = (
        "Holds in joint torques, τ = Jᵀ F + Ĝ(q). The printed (Jᵀ)† multiplies the gravity torque to give a force, "
        "which is the same thing where J has full rank. The slow-motion assumption neglects "
        f"{share:.2f} N of inertia on average in this run."
    )
    return outcome(checks, "F = (Jᵀ)† Υ Π_E + H (K δx − B ẋ)", why, more={"mean_neglected_N": share})


_FORCE = ("core/palpate/force/force.cpp",)
_READ_6 = (
    "δx points from the tool to the proxy, out of the obstacle. The damping acts against the tool's velocity along the "
    "normal; the printed + B ∂(ẋ) is the same for a proxy at rest."
)

ITEMS = (
    Item("eq6", "The haptic force", "Section 2.4, Eq 6",
         "The contact is a spring and a damper on the deflection, expressed in the body frame of the master.",
         eq6, ("R16", "R22"), _READ_6, _FORCE),
    Item("eq7", "The chain of frames", "Section 2.4, Eq 7",
         "The frame of the force is a constant transformation between the bases, then one by the joints of the master.",
         eq7, ("R17",), "Forces are free vectors: they only rotate. F_L does not depend on q, F_H does.",
         ("core/palpate/mapping/mapping.cpp", "core/palpate/loop/haptics_record.cpp")),
    Item("eq8", "Diagonal gains", "Section 2.4, Eq 8",
         "Stiffness and damping are diagonal matrices: one spring and one damper for each axis.",
         eq8, ("R16",), "", _FORCE),
    Item("eq9", "The force inside the master's dynamics", "Section 2.4, Eq 9",
         "The haptic force enters the master's dynamics as a wrench at the handle.",
         eq9, ("R18",), "The arm holds its own weight and pushes the hand with F; signs as in the page on torques.",
         ("core/palpate/torque/torque.cpp", "core/palpate/plant/leader.cpp")),
    Item("eq13", "The controller", "Section 2.4, Eq 13",
         "Two terms remain for slow motion: gravity compensation, and the spring and damper of the contact.",
         eq13, ("R15", "R22"), "Worked in joint torques: τ = Jᵀ F_L + Ĝ(q). The desired velocity is zero.",
         ("core/palpate/torque/stiffness.cpp", "core/palpate/torque/torque.cpp")),
)  # fmt: skip
