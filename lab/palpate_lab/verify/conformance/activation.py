"""Checks of the activation: every policy is compared with the same fixture without a policy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance
from palpate.base.arrays import Array
from palpate_lab.verify.conformance.at_rest import WEIGHTS, lead, settle
from palpate_lab.verify.conformance.bench import DT, RESERVE, Bench, Motion, constant_pose, constant_probe, fixture
from palpate_lab.verify.conformance.combinations import (
    ENGAGE,
    LATER,
    PER_TURN,
    POLICIES,
    QUICK,
    RELEASE,
    Combination,
)
from palpate_lab.verify.conformance.laws import K_TURN, LAWS, MOST, K
from palpate_lab.verify.conformance.probes import Probe, moved_to_gap, probe_at, probes
from palpate_lab.verify.conformance.roles import ROLES, TOUCHED
from palpate_lab.verify.conformance.specimens import SPECIMENS

PRESSED, TWISTED = 0.002, 0.3
"""Constraint violation of the opposing fixture, in position [m] and in orientation [rad]."""
ROUGH = 0.03
"""Relative error of a force that is carried back where an admittance lets the goal follow late, and where the gap of a
remote centre depends on the rotation: the map is then exact to first order of the correction."""
RAMP, _LENGTH = 2e-4, 0.05
"""Violation over which a fixture of higher priority begins to rule, and length that makes 1 rad a displacement [m]."""
SMALL_MOVE, SMALL_TURN = 2e-5, 2e-4
"""Steps of the differences that judge how a corrected goal moves with the mapped one [m, rad]."""


def policy(c: Combination) -> str:
    """Run the policy's own check on two probes."""
    for probe in probes(c)[:2]:
        failure = JUDGES[c.policy](c, probe)
        if failure:
            return failure
    return ""


def _violating_motion(c: Combination, probe: Probe, n: int) -> Motion:
    """A probe with a reported velocity that increases the violation, so that springs and dampers both act."""
    if ROLES[c.role].speed:
        return constant_probe(probe, n)
    V = 0.01 * (10.0 if ROLES[c.role].turns else 1.0) * probe.J / np.linalg.norm(probe.J)
    return constant_pose(probe.X, n, -V)


def _full_wrench(c: Combination, probe: Probe) -> Array:
    """Wrench (6,) of the fixture with full activation [N, N m]."""
    plain = replace(c, policy="hard" if POLICIES[c.policy].hard else "soft")
    return np.asarray(Bench(plain, quick=True).run(_violating_motion(c, probe, settle(c))).F[-1])


def _wrench_failure(F: Array, full: Array, activation: float, words: str, slack: float = 1e-3) -> str:
    if float(np.linalg.norm((F - activation * full) * WEIGHTS)) <= slack * float(np.linalg.norm(full * WEIGHTS)) + 1e-6:
        return ""
    return f"{words}: wrench {np.round(F, 4)}, expected {activation:.3g} of {np.round(full, 4)}"


def _authority(c: Combination, probe: Probe) -> str:
    """The authority scales the wrench, and for a hard policy also the correction of the goal.

    A force limit repeats its correction, so its goal converges to the limit for any authority.
    """
    authority = POLICIES[c.policy].authority
    out = Bench(c, quick=True).run(_violating_motion(c, probe, settle(c)))
    hard = POLICIES[c.policy].hard
    full = _full_wrench(c, probe)
    F = out.F[-1] - _of_reserve(c, probe, full) * probe.J
    failure = _wrench_failure(F, full, authority, f"authority {authority:g}", 1e-3)
    if failure or not hard or ROLES[c.role].speed or ROLES[c.role].touches:
        return failure
    left = max(-ROLES[c.role].gap(SPECIMENS[c.geometry], out.X[-1]), 0.0)
    expected = max((1.0 - authority) * max(-probe.gap, 0.0) - authority * lead(c, probe.gap), 0.0)
    if abs(left - expected) > 0.01 * max(-probe.gap, 0.0) + RESERVE * (not ROLES[c.role].attracts):
        return f"authority {authority:g}: the goal is {left:.3g} beyond the boundary, expected {expected:.3g}"
    return ""


