"""What roles want and laws give, restated in numpy from their words; slopes by finite differences of it.

A role wants one number, its gap, not to be below zero [m; rad where it turns the tool]. Its slope along the six motions
of the tool (linear over angular, about the tip) is the direction that a wrench has to have.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from palpate import _core
from palpate.conformance.specimens import SPECIMENS, Specimen

Array = NDArray[np.float64]
Gap = Callable[[Specimen, Array], float]

H = 1e-6
"""Step of the differences [m, rad]."""
LEVER = 0.05
"""Metres that a turn of one radian counts as, where both are compared [m/rad]."""

FREE, MARGIN, KEPT, TILT, TROCAR = 0.0005, 0.004, 0.001, 0.05, 0.0005


def slope(f: Callable[[Array], Array], p: Array, h: float = H) -> Array:
    """(3,) gradient of f (n, 3) -> (n,) at p (3,)."""
    steps = np.concatenate([np.eye(3), -np.eye(3)]) * h
    d = f(p + steps)
    return np.asarray((d[:3] - d[3:]) / (2.0 * h))


def nearest(specimen: Specimen, p: Array) -> Array:
    """(3,) the geometry's place nearest to p: as far as the distance says, down its slope."""
    d = float(specimen.distance(p[None])[0])
    n = slope(specimen.distance, p)
    return np.asarray(p - d * n / np.linalg.norm(n))


def moved(X: Array, y: Array) -> Array:
    """(4, 4) pose X moved by y (6,), turned about its own origin."""
    out = X.copy()
    out[:3, 3] += y[:3]
    out[:3, :3] = Rotation.from_rotvec(y[3:]).as_matrix() @ X[:3, :3]
    return out


def _between(a: Array, b: Array) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _axis_of(s: Specimen, p: Array) -> Array:
    return s.axis(p) if s.axis is not None else np.array([0.0, 0.0, 1.0])


def _guide(s: Specimen, X: Array) -> float:
    return FREE - abs(float(s.distance(X[None, :3, 3])[0]))


def _forbid(s: Specimen, X: Array) -> float:
    return float(s.distance(X[None, :3, 3])[0]) - MARGIN


def _keep_in(s: Specimen, X: Array) -> float:
    return -float(s.distance(X[None, :3, 3])[0]) - KEPT


def _workspace(s: Specimen, X: Array) -> float:
    return -float(s.distance(X[None, :3, 3])[0])


def _orient_axis(s: Specimen, X: Array) -> float:
    return TILT - _between(X[:3, 2], _axis_of(s, X[:3, 3]))


def _orient_normal(s: Specimen, X: Array) -> float:
    return TILT - _between(X[:3, 2], -slope(s.distance, X[:3, 3]))


def _rcm(s: Specimen, X: Array) -> float:
    to = nearest(s, X[:3, 3]) - X[:3, 3]
    a = X[:3, 2]
    return TROCAR - float(np.linalg.norm(to - a * (a @ to)))


@dataclass(frozen=True)
class RoleCase:
    """A role with options under which it is examined."""

    role: str
    options: dict[str, Any]
    gap: Gap
    attracts: bool = False
    turns: bool = False
    needs_solid: bool = False
    frozen: bool = False
    """the nearest place is taken to stay where it is while the slope is found: the role is about that place."""


#: By name; each role of the core has at least one.
ROLES: dict[str, RoleCase] = {
    "guide": RoleCase("guide", {"margin": FREE}, _guide, attracts=True),
    "forbid": RoleCase("forbid", {"margin": MARGIN}, _forbid),
    "forbid, no margin": RoleCase("forbid", {}, lambda s, X: _forbid(s, X) + MARGIN, needs_solid=True),
    "keep-in": RoleCase("keep-in", {"margin": KEPT}, _keep_in, needs_solid=True),
    "limit of the workspace": RoleCase("limit", {}, _workspace, needs_solid=True),
    "orient along the axis": RoleCase("orient", {"angle": TILT}, _orient_axis, attracts=True, turns=True),
    "orient against the normal": RoleCase("orient", {"angle": TILT, "target": "normal"}, _orient_normal, attracts=True,
                                          turns=True),
    "rcm": RoleCase("rcm", {"margin": TROCAR}, _rcm, attracts=True, frozen=True),
}  # fmt: skip


@dataclass(frozen=True)
class Probe:
    """A pose of the tool, with what a role wants there."""

    X: Array
    """(4, 4)."""
    gap: float
    """[m, rad]."""
    along: Array
    """(6,) slope of the gap over the six motions."""


def wants(case: RoleCase, s: Specimen, X: Array) -> Probe:
    """What a role wants of a tool at X, its slope by differences."""
    gap = case.gap
    if case.frozen:
        c = nearest(s, X[:3, 3])
        s = Specimen(s.make, lambda p: np.linalg.norm(p - c, axis=1), False)
    if case.turns:
        frozen_axis = _axis_of(s, X[:3, 3]) if case.options.get("target") != "normal" else -slope(s.distance, X[:3, 3])
        frozen_axis = frozen_axis / np.linalg.norm(frozen_axis)

        def gap(_: Specimen, Y: Array) -> float:  # the place stays: a turn about the tip does not move it
            return TILT - _between(Y[:3, 2], frozen_axis)

    steps = H * np.eye(6)
    along = np.array([gap(s, moved(X, y)) - gap(s, moved(X, -y)) for y in steps]) / (2.0 * H)
    if case.turns:
        along[:3] = 0.0
    return Probe(X, gap(s, X), along)


