"""Tool poses at which a role is checked: violated and satisfied poses where the constraint is smooth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import islice, product

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.arrays import Array
from palpate.verify.conformance.roles import FAR, ROLES, SPEED, H, RoleCase, gradient, moved, slope
from palpate.verify.conformance.specimens import SPECIMENS, Specimen

VIOLATED, SATISFIED = 4, 2
"""Number of probes with a violated constraint, and with a satisfied one."""
UNEVEN = 10.0
"""Largest change of an orientation gradient within _LOOP [rad/m]."""
_DIRECTIONS = np.array([np.array(u) / np.linalg.norm(u) for u in product((-1, 0, 1), repeat=3) if any(u)])
_REACH, _CLOSE = 1.2e-3, 0.5e-3
"""Radius around a probe within which the normal turns little, and within which it is continuous [m]."""
_LOOP = 1.8e-3
"""Radius around a probe within which an orientation gradient is nearly constant [m]."""


@dataclass(frozen=True)
class Probe:
    """A tool pose with a role's constraint at this pose."""

    X: Array
    """Pose (4, 4)."""
    V: Array
    """Reported twist (6,), linear over angular; nonzero only for roles that limit speed [m/s, rad/s]."""
    gap: float
    """Constraint value, negative if violated [m, rad]."""
    J: Array
    """Gradient (6,) of the constraint value with respect to the pose; for a speed limit, opposite to the motion."""

    @property
    def violated(self) -> bool:
        """True if the constraint or the speed limit is violated."""
        return self.gap < 0.0 or float(np.linalg.norm(self.V[:3])) > SPEED


@cache
def probes(role: str, geometry: str) -> tuple[Probe, ...]:
    """VIOLATED probes with a violated constraint, then SATISFIED probes with a satisfied one, seeded by the names.

    Raises:
        LookupError: too few smooth poses were found.
    """
    case, s = ROLES[role], SPECIMENS[geometry]
    rng = np.random.default_rng(sum(map(ord, role + geometry)))
    find = _speed_probe if case.speed else _position_probe
    found: dict[bool, list[Probe]] = {True: [], False: []}
    for _ in range(600):
        violated = len(found[True]) < VIOLATED
        if not violated and len(found[False]) == SATISFIED:
            return (*found[True], *found[False])
        probe = find(case, s, rng, violated)
        if probe is not None:
            found[violated].append(probe)
    raise LookupError(f"too few poses with a smooth constraint of {role} for a {geometry}")


@cache
def unfiltered_poses(role: str, geometry: str) -> tuple[Array, ...]:
    """Violated poses (4, 4) without a smoothness requirement, possibly near edges."""
    case, s = ROLES[role], SPECIMENS[geometry]
    rng = np.random.default_rng(sum(map(ord, geometry + role)))
    if case.speed:
        return tuple(_random_pose(rng) for _ in range(SATISFIED))
    tried = (moved_to_gap(case, s, _random_pose(rng), -0.3 if case.turns else -0.0025) for _ in range(100))
    return tuple(islice((X for X in tried if X is not None and _satisfied_pose(case, s, X) is not None), SATISFIED))


def satisfied_pose(role: str, geometry: str, X: Array) -> Array:
    """A satisfied pose (4, 4) near X; raises LookupError if none is reachable along the gradient."""
    found = _satisfied_pose(ROLES[role], SPECIMENS[geometry], X)
    if found is None:
        raise LookupError(f"no satisfied pose for {role} and a {geometry} near {np.round(X[:3, 3], 4)}")
    return found


def _satisfied_pose(case: RoleCase, s: Specimen, X: Array) -> Array | None:
    return X if case.speed else moved_to_gap(case, s, X, 0.03 if case.turns else 2e-4)


def moved_to_gap(case: RoleCase, s: Specimen, X: Array, goal: float) -> Array | None:
    """X moved along the gradient until its gap equals the goal within 1e-5; None without convergence."""
    for _ in range(12):
        now = case.gap(s, X)
        if abs(now - goal) < 1e-5:
            return X
        step = gradient(case, s, X)
        step[slice(0, 3) if case.turns else slice(3, 6)] = 0.0
        size = float(step @ step)
        if not 0.01 < size < 4.0:
            return None
        X = moved(X, np.clip((goal - now) / size, -0.5, 0.5) * step)
    return None


