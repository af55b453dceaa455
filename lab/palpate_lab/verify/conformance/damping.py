"""Check of the damping: the part of the wrench that the tool's velocity causes, against the laws' formulae.

The tool stands in a violated pose and reports a twist V. The wrench with V minus that without it is the damping alone,
so that an error of the stiffness cannot hide one of the damping.
"""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate_lab.verify.conformance.at_rest import WEIGHTS, lead, settle
from palpate_lab.verify.conformance.bench import Bench, constant_pose
from palpate_lab.verify.conformance.combinations import Combination
from palpate_lab.verify.conformance.laws import B_TURN, K_TURN, LAWS, MOMENT, MOST, RANGE, RATIO, RISE, RISE_TURN, B, K
from palpate_lab.verify.conformance.probes import Probe, probes
from palpate_lab.verify.conformance.roles import ROLES, nearest
from palpate_lab.verify.conformance.specimens import SPECIMENS, up

SPEED, TURN = 0.02, 2.0
"""Speed and rate of rotation of the reported twists [m/s, rad/s]."""
WITHIN = 0.01
"""Accepted relative error of the damping; half of it is due to the correction of hard and joint fixtures [-]."""


def damping(c: Combination) -> str:
    """The difference that a reported twist makes to the wrench equals -B gap' along J, or that of the law's matrix.

    A speed limit is left out: `sign and direction` judges its damping.
    """
    if ROLES[c.role].speed:
        return ""
    for probe in probes(c)[:2]:
        bench = Bench(c, quick=True, damping=LAWS[c.law].force is None).begin(probe.X)
        rests = bench.run(constant_pose(probe.X, settle(c))).F[-1]
        for V in _twists(c, probe):
            out = bench.run(constant_pose(probe.X, 5, V))
            felt, reference = out.F[-1] - rests, c.activation(probe.gap) * expected(c, probe, V)
            full = B_TURN / RATIO * TURN if ROLES[c.role].turns else B / RATIO * SPEED
            off = float(np.linalg.norm((felt - reference) * WEIGHTS))
            if off > WITHIN * float(np.linalg.norm(reference * WEIGHTS)) + _near(c, full):
                words = f"gap {probe.gap:.4g}, twist {np.round(V, 3)}: damping"
                return f"{words} {np.round(felt, 4)}, by its formula {np.round(reference, 4)}"
    return ""


def _near(c: Combination, full: float) -> float:
    """Accepted absolute error [N]: of a sampled geometry's normal, and of its distance over the rise of the damping."""
    return 1e-6 + full * SPECIMENS[c.geometry].near / RISE


def _twists(c: Combination, probe: Probe) -> list[Array]:
    """Twists that increase and decrease the violation, and three of any direction."""
    rng = np.random.default_rng(7)
    scale = np.r_[np.full(3, SPEED), np.full(3, TURN)]
    along = SPEED * probe.J / np.linalg.norm(probe.J) if not ROLES[c.role].turns else np.r_[0, 0, 0, TURN * probe.J[3:]]
    return [-along, along, *(scale * rng.uniform(-1.0, 1.0, (3, 6)))]


def expected(c: Combination, probe: Probe, V: Array) -> Array:
    """Change (6,) of the law's wrench with full activation by a twist V (6,) [N, N m]."""
    case, law = ROLES[c.role], LAWS[c.law]
    if law.force is None:
        return np.asarray(_turning(probe, V) if case.turns else _matrix(c, probe, V) @ V)
    k, b, rise = (K_TURN, B_TURN, RISE_TURN) if case.turns else (K, B, RISE)
    most = np.inf if c.law == "spring" else MOMENT if case.turns else MOST
    f = law.force(probe.gap - lead(c, probe.gap), case.attracts, case.turns)
    rate = float(probe.J[3:] @ V[3:]) if case.turns else float(probe.J @ V)
    change = float(np.clip(f - b * min(f / (k * rise), 1.0) * rate, 0.0, most)) - f if f > 0.0 else 0.0
    return np.asarray(change * np.r_[(0.0 if case.turns else 1.0) * probe.J[:3], probe.J[3:]])


def _turning(probe: Probe, V: Array) -> Array:
    """Every rotation is damped by B_turn, and one that increases the violation by B_turn / ratio."""
    worse, share = min(float(probe.J[3:] @ V[3:]), 0.0), min(max(-probe.gap, 0.0) / RISE_TURN, 1.0)
    more = share * (1.0 / RATIO - 1.0) * B_TURN
    return np.asarray(np.r_[0.0, 0.0, 0.0, -B_TURN * V[3:] - more * worse * probe.J[3:]])


def _matrix(c: Combination, probe: Probe, V: Array) -> Array:
    """Matrix (6, 6) of the velocity law for a position: -B along the free directions, -B / ratio across them.

    A motion that reduces the violation counts as free, and a repelling role slows only the approach.
    """
    case, J, more = ROLES[c.role], probe.J, B / RATIO - B
    rate, out = float(J @ V), np.zeros((6, 6))
    if not case.attracts:
        n, share = J[:3], float(np.clip(1.0 - probe.gap / RANGE, 0.0, 1.0))
        out[:3, :3] = -share * (B * np.eye(3) + (more if rate < 0.0 else 0.0) * np.outer(n, n))
        return out
    share = min(max(-probe.gap, 0.0) / RISE, 1.0) if rate > 0.0 else 0.0
    across = np.eye(3) - free(c, probe.X)
    out[:3, :3] = -B * np.eye(3) - more * across
    if case.needs_point:  # rcm: damped along the whole gradient
        out[:3, :3] += more * np.outer(J[:3], J[:3])
        return np.asarray(out - more * (1.0 - share) * np.outer(J, J))
    out[:3, :3] += more * share * np.outer(J[:3], J[:3])
    return np.asarray(out)


def free(c: Combination, X: Array) -> Array:
    """Projector (3, 3) on the free directions of an attracting role: the tangents, or the shaft of `rcm`."""
    s, p = SPECIMENS[c.geometry], X[:3, 3]
    if ROLES[c.role].needs_point:
        return np.outer(X[:3, 2], X[:3, 2])
    n = p - nearest(s, p)
    n /= np.linalg.norm(n)
    if s.solid:
        return np.asarray(np.eye(3) - np.outer(n, n))
    t = s.axis(p)
    inside = s.axis is not up and abs(float(n @ t)) < 1e-6  # beyond its end a curve acts like a point
    return np.outer(t, t) if inside else np.zeros((3, 3))
