"""Distances between an instrument and its world, and proofs that a whole motion keeps clear of it.

A motion is checked by bisection: at the middle of a stretch every pair must be farther apart than the clearance plus
the farthest that any point of the body can move within the stretch (`Robot.reach`). Otherwise the stretch is divided.
The proof has no step size, so nothing thin is jumped over. Source: Schwarzer, Saha and Latombe, "Adaptive dynamic
collision checking for single and multiple articulated robots in complex environments", IEEE T-RO 21(3), 2005.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.planning import geometry
from palpate.planning.allowed import checked_pairs
from palpate.planning.curves import Curve, line
from palpate.planning.own import OwnPairs
from palpate.planning.robot import Placed, Robot
from palpate.planning.world import World

_RESOLUTION = 5e-5  # a stretch whose points move less than this is refused if it cannot be proved free [m]
_FARTHEST = (
    8e-3  # Coal is asked for separations up to the clearance plus this: larger ones cost more than a division [m]
)
_PIECES = 4  # stretches that a motion is divided into first
_MOST = 20_000  # stretches of one motion


@dataclass(frozen=True)
class Nearest:
    """Two parts, their distance (negative: depth) [m], and the nearest points (3,) in W [m]."""

    pair: tuple[str, str]
    distance: float
    p_robot_W: Array
    p_world_W: Array


@dataclass(frozen=True)
class Blocked:
    """Why a motion is refused: the pair, and the place s in 0..1 along the motion."""

    pair: tuple[str, str]
    s: float


@dataclass(frozen=True)
class _Own:
    """Pairs of the robot's own bodies in the middle of K stretches."""

    low: Array  # (K, P) distances of the capsules [m]
    reach: Array  # (K, P) bounds of the motion of one against the other within the stretch [m]
    least: Array  # (K, P) the same of an infinitely short stretch [m]
    uncertain: NDArray[np.bool_]  # (K, P): True where the capsules do not prove the stretch


