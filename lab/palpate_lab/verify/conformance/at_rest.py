"""Checks with a tool at rest: sign, direction and magnitude of the wrench follow from role, law and policy."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.base.arrays import Array
from palpate_lab.verify.conformance.bench import DT, RESERVE, Bench, constant_pose, constant_probe, fixture
from palpate_lab.verify.conformance.combinations import LATER, POLICIES, Combination
from palpate_lab.verify.conformance.laws import LAWS, K
from palpate_lab.verify.conformance.probes import Probe, probes, unfiltered_poses
from palpate_lab.verify.conformance.roles import LEVER, ROLES, SPEED, angle
from palpate_lab.verify.conformance.specimens import SPECIMENS

ENTRY = 1e-4
"""Largest error of a hard fixture's goal in motion [m]; divided by LEVER for angles [rad]."""
WITHIN = 1e-3
"""Accepted relative error of a wrench. Finite differences and the solver of corrections make up to half of it [-]."""
SOLVED = 2e-7
"""Accepted error of a corrected goal: the solver accepts 1e-8, finite differences err by less than this [m, rad]."""
WEIGHTS = np.r_[np.ones(3), np.full(3, 1.0 / LEVER)]
"""Weights (6,) that make forces and moments comparable [1, 1/m]."""


SETTLED = 700
"""Ticks until a goal correction has removed an initial violation."""


def lead(c: Combination, gap: float) -> float:
    """Distance by which the whole correction of a hard fixture leads beyond the border [m].

    The goal keeps RESERVE to the border, whatever the fixture's authority; the whole correction is larger by the
    inverse of the authority.
    """
    return RESERVE / c.activation(gap) if POLICIES[c.policy].hard and not ROLES[c.role].attracts else 0.0


def settle(c: Combination) -> int:
    """Ticks until the output has settled."""
    ramp = POLICIES[c.policy].ramp
    by_time = ramp is not None and ramp[0] == "time"
    return SETTLED if c.corrects else round(1.2 * LATER / DT) if by_time else 60


def sign_and_direction(c: Combination) -> str:
    """The wrench is the law's force along J times the activation, zero if satisfied; a hard goal is feasible."""
    for probe in probes(c):
        out = Bench(c, quick=True).begin(probe.X).run(constant_probe(probe, settle(c)))
        failure = _wrench_failure(c, probe, out.F[-1])
        if not failure and POLICIES[c.policy].hard and c.activation(probe.gap) == 1.0 and not ROLES[c.role].speed:
            failure = _goal_failure(c, probe, out.X[-1])
        if not failure and LAWS[c.law].force is None and not ROLES[c.role].speed:
            failure = _damping_failure(c, probe)
        if failure:
            unit = "rad" if ROLES[c.role].turns else "m"
            return f"gap {probe.gap:.4g} {unit} at {np.round(probe.X[:3, 3], 4)}: {failure}"
    return ""


def expected(c: Combination, probe: Probe) -> Array:
    """Reference wrench (6,) from role, law and policy [N, N m]."""
    case, law = ROLES[c.role], LAWS[c.law]
    if case.speed:
        return c.activation(np.inf) * law.damping * max(float(np.linalg.norm(probe.V[:3])) - SPEED, 0.0) * probe.J
    if law.force is None:
        return np.zeros(6)
    gap = probe.gap
    if gap > 0.0 and c.corrects and not POLICIES[c.policy].hard and LAWS[c.law].together:
        return np.zeros(6)
    gap -= lead(c, gap) if gap < 0.0 else 0.0
    return np.asarray(c.activation(probe.gap) * law.force(gap, case.attracts, case.turns) * probe.J)


def _wrench_failure(c: Combination, probe: Probe, F: Array) -> str:
    reference = expected(c, probe)
    size = float(np.linalg.norm(reference * WEIGHTS))
    allowed = WITHIN * size + K * SPECIMENS[c.geometry].near + 1e-5
    if float(np.linalg.norm((F - reference) * WEIGHTS)) > allowed:
        return f"wrench {np.round(F, 4)}, by finite differences {np.round(reference, 4)}"
    return ""


