"""Of a tool at rest: does the wrench have the sign, the direction and the size that role, law and policy say?"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.arrays import Array
from palpate.verify.conformance.bench import DT, RESERVE, Bench, fixture, held, still
from palpate.verify.conformance.combinations import LATER, POLICIES, Combination
from palpate.verify.conformance.laws import K_TURN, LAWS, K
from palpate.verify.conformance.probes import Probe, probes, rough
from palpate.verify.conformance.roles import LEVER, ROLES, SPEED, angle
from palpate.verify.conformance.specimens import SPECIMENS

ENTRY = 1e-4
"""A hard fixture lets the tool in no further than this [m]; of angles, this many times 1/LEVER [rad]."""
WEIGH = np.r_[np.ones(3), np.full(3, 1.0 / LEVER)]
"""Makes forces and moments comparable [1, 1/m]."""


SETTLED = 700
"""Ticks until a corrected goal has mended what was wrong when it came."""


def settle(c: Combination) -> int:
    """Ticks until an answer stands."""
    ramp = POLICIES[c.policy].ramp
    by_time = ramp is not None and ramp[0] == "time"
    return SETTLED if c.corrects else round(1.2 * LATER / DT) if by_time else 60


def sign_and_direction(c: Combination) -> str:
    """The law's force along the gap's slope, times the policy's share; none where all is well; the corrected goal."""
    for probe in probes(c.role, c.geometry):
        out = Bench(c, quick=True).begin(probe.X).run(held(probe, settle(c)))
        wrong = _direction(c, probe, out.F[-1])
        if not wrong and POLICIES[c.policy].hard and c.share(probe.gap) == 1.0 and not ROLES[c.role].speed:
            wrong = _corrected(c, probe, out.X[-1])
        if not wrong and LAWS[c.law].force is None and not ROLES[c.role].speed:
            wrong = _damps(c, probe)
        if wrong:
            return (
                f"gap {probe.gap:.4g} {'rad' if ROLES[c.role].turns else 'm'} at {np.round(probe.X[:3, 3], 4)}: {wrong}"
            )
    return ""


def expected(c: Combination, probe: Probe) -> Array:
    """(6,) the wrench that role, law and policy say."""
    case, law = ROLES[c.role], LAWS[c.law]
    if case.speed:
        return c.share(np.inf) * law.damping * max(float(np.linalg.norm(probe.V[:3])) - SPEED, 0.0) * probe.along
    if law.force is None:
        return np.zeros(6)
    gap = probe.gap
    if gap > 0.0 and c.corrects and not POLICIES[c.policy].hard and LAWS[c.law].together:
        return np.zeros(6)
    return np.asarray(c.share(gap) * law.force(gap, case.attracts, case.turns) * probe.along)


def _direction(c: Combination, probe: Probe, F: Array) -> str:
    case, want = ROLES[c.role], expected(c, probe)
    # A corrected goal keeps a reserve, and its wish is linear about where it was asked: of rcm it bends most.
    reserve = 1.2 * RESERVE * (K if not case.turns else K_TURN / LEVER**2) * float(POLICIES[c.policy].hard)
    size = float(np.linalg.norm(want * WEIGH))
    allowed = (
        ((0.3 if case.role == "rcm" else 0.08) if c.corrects else 2e-3) * size
        + reserve
        + 4.0 * K * SPECIMENS[c.geometry].near
        + 1e-5
    )
    if float(np.linalg.norm((F - want) * WEIGH)) > allowed:
        return f"wrench {np.round(F, 4)}, by finite differences {np.round(want, 4)}"
    return ""


def _corrected(c: Combination, probe: Probe, X: Array) -> str:
    """The goal of a hard fixture of whole authority is as wanted, and was not taken further than it had to be."""
    case, s = ROLES[c.role], SPECIMENS[c.geometry]
    left = case.gap(s, X)
    limit = ENTRY / LEVER if case.turns else 2.0 * ENTRY if case.attracts else ENTRY
    if left < -limit - s.near:
        return f"the corrected goal is {-left:.2g} beyond the border"
    way = np.linalg.norm(X[:3, 3] - probe.X[:3, 3]) + LEVER * angle(X, probe.X)
    need = max(-probe.gap, 0.0) * (LEVER if case.turns else 1.0)
    if way > 1.5 * need + 2.0 * RESERVE * (1 + case.turns):
        return f"the goal was taken {way:.3g} m away, {need:.3g} m was needed"
    return ""


def _damps(c: Combination, probe: Probe) -> str:
    """A law of motions: takes energy out of every motion, more of one that is not wanted than of one that is."""
    V = 0.02 * (10.0 if ROLES[c.role].turns else 1.0) * probe.along / np.linalg.norm(probe.along)
    worse, better = _power(c, probe, -V), _power(c, probe, V)
    if worse > 1e-9 or better > 1e-9:
        return f"gives power: {worse:.3g} W against the wish, {better:.3g} W with it"
    if probe.wrong and not worse < 0.5 * better - 1e-12:
        return f"a motion against the wish is hardly slower ({worse:.3g} W) than one with it ({better:.3g} W)"
    return ""


def _power(c: Combination, probe: Probe, V: Array) -> float:
    bench = Bench(c, quick=True).begin(probe.X)
    bench.run(still(probe.X, settle(c)))
    return float(bench.run(still(probe.X, 40, V)).F[-1] @ V)


def quiet(c: Combination) -> str:
    """Where all is not well, and edges and middles may be near as well: at rest the wrench stands still."""
    for X in rough(c.role, c.geometry):
        bench = Bench(c, quick=True).begin(X)
        bench.run(still(X, settle(c)))
        F = bench.run(still(X, 50)).F
        moves = float(np.linalg.norm((F - F[-1]) * WEIGH, axis=1).max())
        if moves > 1e-3 * float(np.linalg.norm(F[-1] * WEIGH)) + 1e-5:
            return f"at rest at {np.round(X[:3, 3], 4)} the wrench moves by {moves:.3g} N"
    return ""


def frame_change(c: Combination) -> str:
    """Fixture and tool carried together to another place: the same answer, carried with them."""
    X_WG = np.eye(4)
    X_WG[:3, :3] = Rotation.from_rotvec([0.7, -1.1, 0.4]).as_matrix()
    X_WG[:3, 3] = [0.11, -0.07, 0.05]
    for probe in probes(c.role, c.geometry)[:2]:
        motion = held(probe, settle(c))
        here = Bench(c, quick=True).begin(probe.X).run(motion)
        there = Bench(c, fixture(c, X_WG=X_WG), quick=True).begin(probe.X, X_WG).run(motion.carried(X_WG), X_WG)
        R = X_WG[:3, :3]
        F = np.r_[R.T @ there.F[-1, :3], R.T @ there.F[-1, 3:]]
        near = 1e-6 + K * (2.0 * RESERVE if c.corrects else 4e-2 * SPECIMENS[c.geometry].near)
        if np.abs(F - here.F[-1]).max() > near + 1e-4 * np.abs(here.F[-1]).max():
            return f"wrench {np.round(here.F[-1], 5)} here, {np.round(F, 5)} there"
        X = np.linalg.inv(X_WG) @ there.X[-1]
        if np.abs(X - here.X[-1])[:3].max() > (2.0 * RESERVE / LEVER if c.corrects else 1e-9):
            return "the goal is corrected otherwise in another frame"
    return ""