def _of_reserve(c: Combination, probe: Probe, full: Array) -> float:
    """Force by which a hard fixture with part of the authority exceeds that part of the full one's force [N, N m].

    Both goals keep the same reserve, so that the whole correction is larger with less authority.
    """
    case, law, authority = ROLES[c.role], LAWS[c.law], POLICIES[c.policy].authority
    if law.force is None or not np.isfinite(probe.gap) or probe.gap > 0.0:
        return 0.0
    keeps, size = lead(c, probe.gap), float(full @ probe.J)
    part, whole = (law.force(probe.gap - way, case.attracts, case.turns) for way in (keeps, authority * keeps))
    most = np.inf if c.law == "spring" else MOST
    return authority * (min(size + part - whole, most) - size) if keeps > 0.0 else 0.0


def _pedal(c: Combination, probe: Probe) -> str:
    full = _full_wrench(c, probe)
    for pedal in (0.0, 0.25, 1.0):
        bench = Bench(c, quick=True)
        bench.pedal = pedal
        F = bench.run(_violating_motion(c, probe, settle(c))).F[-1]
        failure = _wrench_failure(F, full, pedal, f"pedal {pedal:g}")
        if failure:
            return failure
    return ""


def _force(c: Combination, probe: Probe) -> str:
    """The ramp by force uses the load cell; without a load cell it uses the fixture's own force."""
    full, case, law = _full_wrench(c, probe), ROLES[c.role], LAWS[c.law]
    shares = {force: min(force / 4.0, 1.0) for force in (0.0, 1.0, 6.0)}
    if not case.turns and not case.speed:
        own = 0.0 if law.force is None else law.force(probe.gap, case.attracts, False)
        shares[-1.0] = min(own * float(np.linalg.norm(probe.J[:3])) / 4.0, 1.0)
    for force, share in shares.items():
        bench = Bench(c, quick=True)
        bench.operator = force
        words = f"operator's force {force:g} N" if force >= 0.0 else "no load cell"
        F = bench.run(_violating_motion(c, probe, settle(c))).F[-1]
        failure = _wrench_failure(F, full, share, words, 0.02 if force < 0.0 else 1e-3)
        if failure:
            return failure
    return ""


def _time(c: Combination, probe: Probe) -> str:
    bench, full = Bench(c, quick=True), _full_wrench(c, probe)
    out = bench.run(_violating_motion(c, probe, settle(c)))
    for t in (0.1, 0.25, 0.4, LATER + 0.05):
        failure = _wrench_failure(out.F[round(t / DT)], full, min(t / LATER, 1.0), f"after {t:g} s", 0.02)
        if failure:
            return failure
    return ""


def _distance(c: Combination, probe: Probe) -> str:
    share = c.activation(probe.gap)
    F = Bench(c, quick=True).run(_violating_motion(c, probe, settle(c))).F[-1]
    return _wrench_failure(F, _full_wrench(c, probe), share, f"gap {probe.gap:.3g}", 2e-3)


def _engagement(c: Combination, probe: Probe) -> str:
    """A fixture engages within ENGAGE and releases beyond RELEASE (both within 3 %), with hysteresis in between."""
    per = PER_TURN if ROLES[c.role].turns else 1.0
    between = _probe_at_gap(c, probe, 0.4 * RELEASE * per, (-1.0,))
    full = _full_wrench(c, between)
    steps = (
        ("fresh, between both", None, 0.0), ("come to just beyond `engage`", 1.03 * ENGAGE, 0.0),
        ("come nearer than `engage`", 0.97 * ENGAGE, 1.0), ("gone to just before `release`", 0.97 * RELEASE, 1.0),
        ("gone beyond `release`", 1.03 * RELEASE, 0.0),
    )  # fmt: skip
    bench = Bench(c, quick=True)
    for words, gap, share in steps:
        if gap is not None:
            there = _probe_at_gap(c, probe, gap * per, (-1.0, 1.0))
            bench.run(constant_pose(there.X, round(3 * QUICK / DT)))
        F = bench.run(_violating_motion(c, between, max(settle(c), round(3 * QUICK / DT)))).F[-1]
        failure = _wrench_failure(F, share * full, 1.0, words, 1e-3)
        if failure:
            return failure
    return ""


def _probe_at_gap(c: Combination, probe: Probe, gap: float, signs: tuple[float, ...]) -> Probe:
    """A probe with this absolute gap and one of the signs; raises LookupError if none is reachable from a probe."""
    case = ROLES[c.role]
    for start in (probe, *probes(c)):
        for sign in signs:
            X = moved_to_gap(case, SPECIMENS[c.geometry], start.X, sign * gap)
            if X is not None:
                return probe_at(c.role, c.geometry, X)
    raise LookupError(f"no pose with a gap of {gap:.3g} near a {c.geometry}")