class Checker:
    """Checks one robot in one world.

    Args:
        robot: the instrument that moves.
        world: obstacles, at rest.
    """

    def __init__(self, robot: Robot, world: World) -> None:
        import coal

        self.robot, self.world = robot, world
        self.checks = 0  #: configurations examined so far
        bodies, obstacles = robot.bodies, world.obstacles
        self._solids = robot.solids
        self._bounds = np.array([o.bounds_W for o in obstacles]).reshape(-1, 2, 3)
        free = [not self._may_touch(b.name, b.link, o.name) for b in bodies for o in obstacles]
        self.pairs = np.array(free, dtype=bool).reshape(len(bodies), len(obstacles))
        """(B, O): True where a body must not touch an obstacle."""
        self.own_pairs = [(i, j) for i, j in checked_pairs(robot) if not self._may_meet(i, j)]
        """Pairs of the robot's own bodies that must not touch each other."""
        self._own = OwnPairs(robot, np.array(self.own_pairs, dtype=np.int64))
        self._collide: dict[tuple[int, int], Any] = {}
        self._distance: dict[tuple[int, int], Any] = {}
        self._request, self._result = coal.CollisionRequest(), coal.CollisionResult()
        self._ask, self._answer = coal.DistanceRequest(), coal.DistanceResult()
        self._closed = [k for k, o in enumerate(obstacles) if o.inside is not None]

    def _may_touch(self, body: str, link: str, obstacle: str) -> bool:
        owner = obstacle.partition("/")[0]
        names = {frozenset((x, y)) for x in (body, link, self.robot.name) for y in (obstacle, owner)}
        return bool(names & self.world.allowed)

    def _may_meet(self, i: int, j: int) -> bool:
        """True if the user allows two of the robot's own bodies to touch."""
        one, two = ({body.name, body.link} for body in (self.robot.bodies[i], self.robot.bodies[j]))
        return any(frozenset((a, b)) in self.world.allowed for a in one for b in two)

    # -- single configurations ---------------------------------------------------------------------------------------

    def nearest(self, q: Array, within: float = np.inf) -> list[Nearest]:
        """Pairs nearer than `within` [m] at q (n,), the nearest first; without `within`, only the nearest.

        Pairs of the robot's own bodies are checked for contact only, and are not among them.
        """
        placed = self.robot.placed(q[None])
        return self._nearest(placed, np.where(self.pairs, self._lower_bounds(placed)[0], np.inf), within)

    def _nearest(self, placed: Placed, low: Array, within: float) -> list[Nearest]:
        """As `nearest`, with lower bounds (B, O) of the distances; infinite where contact is allowed."""
        found: list[Nearest] = []
        best = within
        for index in np.argsort(low, axis=None):
            i, o = divmod(int(index), low.shape[1])
            if low[i, o] > best or not self.pairs[i, o]:
                break
            if best < _FARTHEST and self._touches(placed, 0, i, o, best) is None:
                continue  # a question that is answered much faster than the distance
            one = self._nearest_pair(placed, i, o)
            if one.distance <= best:
                found.append(one)
                best = one.distance if np.isinf(within) else within
        found.sort(key=lambda one: one.distance)
        return found if np.isfinite(within) else found[:1]

    def refusal(self, q: Array, clearance: float) -> Nearest | None:
        """The worst pair if q (n,) is nearer than `clearance` [m] to an obstacle, or inside one; None if q is free."""
        inside = self._inside(q)
        if inside is not None:
            return inside
        placed = self.robot.placed(q[None])
        low = self._lower_bounds(placed)[0]
        for i, o in np.argwhere(self.pairs & (low <= clearance)):
            if self._touches(placed, 0, int(i), int(o), clearance) is not None:
                return self.nearest(q, clearance + 1e-6)[0]
        low = self._own.low(placed)[0]
        for pair in np.nonzero(low <= 0.0)[0]:
            i, j = self.own_pairs[pair]
            apart = self._own.touches(placed, 0, int(pair), 0.0) if self._own.exact[pair] else float(low[pair])
            if apart is not None:
                a, b = placed.ends_W[0, i].mean(axis=0), placed.ends_W[0, j].mean(axis=0)
                return Nearest((self.robot.bodies[i].name, self.robot.bodies[j].name), min(apart, 0.0), a, b)
        return None

    def _inside(self, q: Array) -> Nearest | None:
        """The deepest body that has a point inside of a closed obstacle."""
        worst: Nearest | None = None
        probes, X_W = self.robot.probes, self.robot.placed(q[None]).X_W[0, self.robot.probes.body]
        p = (X_W[:, :3, :3] @ probes.points[..., None])[..., 0] + X_W[:, :3, 3]
        for k in self._closed:
            obstacle = self.world.obstacles[k]
            X, (low, high) = obstacle.X_WO, obstacle.bounds_W
            near = np.nonzero(((p > low) & (p < high)).all(axis=1) & self.pairs[probes.body, k])[0]
            if not len(near) or obstacle.inside is None:
                continue
            signed = obstacle.inside((p[near] - X[:3, 3]) @ X[:3, :3])
            deep = signed - probes.depth[near]
            deepest = int(np.argmin(deep))
            if signed[deepest] < 0.0 and (worst is None or deep[deepest] < worst.distance):
                names = (self.robot.bodies[probes.body[near[deepest]]].name, obstacle.name)
                worst = Nearest(names, float(deep[deepest]), p[near[deepest]], p[near[deepest]])
        return worst

    # -- motions -----------------------------------------------------------------------------------------------------

    def free_line(self, a: Array, b: Array, clearance: float) -> bool:
        """True if the straight motion of the joints from a to b (n,) is proved to keep the clearance [m]."""
        return self.blocked(line(a, b), clearance) is None

    def blocked(self, curve: Curve, clearance: float, spread: float = 0.0) -> Blocked | None:
        """None if the whole motion is proved to keep the clearance [m]; otherwise where it cannot be proved.

        spread: joints need not move in step: each may be ahead of the others or behind them by this part of the curve,
            q_j(s + e_j) with |e_j| <= spread [-].
        """
        bodies, todo = self._active(curve, clearance, spread)
        left = np.broadcast_to(self.pairs[bodies], (len(todo), len(bodies), self.pairs.shape[1]))
        own_left = np.ones((len(todo), len(self.own_pairs)), dtype=bool)
        while len(todo):
            middle, half = todo[:, 0], todo[:, 1]
            self.checks += len(middle)
            placed = self.robot.placed(curve.at(middle), bodies)
            reach = self.robot.reach(placed, curve.rate, half + spread)
            least = self.robot.reach(placed, curve.rate, np.full_like(half, spread)) if spread else np.zeros_like(reach)
            uncertain = left & (self._lower_bounds(placed) <= clearance + reach[:, :, None])
            own = self._own_stretches(placed, curve.rate, half, spread, own_left)
            parts: list[Array] = []
            masks: list[NDArray[np.bool_]] = []
            own_masks: list[NDArray[np.bool_]] = []
            for k in np.argsort(-half, kind="stable"):
                answer = self._stretch(placed, int(k), reach[k], least[k], uncertain[k], clearance)
                own_answer = self._own_stretch(placed, int(k), own)
                if isinstance(answer, tuple):
                    return Blocked(answer, float(middle[k]))
                if isinstance(own_answer, tuple):
                    return Blocked(own_answer, float(middle[k]))
                if answer.any() or own_answer.any():
                    pieces = int(np.clip(np.ceil(reach[k].max() / _FARTHEST), 2, 8))
                    parts.append(_divided(middle[k], half[k], pieces))
                    masks += [answer] * pieces
                    own_masks += [own_answer] * pieces
            if len(masks) > _MOST:
                return Blocked(("motion", "too long to prove"), float(middle[0]))
            if not parts:
                return None
            todo, left, own_left = np.concatenate(parts), np.array(masks), np.array(own_masks)
        return None

    def _active(self, curve: Curve, clearance: float, spread: float) -> tuple[NDArray[np.int64], Array]:
        """Bodies that the motion could bring near an obstacle, and the first stretches (k, 2): middle and half."""
        whole = np.array([[0.5, 0.5]])
        placed = self.robot.placed(curve.at(whole[:, 0]))
        reach = self.robot.reach(placed, curve.rate, whole[:, 1] + spread)
        near = self.pairs & (self._lower_bounds(placed)[0] <= clearance + reach[0][:, None])
        active = near.any(axis=1)
        for i, j in self.own_pairs:
            active[[i, j]] = True
        bodies = np.nonzero(active)[0]
        return bodies, _divided(0.5, 0.5, _PIECES) if len(bodies) else whole[:0]

    def _stretch(
        self, placed: Placed, k: int, reach: Array, least: Array, uncertain: Array, clearance: float
    ) -> tuple[str, str] | NDArray[np.bool_]:
        """The names of the pair that blocks a stretch, or the pairs (B, O) that need smaller stretches.

        least (B,): reach of an infinitely short stretch [m]; a stretch that has little more is not divided again.
        """
        undecided = np.zeros(uncertain.shape, dtype=bool)
        for i, o in np.argwhere(uncertain):
            extra = min(float(reach[i]), _FARTHEST)
            found = self._touches(placed, k, int(i), int(o), clearance + extra)
            if found is None and extra == reach[i]:
                continue
            names = (self.robot.bodies[placed.bodies[i]].name, self.world.obstacles[o].name)
            if reach[i] <= max(_RESOLUTION, 1.5 * least[i]) or (found is not None and found < clearance + least[i]):
                return names
            if found is not None and self._touches(placed, k, int(i), int(o), clearance) is not None:
                return names
            undecided[i, o] = True
        return undecided

    def _own_stretches(self, placed: Placed, rate: Array, half: Array, spread: float, left: NDArray[np.bool_]) -> _Own:
        """Distances and relative motions of the robot's own pairs (K, P), where `left` (K, P) asks for them."""
        if not self.own_pairs:
            none = np.zeros((len(half), 0))
            return _Own(none, none, none, none.astype(bool))
        places = self._own.places(placed)
        reach = self.robot.reach_between(placed, places, rate, half + spread)
        least = np.zeros_like(reach)
        if spread:
            least = self.robot.reach_between(placed, places, rate, np.full_like(half, spread))
        low = self._own.low(placed)
        return _Own(low, reach, least, left & (low <= reach))

    def _own_stretch(self, placed: Placed, k: int, own: _Own) -> tuple[str, str] | NDArray[np.bool_]:
        """As `_stretch` for the robot's own pairs, which must not touch; they need no clearance."""
        undecided = np.zeros(len(self.own_pairs), dtype=bool)
        for pair in np.nonzero(own.uncertain[k])[0]:
            reach, least, found = float(own.reach[k, pair]), float(own.least[k, pair]), None
            names = tuple(self.robot.bodies[body].name for body in self.own_pairs[pair])
            if self._own.exact[pair]:
                extra = min(reach, _FARTHEST)
                found = self._own.touches(placed, k, int(pair), extra)
                if found is None and extra == reach:
                    continue
                if found is not None and self._own.touches(placed, k, int(pair), 0.0) is not None:
                    return names[0], names[1]
            else:
                found = float(own.low[k, pair])
            if reach <= max(_RESOLUTION, 1.5 * least) or (found is not None and found <= least):
                return names[0], names[1]
            undecided[pair] = True
        return undecided

    # -- inside ------------------------------------------------------------------------------------------------------

    def _lower_bounds(self, placed: Placed) -> Array:
        """Lower bounds (K, B, O) of all distances, from bounding spheres and boxes [m]."""
        centres, chunks = placed.spheres()
        c = centres[:, :, None]
        outside = np.maximum(np.maximum(self._bounds[:, 0] - c, c - self._bounds[:, 1]), 0.0)
        apart = np.sqrt(np.einsum("kcoi,kcoi->kco", outside, outside)) - chunks.radius[:, None]
        return np.asarray(np.minimum.reduceat(apart, chunks.first, axis=1))

    def _transform(self, placed: Placed, k: int, i: int) -> Any:
        X = placed.X_W[k, i] @ self._solids[placed.bodies[i]][1]
        return geometry.transform(X[:3, :3], X[:3, 3])

    def _touches(self, placed: Placed, k: int, i: int, o: int, margin: float) -> float | None:
        """None if body i is farther than `margin` [m] from obstacle o; otherwise an upper bound of their distance."""
        import coal

        obstacle, body = self.world.obstacles[o], int(placed.bodies[i])
        query = self._collide.get((body, o))
        if query is None:
            query = self._collide[body, o] = coal.ComputeCollision(self._solids[body][0], obstacle.solid.coal)
        self._request.security_margin = margin + obstacle.solid.inflation
        self._result.clear()
        if query(self._transform(placed, k, i), obstacle.transform, self._request, self._result) == 0:
            return None
        return float(self._result.getContact(0).penetration_depth) - obstacle.solid.inflation

    def _nearest_pair(self, placed: Placed, i: int, o: int) -> Nearest:
        import coal

        obstacle, body = self.world.obstacles[o], int(placed.bodies[i])
        query = self._distance.get((body, o))
        if query is None:
            query = self._distance[body, o] = coal.ComputeDistance(self._solids[body][0], obstacle.solid.coal)
        self._answer.clear()
        value = query(self._transform(placed, 0, i), obstacle.transform, self._ask, self._answer)
        names = (self.robot.bodies[body].name, obstacle.name)
        p, w = self._answer.getNearestPoint1().copy(), self._answer.getNearestPoint2().copy()
        return Nearest(names, float(value) - obstacle.solid.inflation, p, w)


def _divided(middle: float, half: float, pieces: int) -> Array:
    """Equal stretches (pieces, 2) of a stretch, as middle and half."""
    width = half / pieces
    return np.stack([middle - half + (2.0 * np.arange(pieces) + 1.0) * width, np.full(pieces, width)], axis=1)
