"""Poses of the tool at which a role is examined: not as wanted, and as wanted, all where the answer is smooth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import islice, product

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.arrays import Array
from palpate.verify.conformance.roles import FAR, ROLES, SPEED, H, RoleCase, gradient, moved, slope
from palpate.verify.conformance.specimens import SPECIMENS, Specimen

WRONG, RIGHT = 4, 2
"""How many of each."""
UNEVEN = 10.0
"""Most that the turn of an aim changes within _LOOP [rad/m]."""
_EVERY_WAY = np.array([np.array(u) / np.linalg.norm(u) for u in product((-1, 0, 1), repeat=3) if any(u)])
_REACH, _CLOSE = 1.2e-3, 0.5e-3
"""Around a probe the normal turns little; closer, it does not leap [m]."""
_LOOP = 1.8e-3
"""So far around it an aim turns as at the probe [m]."""


@dataclass(frozen=True)
class Probe:
    """A pose of the tool, with what a role wants there."""

    X: Array
    """(4, 4)."""
    V: Array
    """(6,) that the tool is told to have there, linear over angular: nothing but where speed counts."""
    gap: float
    """[m, rad]."""
    along: Array
    """(6,) slope of the gap over the six motions; of a limit of speed against the motion."""

    @property
    def wrong(self) -> bool:
        """Not as wanted."""
        return self.gap < 0.0 or float(np.linalg.norm(self.V[:3])) > SPEED


@cache
def probes(role: str, geometry: str) -> tuple[Probe, ...]:
    """WRONG poses that are not as wanted, then RIGHT that are. Seeded by the names; LookupError: there are too few."""
    case, s = ROLES[role], SPECIMENS[geometry]
    rng = np.random.default_rng(sum(map(ord, role + geometry)))
    find = _fast if case.speed else _placed
    found: dict[bool, list[Probe]] = {True: [], False: []}
    for _ in range(600):
        wrong = len(found[True]) < WRONG
        if not wrong and len(found[False]) == RIGHT:
            return (*found[True], *found[False])
        probe = find(case, s, rng, wrong)
        if probe is not None:
            found[wrong].append(probe)
    raise LookupError(f"too few places where {role} has a smooth answer beside a {geometry}")


@cache
def rough(role: str, geometry: str) -> tuple[Array, ...]:
    """RIGHT poses (4, 4) that are not as wanted, wherever they may be: beside edges, too."""
    case, s = ROLES[role], SPECIMENS[geometry]
    rng = np.random.default_rng(sum(map(ord, geometry + role)))
    if case.speed:
        return tuple(_random_pose(rng) for _ in range(RIGHT))
    tried = (brought(case, s, _random_pose(rng), -0.3 if case.turns else -0.0025) for _ in range(100))
    return tuple(islice((X for X in tried if X is not None and _well(case, s, X) is not None), RIGHT))


def beside(role: str, geometry: str, X: Array) -> Array:
    """(4, 4) beside a pose, where all is well; LookupError where there is no way to it."""
    found = _well(ROLES[role], SPECIMENS[geometry], X)
    if found is None:
        raise LookupError(f"no way to where all is well for {role} beside a {geometry} from {np.round(X[:3, 3], 4)}")
    return found


def _well(case: RoleCase, s: Specimen, X: Array) -> Array | None:
    return X if case.speed else brought(case, s, X, 0.03 if case.turns else 2e-4)


def brought(case: RoleCase, s: Specimen, X: Array, goal: float) -> Array | None:
    """X moved up or down the slope until its gap is the goal (within 1e-5); None where it does not get there."""
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
    """What a role wants of a tool at rest at X."""
    case, s = ROLES[role], SPECIMENS[geometry]
    return Probe(X, np.zeros(6), case.gap(s, X), gradient(case, s, X))


def _fast(case: RoleCase, s: Specimen, rng: np.random.Generator, wrong: bool) -> Probe | None:
    X, way = _random_pose(rng), rng.normal(size=3)
    if abs(float(s.distance(X[None, :3, 3])[0])) > 0.5 * FAR:
        return None
    u = way / np.linalg.norm(way)
    return Probe(X, np.r_[(2.5 if wrong else 0.5) * SPEED * u, 0.0, 0.0, 0.0], np.inf, np.r_[-u, 0.0, 0.0, 0.0])


def _placed(case: RoleCase, s: Specimen, rng: np.random.Generator, wrong: bool) -> Probe | None:
    bad = (-0.5, -0.1) if case.turns else (-0.0035, -0.0008)
    good = (0.01, 0.04) if case.turns else (0.0001, 0.0004) if case.attracts else (0.0003, 0.001)
    goal = float(rng.uniform(*(bad if wrong else good)))
    X = brought(case, s, _random_pose(rng), goal)
    if X is None or np.abs(X[:3, 3]).max() > 0.032:
        return None
    along = gradient(case, s, X)
    if wrong and not smooth(case, s, X, along):
        return None
    if _well(case, s, X) is None:
        return None
    pushes = not (case.attracts or case.touches)  # a potential does here already
    if pushes and abs(np.linalg.norm(slope(s.distance, X[:3, 3])) - 1.0) > 1e-3:
        return None
    return Probe(X, np.zeros(6), case.gap(s, X), along)


def _random_pose(rng: np.random.Generator) -> Array:
    X = np.eye(4)
    X[:3, 3] = rng.uniform(-0.03, 0.03, 3)
    X[:3, :3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    return X


def smooth(case: RoleCase, s: Specimen, X: Array, along: Array) -> bool:
    """The distance's slope is of length one, and turns little within a millimetre, and where a correction leads to."""
    p = X[:3, 3]
    if case.touches:
        return abs(float(s.distance(p[None])[0])) < 0.5 * FAR
    if case.turns:
        return _aim_is_smooth(case, s, X, along)
    d, n = float(s.distance(p[None])[0]), slope(s.distance, p)
    if abs(np.linalg.norm(n) - 1.0) > 1e-3 or abs(d) < 5e-5:
        return False
    feet = [p - 0.98 * d * n]
    if not case.needs_point:
        feet.append(p + 0.98 * abs(case.gap(s, X)) * along[:3])
    turns_little = all(float(slope(s.distance, p + _REACH * u) @ n) > 0.7 for u in _EVERY_WAY) and not _leaps(s, p)
    return turns_little and all(float(slope(s.distance, q) @ n) > 0.999 for q in feet)