def _soft(c: Combination, probe: Probe) -> str:
    """The wrenches of two soft fixtures add."""
    return _pair(c, probe, 0, 0)


def _priority(c: Combination, probe: Probe) -> str:
    """A fixture acts at the goal that those of higher priority leave. A speed limit leaves every goal as it is."""
    if ROLES[c.role].speed:
        return _pair(c, probe, 1, 0)
    own = fixture(c, policy=replace(POLICIES[c.policy], priority=0))
    first = _ranked(c, probe, fixture(c), _opponent(c, probe, 0))
    return first or _ranked(c, probe, _opponent(c, probe, 1), own)


def _ranked(c: Combination, probe: Probe, high: _guidance.Fixture, low: _guidance.Fixture) -> str:
    """Compare two fixtures with the first alone, and the second alone at the goal that the first leaves."""
    n = settle(c)
    X, J = _goal_left(c, high, probe.X), _jacobian(lambda X: _goal_left(c, high, X), probe.X)
    f1 = Bench(c, high, quick=True).run(constant_probe(probe, n)).F[-1]
    f2 = J.T @ Bench(c, low, quick=True).run(constant_pose(X, n, J @ probe.V)).F[-1]
    f12 = Bench(c, high, low, quick=True).run(constant_probe(probe, n)).F[-1]
    f1, f2, f12 = (F * WEIGHTS for F in (f1, f2, f12))
    if np.linalg.norm(f12 - f1 - f2) > 2e-3 * float(np.linalg.norm(f1) + np.linalg.norm(f2)) + 1e-6:
        total, first, second = (np.round(F, 4) for F in (f12, f1, f2))
        return f"priorities: {total}, expected the sum of {first} and {second}"
    return ""


def _goal_left(c: Combination, high: _guidance.Fixture, X: Array) -> Array:
    """The pose (4, 4) that a fixture leaves to those of lower priority at X: on its border, less half of RAMP."""

    def moved(x: Array) -> Array:
        Y = X.copy()
        Y[:3, 3] += x[:3]
        Y[:3, :3] = Rotation.from_rotvec(x[3:] / _LENGTH).as_matrix() @ X[:3, :3]
        return Y

    def gap(x: Array) -> float:
        Y = moved(x)
        pressed = np.array([0.0, 0.0, TOUCHED * max(-Y[2, 3], 0.0)]) if ROLES[c.role].touches else np.zeros(3)
        return float(high.evaluate(Y, F_T_W=pressed, stiffness=TOUCHED)["gap"])

    steps = 1e-6 * np.eye(6)
    slope = np.array([(gap(h) - gap(-h)) / 2e-6 for h in steps])
    if ROLES[c.role].turns:
        slope[:3] = 0.0
    size = float(np.linalg.norm(slope))
    if not size > 0.0 or gap(np.zeros(6)) >= 0.0:
        return X
    violation = -gap(np.zeros(6)) / size
    by = 0.5 * violation**2 / RAMP if violation < RAMP else violation - 0.5 * RAMP
    return moved(by * slope / size)


def _hard(c: Combination, probe: Probe) -> str:
    """A soft fixture of any priority acts at the goal of a hard one, carried back to the hand, and does not move it."""
    if ROLES[c.role].speed:
        return ""
    n = settle(c)
    hard, soft = fixture(c), _opponent(c, probe, 5)
    alone = Bench(c, hard, quick=True).run(constant_probe(probe, n))
    both = Bench(c, hard, soft, quick=True).run(constant_probe(probe, n))
    if np.abs(both.X[-1] - alone.X[-1]).max() > 1e-9:
        return "a soft fixture moves the goal of a hard one"
    at_goal = Bench(c, soft, quick=True).run(constant_pose(alone.X[-1], n)).F[-1]
    # The hand goes on feeling a touched force that a fixture limits: no part of it is projected out.
    carried = at_goal if ROLES[c.role].touches else _goal_jacobian(c, probe, n).T @ at_goal
    f12, f1, f2 = (F * WEIGHTS for F in (both.F[-1], alone.F[-1], carried))
    slack = ROUGH if c.law == "admittance" or c.role == "rcm" else 2e-3
    if (
        float(np.linalg.norm(f12 - f1 - f2))
        > slack * float(np.linalg.norm(f1) + np.linalg.norm(at_goal * WEIGHTS)) + 1e-6
    ):
        total, first, second = (np.round(f, 4) for f in (f12, f1, f2))
        return f"a soft fixture at the goal of a hard one: {total}, expected the sum of {first} and {second}"
    return ""


