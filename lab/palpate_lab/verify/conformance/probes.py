"""Tool poses at which a role is checked: violated and satisfied poses where the constraint is smooth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import islice, product
from typing import TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.base.arrays import Array
from palpate_lab.verify.conformance.combinations import Combination
from palpate_lab.verify.conformance.roles import FAR, ROLES, SPEED, H, RoleCase, gradient, moved, slope
from palpate_lab.verify.conformance.specimens import SPECIMENS, Specimen

VIOLATED, SATISFIED, REJECTED = 4, 2, 1
"""Number of probes of a combination with a violated constraint, with a satisfied one, and where it is not smooth."""
POOL, TRIES = 6, 1500
"""Number of violated probes of a role with a geometry, and largest number of poses drawn to find them."""
UNEVEN = 10.0
"""Largest change of an orientation gradient within _LOOP [rad/m]."""
ASIDE = 2e-5
"""Displacement of a rejected pose [m, rad]: the search along the gradient ends exactly between two walls."""
INSIDE = 1e-4
"""Depth behind a border at which the nearest border must be the same [m]: twice what a hard `limit` keeps to it."""
T = TypeVar("T")
_DIRECTIONS = np.array([np.array(u) / np.linalg.norm(u) for u in product((-1, 0, 1), repeat=3) if any(u)])
_REACH, _CLOSE = 1.2e-3, 0.5e-3
"""Radius around a probe within which the normal turns little, and within which it is continuous [m]."""
_LOOP = 1.8e-3
"""Radius around a probe within which an orientation gradient is nearly constant [m]."""


@dataclass(frozen=True, eq=False)
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


@dataclass(frozen=True)
class Pool:
    """The places of a role with a geometry, for one seed."""

    violated: tuple[Probe, ...]
    """Probes with a violated constraint that is smooth around them."""
    satisfied: tuple[Probe, ...]
    rejected: tuple[Array, ...]
    """Violated poses (4, 4) where the constraint is not smooth."""
    rejected_share: float
    """Share of the violated poses that are not smooth, of all that were drawn [-]."""


@cache
def pool(role: str, geometry: str, seed: int) -> Pool:
    """Draws poses until there are POOL violated probes, or TRIES poses, and SATISFIED satisfied ones.

    Raises:
        LookupError: fewer than two violated or SATISFIED satisfied smooth poses were found.
    """
    case, s, rng = ROLES[role], SPECIMENS[geometry], _rng(role, geometry, seed)
    found: dict[bool, list[Probe]] = {True: [], False: []}
    rejected: list[Array] = []
    tries = count = 0
    while tries < TRIES and len(found[True]) < POOL:
        tries += 1
        probe = _drawn(case, s, rng, True)
        if probe is None:
            continue
        count += 1
        if is_smooth(case, s, probe, True):
            found[True].append(probe)
        else:
            rejected.append(_aside(s, probe.X, rng))
    for _ in range(TRIES):
        if len(found[False]) == SATISFIED:
            break
        probe = _drawn(case, s, rng, False)
        if probe is not None and is_smooth(case, s, probe, False):
            found[False].append(probe)
    if len(found[True]) < 2 or len(found[False]) < SATISFIED:
        raise LookupError(f"too few poses with a smooth constraint of {role} for a {geometry}")
    return Pool(tuple(found[True]), tuple(found[False]), tuple(rejected[:POOL]), len(rejected) / count)


def _aside(s: Specimen, X: Array, rng: np.random.Generator) -> Array:
    """X displaced by up to ASIDE to a pose (4, 4) that has no place between two walls within four steps of H."""
    for _ in range(20):
        Y = moved(X, ASIDE * rng.uniform(-1.0, 1.0, 6))
        near, far = (slope(s.distance, Y[:3, 3], h) for h in (H, 4.0 * H))
        if np.linalg.norm(far - near) < 1e-3 * np.linalg.norm(near):
            break
    return Y


def drawn(role: str, geometry: str, seed: int) -> tuple[float, int]:
    """Share of the drawn poses that were rejected [-], and number of places where the pair is judged."""
    try:
        found = pool(role, geometry, seed)
    except LookupError:
        return 1.0, 0
    return found.rejected_share, len(found.violated)


def probes(c: Combination) -> tuple[Probe, ...]:
    """VIOLATED probes with a violated constraint, then SATISFIED probes with a satisfied one.

    The combinations of a role and a geometry begin at different places of their pool, so that together they are judged
    at all places.
    """
    found = pool(c.role, c.geometry, c.seed)
    return (*_from(found.violated, c.turn)[:VIOLATED], *found.satisfied)


def rejected_poses(c: Combination) -> tuple[Array, ...]:
    """REJECTED violated poses (4, 4) where the constraint is not smooth, or fewer if there are not as many."""
    return _from(pool(c.role, c.geometry, c.seed).rejected, c.turn)[:REJECTED]


def _from(places: tuple[T, ...], start: int) -> tuple[T, ...]:
    k = start % max(len(places), 1)
    return (*places[k:], *places[:k])


def _rng(role: str, geometry: str, seed: int) -> np.random.Generator:
    return np.random.default_rng([seed, *map(ord, role + geometry)])


@cache
def unfiltered_poses(role: str, geometry: str, seed: int) -> tuple[Array, ...]:
    """Violated poses (4, 4) without a smoothness requirement, possibly near edges."""
    case, s, rng = ROLES[role], SPECIMENS[geometry], _rng(geometry, role, seed)
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


def _drawn(case: RoleCase, s: Specimen, rng: np.random.Generator, violated: bool) -> Probe | None:
    """A random probe near the specimen, with a constraint that is violated or satisfied; None without convergence."""
    if case.speed:
        X, direction = _random_pose(rng), rng.normal(size=3)
        u = direction / np.linalg.norm(direction)
        V = np.r_[(2.5 if violated else 0.5) * SPEED * u, 0.0, 0.0, 0.0]
        inside = abs(float(s.distance(X[None, :3, 3])[0])) < 0.5 * FAR
        return Probe(X, V, np.inf, np.r_[-u, 0.0, 0.0, 0.0]) if inside else None
    bad = (-0.5, -0.1) if case.turns else (-0.0035, -0.0008)
    good = (0.01, 0.04) if case.turns else (0.0001, 0.0004) if case.attracts else (0.0003, 0.001)
    Y = moved_to_gap(case, s, _random_pose(rng), float(rng.uniform(*(bad if violated else good))))
    if Y is None or np.abs(Y[:3, 3]).max() > 0.032:
        return None
    if case.touches and abs(float(s.distance(Y[None, :3, 3])[0])) > 0.5 * FAR:  # beyond its region it does not act
        return None
    return Probe(Y, np.zeros(6), case.gap(s, Y), gradient(case, s, Y))


def is_smooth(case: RoleCase, s: Specimen, probe: Probe, violated: bool) -> bool:
    """True if a combination can be judged at the probe by numbers that need a smooth constraint."""
    if case.speed:
        return True
    if (violated and not smooth(case, s, probe.X, probe.J)) or _satisfied_pose(case, s, probe.X) is None:
        return False
    pushes = not (case.attracts or case.touches)  # a potential already acts on a satisfied pose
    return not pushes or abs(float(np.linalg.norm(slope(s.distance, probe.X[:3, 3]))) - 1.0) < 1e-3


def _random_pose(rng: np.random.Generator) -> Array:
    X = np.eye(4)
    X[:3, 3] = rng.uniform(-0.03, 0.03, 3)
    X[:3, :3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    return X


def smooth(case: RoleCase, s: Specimen, X: Array, J: Array) -> bool:
    """The gradient of the distance has length one and turns little around the pose and at its corrected position."""
    p = X[:3, 3]
    if case.touches:
        return True
    if case.turns:
        return _aim_is_smooth(case, s, X, J)
    d, n = float(s.distance(p[None])[0]), slope(s.distance, p)
    if abs(np.linalg.norm(n) - 1.0) > 1e-3 or abs(d) < 5e-5:
        return False
    feet = [p - 0.98 * d * n]
    if not case.needs_point:
        feet.append(p + 0.98 * abs(case.gap(s, X)) * J[:3])
    if case.role == "limit":  # beside an edge its goal keeps to both walls
        feet.append(p + (abs(case.gap(s, X)) + INSIDE) * J[:3])
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
        there, back = (gradient(case, s, moved(X, np.r_[v, 0.0, 0.0, 0.0]), 3) - J[:3] for v in (u, -u))
        if max(np.linalg.norm(there), np.linalg.norm(back)) > UNEVEN or np.linalg.norm(there + back) > 0.4 * UNEVEN:
            return False
    return True