def probe_at(role: str, geometry: str, X: Array) -> Probe:
    """The probe of a role for a tool at rest at X (4, 4)."""
    case, s = ROLES[role], SPECIMENS[geometry]
    return Probe(X, np.zeros(6), case.gap(s, X), gradient(case, s, X))


def _speed_probe(case: RoleCase, s: Specimen, rng: np.random.Generator, violated: bool) -> Probe | None:
    X, direction = _random_pose(rng), rng.normal(size=3)
    if abs(float(s.distance(X[None, :3, 3])[0])) > 0.5 * FAR:
        return None
    u = direction / np.linalg.norm(direction)
    return Probe(X, np.r_[(2.5 if violated else 0.5) * SPEED * u, 0.0, 0.0, 0.0], np.inf, np.r_[-u, 0.0, 0.0, 0.0])


def _position_probe(case: RoleCase, s: Specimen, rng: np.random.Generator, violated: bool) -> Probe | None:
    bad = (-0.5, -0.1) if case.turns else (-0.0035, -0.0008)
    good = (0.01, 0.04) if case.turns else (0.0001, 0.0004) if case.attracts else (0.0003, 0.001)
    goal = float(rng.uniform(*(bad if violated else good)))
    X = moved_to_gap(case, s, _random_pose(rng), goal)
    if X is None or np.abs(X[:3, 3]).max() > 0.032:
        return None
    J = gradient(case, s, X)
    if violated and not smooth(case, s, X, J):
        return None
    if _satisfied_pose(case, s, X) is None:
        return None
    pushes = not (case.attracts or case.touches)  # a potential already acts on a satisfied pose
    if pushes and abs(np.linalg.norm(slope(s.distance, X[:3, 3])) - 1.0) > 1e-3:
        return None
    return Probe(X, np.zeros(6), case.gap(s, X), J)


def _random_pose(rng: np.random.Generator) -> Array:
    X = np.eye(4)
    X[:3, 3] = rng.uniform(-0.03, 0.03, 3)
    X[:3, :3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    return X


def smooth(case: RoleCase, s: Specimen, X: Array, J: Array) -> bool:
    """The gradient of the distance has length one and turns little around the pose and at its corrected position."""
    p = X[:3, 3]
    if case.touches:
        return abs(float(s.distance(p[None])[0])) < 0.5 * FAR
    if case.turns:
        return _aim_is_smooth(case, s, X, J)
    d, n = float(s.distance(p[None])[0]), slope(s.distance, p)
    if abs(np.linalg.norm(n) - 1.0) > 1e-3 or abs(d) < 5e-5:
        return False
    feet = [p - 0.98 * d * n]
    if not case.needs_point:
        feet.append(p + 0.98 * abs(case.gap(s, X)) * J[:3])
    turns_little = all(float(slope(s.distance, p + _REACH * u) @ n) > 0.7 for u in _DIRECTIONS)
    return turns_little and not _has_discontinuity(s, p) and all(float(slope(s.distance, q) @ n) > 0.999 for q in feet)


def _has_discontinuity(s: Specimen, p: Array) -> bool:
    """True if the normal changes by more than 6 degrees within a tenth of _CLOSE on a ray from p."""
    places = p + _CLOSE * np.linspace(0.0, 1.0, 11)[None, :, None] * _DIRECTIONS[:, None, :]
    steps = H * np.concatenate([np.eye(3), -np.eye(3)])
    d = s.distance((places[:, :, None, :] + steps).reshape(-1, 3)).reshape(*places.shape[:2], 6)
    n = (d[..., :3] - d[..., 3:]) / (2.0 * H)
    return bool(np.linalg.norm(np.diff(n, axis=1), axis=2).max() > 0.1)


def _aim_is_smooth(case: RoleCase, s: Specimen, X: Array, J: Array) -> bool:
    """The orientation gradient is nearly constant in position, up to the radius of the closed loops."""
    half = len(_DIRECTIONS) // 2
    for u in _LOOP * _DIRECTIONS[:half]:
        there, back = (gradient(case, s, moved(X, np.r_[v, 0.0, 0.0, 0.0]))[:3] - J[:3] for v in (u, -u))
        if max(np.linalg.norm(there), np.linalg.norm(back)) > UNEVEN or np.linalg.norm(there + back) > 0.4 * UNEVEN:
            return False
    return True