def _leaps(s: Specimen, p: Array) -> bool:
    """The normal leaps somewhere on the rays around p, by 6 degrees or more in a tenth of _CLOSE."""
    places = p + _CLOSE * np.linspace(0.0, 1.0, 11)[None, :, None] * _EVERY_WAY[:, None, :]
    steps = H * np.concatenate([np.eye(3), -np.eye(3)])
    d = s.distance((places[:, :, None, :] + steps).reshape(-1, 3)).reshape(*places.shape[:2], 6)
    n = (d[..., :3] - d[..., 3:]) / (2.0 * H)
    return bool(np.linalg.norm(np.diff(n, axis=1), axis=2).max() > 0.1)


def _aim_is_smooth(case: RoleCase, s: Specimen, X: Array, along: Array) -> bool:
    """What a tool is turned to turns little with the place, and as much beside, as far as the closed loops go."""
    half = len(_EVERY_WAY) // 2
    for u in _LOOP * _EVERY_WAY[:half]:
        there, back = (gradient(case, s, moved(X, np.r_[v, 0.0, 0.0, 0.0]))[:3] - along[:3] for v in (u, -u))
        if max(np.linalg.norm(there), np.linalg.norm(back)) > UNEVEN or np.linalg.norm(there + back) > 0.4 * UNEVEN:
            return False
    return True
