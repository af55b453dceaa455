"""How much of a fixture counts: every policy by a judge of its own, against the same fixture under no policy at all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from palpate import _core
from palpate.arrays import Array
from palpate.verify.conformance.at_rest import WEIGH, settle
from palpate.verify.conformance.bench import DT, RESERVE, Bench, Motion, fixture, held, still
from palpate.verify.conformance.combinations import (
    ENGAGE,
    LATER,
    NEAR,
    PER_TURN,
    POLICIES,
    QUICK,
    RELEASE,
    Combination,
)
from palpate.verify.conformance.laws import K_TURN, LAWS, K
from palpate.verify.conformance.probes import Probe, brought, probe_at, probes
from palpate.verify.conformance.roles import LEVER, ROLES
from palpate.verify.conformance.specimens import SPECIMENS

PRESSED, TWISTED = 0.002, 0.3
"""How deep the tool is in what pulls against [m]; how far it is turned from what it wants [rad]."""


def policy(c: Combination) -> str:
    """By the policy's own judge."""
    for probe in probes(c.role, c.geometry)[:2]:
        wrong = JUDGES[c.policy](c, probe)
        if wrong:
            return wrong
    return ""


def _pushed(c: Combination, probe: Probe, n: int) -> Motion:
    """At a probe, told to move against the wish: springs and laws of motions answer, both."""
    if ROLES[c.role].speed:
        return held(probe, n)
    V = 0.01 * (10.0 if ROLES[c.role].turns else 1.0) * probe.along / np.linalg.norm(probe.along)
    return still(probe.X, n, -V)


def _whole(c: Combination, probe: Probe) -> Array:
    """(6,) the wrench with all of the fixture counted."""
    plain = replace(c, policy="hard" if POLICIES[c.policy].hard else "soft")
    return np.asarray(Bench(plain, quick=True).run(_pushed(c, probe, settle(c))).F[-1])


def _is_not(F: Array, whole: Array, share: float, words: str, slack: float = 1e-3) -> str:
    if float(np.linalg.norm((F - share * whole) * WEIGH)) <= slack * float(np.linalg.norm(whole * WEIGH)) + 1e-6:
        return ""
    return f"{words}: wrench {np.round(F, 4)}, {share:.3g} of {np.round(whole, 4)} is due"


def _authority(c: Combination, probe: Probe) -> str:
    """Its share of the wrench; of a hard one its share of the correction as well.

    A limit of force asks again what is left, until nothing is: its goal ends at the limit, whatever the authority.
    """
    share = float(POLICIES[c.policy].options.get("authority", 1.0))
    out = Bench(c, quick=True).run(_pushed(c, probe, settle(c)))
    hard = POLICIES[c.policy].hard
    wrong = _is_not(out.F[-1], _whole(c, probe), share, f"authority {share:g}", 0.08 if c.corrects else 1e-3)
    if wrong or not hard or ROLES[c.role].speed or ROLES[c.role].touches:
        return wrong
    left = max(-ROLES[c.role].gap(SPECIMENS[c.geometry], out.X[-1]), 0.0)
    most = (1.0 - share) * max(-probe.gap, 0.0)
    reserve = 2.0 * RESERVE * (1.0 if not ROLES[c.role].turns else 1.0 / LEVER)
    if abs(left - most) > 0.1 * max(-probe.gap, 0.0) + reserve:
        return f"authority {share:g}: the goal is left {left:.3g} beyond the border, {most:.3g} is due"
    return ""


def _pedal(c: Combination, probe: Probe) -> str:
    whole = _whole(c, probe)
    for pedal in (0.0, 0.25, 1.0):
        bench = Bench(c, quick=True)
        bench.pedal = pedal
        wrong = _is_not(bench.run(_pushed(c, probe, settle(c))).F[-1], whole, pedal, f"pedal {pedal:g}")
        if wrong:
            return wrong
    return ""


def _force(c: Combination, probe: Probe) -> str:
    """Of a load cell; without one, what the fixture would pull with."""
    whole, case, law = _whole(c, probe), ROLES[c.role], LAWS[c.law]
    shares = {force: min(force / 4.0, 1.0) for force in (0.0, 1.0, 6.0)}
    if not case.turns and not case.speed:
        own = 0.0 if law.force is None else law.force(probe.gap, case.attracts, False)
        shares[-1.0] = min(own * float(np.linalg.norm(probe.along[:3])) / 4.0, 1.0)
    for force, share in shares.items():
        bench = Bench(c, quick=True)
        bench.operator = force
        words = f"operator's force {force:g} N" if force >= 0.0 else "no load cell"
        F = bench.run(_pushed(c, probe, settle(c))).F[-1]
        wrong = _is_not(F, whole, share, words, 0.02 if force < 0.0 else 1e-3)
        if wrong:
            return wrong
    return ""


def _time(c: Combination, probe: Probe) -> str:
    bench, whole = Bench(c, quick=True), _whole(c, probe)
    out = bench.run(_pushed(c, probe, settle(c)))
    for t in (0.1, 0.25, 0.4, LATER + 0.05):
        wrong = _is_not(out.F[round(t / DT)], whole, min(t / LATER, 1.0), f"after {t:g} s", 0.02)
        if wrong:
            return wrong
    return ""


def _distance(c: Combination, probe: Probe) -> str:
    share = min(abs(probe.gap) / (NEAR * (PER_TURN if ROLES[c.role].turns else 1.0)), 1.0)
    F = Bench(c, quick=True).run(_pushed(c, probe, settle(c))).F[-1]
    return _is_not(F, _whole(c, probe), share, f"gap {probe.gap:.3g}", 2e-3)