def _goal_jacobian(c: Combination, probe: Probe, n: int) -> Array:
    """(6, 6) derivative of the corrected goal with respect to the mapped goal, in W."""
    return _jacobian(
        lambda X: np.asarray(Bench(c, fixture(c), quick=True).run(constant_pose(X, n, probe.V)).X[-1]), probe.X
    )


def _jacobian(goal: Callable[[Array], Array], at: Array) -> Array:
    """(6, 6) derivative of a pose with respect to the pose `at` (4, 4), by central differences, in W."""

    def displaced(k: int, by: float) -> Array:
        X = at.copy()
        if k < 3:
            X[k, 3] += by
        else:
            X[:3, :3] = Rotation.from_rotvec(by * np.eye(3)[k - 3]).as_matrix() @ X[:3, :3]
        return goal(X)

    J = np.empty((6, 6))
    for k in range(6):
        h = SMALL_MOVE if k < 3 else SMALL_TURN
        more, less = displaced(k, h), displaced(k, -h)
        J[:3, k] = (more[:3, 3] - less[:3, 3]) / (2.0 * h)
        J[3:, k] = Rotation.from_matrix(more[:3, :3] @ less[:3, :3].T).as_rotvec() / (2.0 * h)
    return J


def _pair(c: Combination, probe: Probe, mine: int, others: int) -> str:
    """Check that the wrenches of the fixture and of an opposing one add."""
    n = settle(c)
    own, against = fixture(c, policy=replace(POLICIES[c.policy], priority=mine)), _opponent(c, probe, others)
    sets = ((own,), (against,), (own, against))
    f1, f2, f12 = (Bench(c, *fixtures, quick=True).run(constant_probe(probe, n)).F[-1] * WEIGHTS for fixtures in sets)
    if float(np.linalg.norm(f12 - f1 - f2)) > 2e-3 * float(np.linalg.norm(f1) + np.linalg.norm(f2)) + 1e-6:
        total, first, second = (np.round(f, 4) for f in (f12, f1, f2))
        return f"priorities {mine} and {others}: {total}, expected the sum of {first} and {second}"
    return ""


def _unit(v: Array) -> Array:
    size = float(np.linalg.norm(v))
    return np.asarray(v / size if size > 1e-9 else 0.0 * v)


def _opponent(c: Combination, probe: Probe, priority: int) -> _guidance.Fixture:
    """A soft spring fixture whose force is at 135 degrees to the gradient of the role's constraint."""
    turns = ROLES[c.role].turns
    z = probe.X[:3, 2]
    a = probe.J[3:] if turns else probe.J[:3]
    a = _unit(a - z * float(z @ a)) if turns else _unit(a)
    side = _unit(np.cross(z if turns else np.eye(3)[int(np.argmin(np.abs(a)))], a))
    n = (side - a) / np.sqrt(2.0)
    law, policy, role = _core.GuidanceLawOptions(), _core.Policy(), _core.GuidanceRoleOptions()
    law.K, law.K_turn, policy.priority, policy.rise = K, K_TURN, priority, QUICK
    if turns:
        axis = Rotation.from_rotvec(TWISTED * n).as_matrix() @ z
        line = _guidance.LineGeometry(probe.X[:3, 3] - axis, probe.X[:3, 3] + axis, True)
        return _guidance.Fixture("against", line, "orient", role, "spring", law, policy)
    X = np.eye(4)
    X[:3, 2] = n
    X[:3, 0] = _unit(np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))]))
    X[:3, 1] = np.cross(n, X[:3, 0])
    X[:3, 3] = probe.X[:3, 3] + PRESSED * n
    plane = _guidance.PlacedGeometry(_guidance.SurfaceGeometry(_core.Plane()), X)
    return _guidance.Fixture("against", plane, "forbid", role, "spring", law, policy)


#: Check by name of the policy.
JUDGES: dict[str, Callable[[Combination, Probe], str]] = {
    "soft": _soft,
    "hard": _hard,
    "part of the authority": _authority,
    "hard, part of the authority": _authority,
    "ramp by pedal": _pedal,
    "ramp by distance": _distance,
    "ramp by time": _time,
    "ramp by force": _force,
    "engages and releases": _engagement,
    "first of two": _priority,
}
