"""Contact between two bodies of one instrument: capsules in closed form, meshes and primitives by Coal."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.planning import geometry
from palpate.planning.robot import Placed, Robot


class OwnPairs:
    """Some pairs of bodies of a robot.

    Args:
        robot: the instrument.
        pairs: (P, 2) indices of its bodies.
    """

    def __init__(self, robot: Robot, pairs: NDArray[np.int64]) -> None:
        import coal

        self.robot, self.pairs = robot, np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
        kinds = np.array([body.kind == "capsules" for body in robot.bodies], dtype=bool)
        self.exact = ~np.logical_and(kinds[self.pairs[:, 0]], kinds[self.pairs[:, 1]])
        """(P,): True for pairs that Coal judges; the capsules only bound their distance."""
        self._queries: dict[int, Any] = {}
        self._request, self._result = coal.CollisionRequest(), coal.CollisionResult()

    def low(self, placed: Placed) -> Array:
        """Distances (K, P) of the capsules: lower bounds for exact pairs [m]. All bodies of the pairs are placed."""
        place = self.places(placed)
        ends, radii = placed.ends_W[:, place], self.robot.radii[self.pairs]
        rows = ends.reshape(-1, 2, 2, 3)
        apart = segment_distance(rows[:, 0], rows[:, 1]).reshape(len(ends), -1)
        return np.asarray(apart - radii.sum(axis=1))

    def places(self, placed: Placed) -> NDArray[np.int64]:
        """(P, 2): places of the bodies in `placed`."""
        return np.searchsorted(placed.bodies, self.pairs)

    def touches(self, placed: Placed, k: int, pair: int, margin: float) -> float | None:
        """None if an exact pair is farther apart than `margin` [m]; otherwise an upper bound of its distance."""
        import coal

        one, two = (int(body) for body in self.pairs[pair])
        query = self._queries.get(pair)
        if query is None:
            query = coal.ComputeCollision(self.robot.solids[one][0], self.robot.solids[two][0])
            self._queries[pair] = query
        self._request.security_margin = margin
        self._result.clear()
        poses = [self._pose(placed, k, int(place), body) for place, body in zip(
            np.searchsorted(placed.bodies, self.pairs[pair]), (one, two), strict=True)]  # fmt: skip
        if query(*poses, self._request, self._result) == 0:
            return None
        return float(self._result.getContact(0).penetration_depth)

    def _pose(self, placed: Placed, k: int, place: int, body: int) -> Any:
        X = placed.X_W[k, place] @ self.robot.solids[body][1]
        return geometry.transform(X[:3, :3], X[:3, 3])


def segment_distance(one: Array, two: Array) -> Array:
    """Distances (K,) [m] between the segments one and two (K, 2, 3) [m], in closed form.

    Source: Ericson, Real-Time Collision Detection, 2005, section 5.1.9.
    """
    p1, p2 = one[:, 0], two[:, 0]
    d1, d2, r = one[:, 1] - p1, two[:, 1] - p2, p1 - p2
    a, e, f = (d1 * d1).sum(-1), (d2 * d2).sum(-1), (d2 * r).sum(-1)
    c, b = (d1 * r).sum(-1), (d1 * d2).sum(-1)
    a, e = np.maximum(a, 1e-18), np.maximum(e, 1e-18)
    denominator = a * e - b * b
    s = np.clip(np.where(denominator > 1e-18, (b * f - c * e) / np.maximum(denominator, 1e-18), 0.0), 0.0, 1.0)
    t = (b * s + f) / e
    s = np.where(t < 0.0, np.clip(-c / a, 0.0, 1.0), np.where(t > 1.0, np.clip((b - c) / a, 0.0, 1.0), s))
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(np.linalg.norm(r + s[:, None] * d1 - t[:, None] * d2, axis=-1))