def _engagement(c: Combination, probe: Probe) -> str:
    """Takes part once nearer than ENGAGE, until farther than RELEASE: both within 3 %. Between them: as it was."""
    per = PER_TURN if ROLES[c.role].turns else 1.0
    between = _at(c, probe, 0.4 * RELEASE * per, (-1.0,))
    whole = _whole(c, between)
    steps = (
        ("fresh, between both", None, 0.0), ("come to just beyond `engage`", 1.03 * ENGAGE, 0.0),
        ("come nearer than `engage`", 0.97 * ENGAGE, 1.0), ("gone to just before `release`", 0.97 * RELEASE, 1.0),
        ("gone beyond `release`", 1.03 * RELEASE, 0.0),
    )  # fmt: skip
    bench = Bench(c, quick=True)
    for words, gap, share in steps:
        if gap is not None:
            there = _at(c, probe, gap * per, (-1.0, 1.0))
            bench.run(still(there.X, round(3 * QUICK / DT)))
        F = bench.run(_pushed(c, between, max(settle(c), round(3 * QUICK / DT)))).F[-1]
        wrong = _is_not(F, share * whole, 1.0, words, 0.08 if c.corrects else 1e-3)
        if wrong:
            return wrong
    return ""


def _at(c: Combination, probe: Probe, gap: float, signs: tuple[float, ...]) -> Probe:
    """A place at which the gap is so large, of one of the signs; LookupError where there is none near a probe."""
    case = ROLES[c.role]
    for one in (probe, *probes(c.role, c.geometry)):
        for sign in signs:
            X = brought(case, SPECIMENS[c.geometry], one.X, sign * gap)
            if X is not None:
                return probe_at(c.role, c.geometry, X)
    raise LookupError(f"no place with a gap of {gap:.3g} beside a {c.geometry}")


def _alone(c: Combination, probe: Probe) -> str:
    """Soft ones add: two of them give both wrenches."""
    return "" if c.corrects else _pair(c, probe, 0, 0, 0.0, 0.0)


def _priority(c: Combination, probe: Probe) -> str:
    """Of two, the first is never pulled against; whichever that is. A limit of speed wants no place: both count."""
    if ROLES[c.role].speed:
        return _pair(c, probe, 1, 0, 0.0, 0.0)
    return _pair(c, probe, 1, 0, 1.0, 0.0) or _pair(c, probe, 0, 1, 0.0, 1.0)


def _hard(c: Combination, probe: Probe) -> str:
    """A soft one never pulls against a hard one, whatever its priority, nor moves its goal."""
    if ROLES[c.role].speed:
        return ""
    return _pair(c, probe, 0, 5, 1.0, 0.0)


def _pair(c: Combination, probe: Probe, mine: int, others: int, first: float, second: float) -> str:
    """With something that pulls against: (first, second) say how much of the other's opposition each is spared."""
    n = settle(c)
    own, against = fixture(c, policy={"priority": mine}), _opponent(c, probe, others)
    F1, F2, both = (Bench(c, *some, quick=True).run(held(probe, n)) for some in ((own,), (against,), (own, against)))
    f1, f2, f12 = (F.F[-1] * WEIGH * (np.arange(6) > 2 if ROLES[c.role].turns else 1.0) for F in (F1, F2, both))
    a, b = _unit(f1), _unit(f2)
    # What each loses of the other is its part against it, where there is one.
    due = f1 - second * min(float(f1 @ b), 0.0) * b + f2 - first * min(float(f2 @ a), 0.0) * a
    off = float(np.linalg.norm(f12 - due))
    slack = 0.03 if c.corrects else 2e-3
    if off > slack * float(np.linalg.norm(f1) + np.linalg.norm(f2)) + 1e-6:
        told = [np.round(f, 4) for f in (f12, f1, f2, due)]
        return f"priorities {mine} and {others}: {told[0]} of {told[1]} and {told[2]}, due {told[3]}"
    if POLICIES[c.policy].hard and np.abs(both.X[-1] - F1.X[-1]).max() > 1e-9:
        return "a soft fixture moves the goal of a hard one"
    return ""


def _unit(v: Array) -> Array:
    size = float(np.linalg.norm(v))
    return np.asarray(v / size if size > 1e-9 else 0.0 * v)


def _opponent(c: Combination, probe: Probe, priority: int) -> _core.Fixture:
    """A soft spring that pulls mostly against what the role wants, 45 degrees beside."""
    turns = ROLES[c.role].turns
    z = probe.X[:3, 2]
    a = probe.along[3:] if turns else probe.along[:3]
    a = _unit(a - z * float(z @ a)) if turns else _unit(a)
    side = _unit(np.cross(z if turns else np.eye(3)[int(np.argmin(np.abs(a)))], a))
    n = (side - a) / np.sqrt(2.0)
    law, policy, role = _core.GuidanceLawOptions(), _core.Policy(), _core.GuidanceRoleOptions()
    law.K, law.K_turn, policy.priority, policy.rise = K, K_TURN, priority, QUICK
    if turns:
        axis = Rotation.from_rotvec(TWISTED * n).as_matrix() @ z
        line = _core.LineGeometry(probe.X[:3, 3] - axis, probe.X[:3, 3] + axis, True)
        return _core.Fixture("against", line, "orient", role, "spring", law, policy)
    X = np.eye(4)
    X[:3, 2] = n
    X[:3, 0] = _unit(np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))]))
    X[:3, 1] = np.cross(n, X[:3, 0])
    X[:3, 3] = probe.X[:3, 3] + PRESSED * n
    plane = _core.PlacedGeometry(_core.SurfaceGeometry(_core.Plane()), X)
    return _core.Fixture("against", plane, "forbid", role, "spring", law, policy)


#: By name of the policy.
JUDGES: dict[str, Callable[[Combination, Probe], str]] = {
    "soft": _alone,
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