@cache
def probes(role: str, geometry: str, wrong: int = 4, right: int = 2) -> tuple[Probe, ...]:
    """Poses that are not as wanted, then poses that are; all where the answer turns smoothly. Seeded by the names."""
    case, s = ROLES[role], SPECIMENS[geometry]
    rng = np.random.default_rng(sum(map(ord, role + geometry)))
    found: dict[bool, list[Probe]] = {True: [], False: []}
    bad = (-0.5, -0.1) if case.turns else (-0.0035, -0.0008)
    good = (0.01, 0.04) if case.turns else (0.0001, 0.0004) if case.attracts else (0.0003, 0.001)
    for _ in range(400):
        is_wrong = len(found[True]) < wrong
        if not is_wrong and len(found[False]) == right:
            break
        goal = rng.uniform(*(bad if is_wrong else good))
        X = _brought(case, s, _random_pose(rng), goal)
        if (
            X is not None
            and np.abs(X[:3, 3]).max() < 0.032
            and ((case.attracts and not is_wrong) or _smooth(case, s, X))
        ):
            found[is_wrong].append(wants(case, s, X))
    if len(found[True]) < wrong or len(found[False]) < right:
        raise LookupError(f"{role} x {geometry}: too few places to judge it at")
    return (*found[True], *found[False])


def _random_pose(rng: np.random.Generator) -> Array:
    X = np.eye(4)
    X[:3, 3] = rng.uniform(-0.03, 0.03, 3)
    X[:3, :3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    return X


def _brought(case: RoleCase, s: Specimen, X: Array, goal: float) -> Array | None:
    """X moved up or down the slope until its gap is the goal."""
    for _ in range(12):
        now = wants(case, s, X)
        if abs(now.gap - goal) < 1e-5:
            return X
        step = now.along if case.turns else np.r_[now.along[:3], np.zeros(3)]
        size = float(step @ step)
        if not 0.01 < size < 4.0:
            return None
        X = moved(X, np.clip((goal - now.gap) / size, -0.5, 0.5) * step)
    return None


def _smooth(case: RoleCase, s: Specimen, X: Array, reach: float = 1.2e-3) -> bool:
    """The distance's slope is of length one, and turns little within a millimetre, and where a correction leads to."""
    p = X[:3, 3]
    d, n = float(s.distance(p[None])[0]), slope(s.distance, p)
    if abs(np.linalg.norm(n) - 1.0) > 1e-3 or abs(d) < 5e-5:
        return False
    feet = [p - 0.98 * d * n]
    if not case.turns and not case.frozen:
        feet.append(p + 0.98 * abs(case.gap(s, X)) * wants(case, s, X).along[:3])
    around = [p + reach * e for e in (*np.eye(3), *-np.eye(3))]
    turns_little = all(float(slope(s.distance, q) @ n) > 0.7 for q in around)
    return turns_little and all(float(slope(s.distance, q) @ n) > 0.99 for q in feet)


@dataclass(frozen=True)
class LawCase:
    """A law with options under which it is examined."""

    law: str
    options: dict[str, float] = field(default_factory=dict)
    force: Callable[[float, bool, bool], float] | None = None
    """(gap, attracts, turns) -> force or moment of a tool at rest; None for a law of motions alone."""


K, B, K_TURN, B_TURN, MOST, MOMENT, RANGE, RANGE_TURN, RATIO = 400.0, 2.0, 0.5, 0.005, 1.0, 0.1, 0.01, 0.8, 0.1
_OPTIONS = {"K": K, "B": B, "K_turn": K_TURN, "B_turn": B_TURN, "force": MOST, "moment": MOMENT, "range": RANGE,
            "range_turn": RANGE_TURN, "ratio": RATIO}  # fmt: skip


def _spring(gap: float, attracts: bool, turns: bool) -> float:
    return (K_TURN if turns else K) * max(-gap, 0.0)


def _optimise(gap: float, attracts: bool, turns: bool) -> float:
    return min(_spring(gap, attracts, turns), MOMENT if turns else MOST)


def _potential(gap: float, attracts: bool, turns: bool) -> float:
    """Attracts: rises, stays, fades over the last fifth of its range. Repels: from its range on, before the border."""
    k, most, reach = (K_TURN, MOMENT, RANGE_TURN) if turns else (K, MOST, RANGE)
    if not attracts:
        return min(k * max(reach - gap, 0.0), most)
    e = max(-gap, 0.0)
    return min(k * e, most, k * 0.8 * reach) * float(np.clip((reach - e) / (0.2 * reach), 0.0, 1.0))


#: By name of the core's.
LAWS: dict[str, LawCase] = {
    "spring": LawCase("spring", _OPTIONS, _spring),
    "potential": LawCase("potential", _OPTIONS, _potential),
    "admittance": LawCase("admittance", _OPTIONS),
    "optimise": LawCase("optimise", _OPTIONS, _optimise),
}


def unjudged() -> list[str]:
    """Roles and laws of the core that nothing here judges."""
    roles = {case.role for case in ROLES.values()} | {"limit"}
    return [r for r in _core.guidance_roles() if r not in roles] + [n for n in _core.guidance_laws() if n not in LAWS]