def _goal_failure(c: Combination, probe: Probe, X: Array) -> str:
    """The goal of a hard fixture with full authority is feasible and was moved no farther than necessary."""
    case, s = ROLES[c.role], SPECIMENS[c.geometry]
    left = case.gap(s, X)
    promised = lead(c, probe.gap)
    if left < (promised if probe.violated else min(promised, probe.gap)) - SOLVED - s.near:
        return f"the corrected goal keeps {left:.3g} to the border, {promised:.3g} promised"
    if case.role == "rcm":  # moves and turns at once
        return ""
    shift = np.linalg.norm(X[:3, 3] - probe.X[:3, 3]) + LEVER * angle(X, probe.X)
    lever = LEVER / float(np.linalg.norm(probe.J[3:])) if case.turns else 1.0
    need = max(-probe.gap, 0.0) * lever + lead(c, probe.gap)
    if shift > (1.0 + WITHIN) * need + 10.0 * SOLVED + s.near:
        return f"the goal was moved by {shift:.3g} m, {need:.3g} m was needed"
    return ""


def _damping_failure(c: Combination, probe: Probe) -> str:
    """A velocity law dissipates energy in every motion, and more if the motion increases the violation."""
    V = 0.02 * (10.0 if ROLES[c.role].turns else 1.0) * probe.J / np.linalg.norm(probe.J)
    worse, better = _power(c, probe, -V), _power(c, probe, V)
    if worse > 1e-9 or better > 1e-9:
        return f"active power: {worse:.3g} W if the violation grows, {better:.3g} W if it shrinks"
    if probe.violated and not worse < 0.5 * better - 1e-12:
        return f"a growing violation is damped ({worse:.3g} W) hardly more than a shrinking one ({better:.3g} W)"
    return ""


def _power(c: Combination, probe: Probe, V: Array) -> float:
    bench = Bench(c, quick=True).begin(probe.X)
    bench.run(constant_pose(probe.X, settle(c)))
    return float(bench.run(constant_pose(probe.X, 40, V)).F[-1] @ V)


def steady(c: Combination) -> str:
    """The wrench is constant at rest in a violated pose, even near edges and medial surfaces."""
    for X in unfiltered_poses(c.role, c.geometry, c.seed):
        bench = Bench(c, quick=True).begin(X)
        bench.run(constant_pose(X, settle(c)))
        F = bench.run(constant_pose(X, 50)).F
        change = float(np.linalg.norm((F - F[-1]) * WEIGHTS, axis=1).max())
        if change > 1e-3 * float(np.linalg.norm(F[-1] * WEIGHTS)) + 1e-5:
            return f"at rest at {np.round(X[:3, 3], 4)} the wrench changes by {change:.3g} N"
    return ""


def frame_change(c: Combination) -> str:
    """The output is equivariant: transforming fixture and tool together transforms wrench and goal."""
    X_WG = np.eye(4)
    X_WG[:3, :3] = Rotation.from_rotvec([0.7, -1.1, 0.4]).as_matrix()
    X_WG[:3, 3] = [0.11, -0.07, 0.05]
    for probe in probes(c)[:2]:
        motion = constant_probe(probe, settle(c))
        here = Bench(c, quick=True).begin(probe.X).run(motion)
        there = Bench(c, fixture(c, X_WG=X_WG), quick=True).begin(probe.X, X_WG).run(motion.carried(X_WG), X_WG)
        R = X_WG[:3, :3]
        F = np.r_[R.T @ there.F[-1, :3], R.T @ there.F[-1, 3:]]
        near = 1e-6 + K * ((SOLVED + SPECIMENS[c.geometry].wander) * c.corrects + 4e-2 * SPECIMENS[c.geometry].near)
        if np.abs(F - here.F[-1]).max() > near + 1e-4 * np.abs(here.F[-1]).max():
            return f"wrench {np.round(here.F[-1], 5)} here, {np.round(F, 5)} there"
        X = np.linalg.inv(X_WG) @ there.X[-1]
        if np.abs(X - here.X[-1]).max() > (SOLVED / LEVER + SPECIMENS[c.geometry].near if c.corrects else 1e-9):
            return "the goal is corrected otherwise in another frame"
    return ""
