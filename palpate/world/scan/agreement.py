"""Do two views agree? Each camera has looked through the space in front of what it saw: nothing can lie there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import inverse, transform
from palpate.world.scan.view import View

FEWEST = 100
"""Points of one view that must lie in the image of another before the two are compared."""
_NEIGHBOURS = 8  # points of the other view around the same ray
_OUTLINE = (
    1.5  # of that distance: points so near to something that the other view saw may be its outline, moved by noise
)
_BEYOND = 4.0  # distances larger than this many standard deviations are no noise
_UNSEEN = 0.5  # cost of a point about which the other view says nothing, between agreement (0) and contradiction (1)


@dataclass(frozen=True)
class Comparison:
    """Points of one view against the surface that another view saw along the same rays."""

    compared: int  #: points in the image of the other view
    in_front: float  #: share of these that lie in front of its surface, by more than noise and sampling explain
    cost: float  #: mean cost of all points, 0 where they lie on the surface, 1 in front of it


def compare(seen: View, view: View, X: Array, every: int = 1) -> Comparison:
    """Compare points of `view` with the surface of `seen`, where X (4, 4) is the pose of `view` in the frame of `seen`.

    every: of so many points, one is compared.
    """
    p = transform(X, view.points[::every])
    rays = p - seen.sensor
    r = np.linalg.norm(rays, axis=1)
    angle, near = seen.rays.query(rays / r[:, None], k=_NEIGHBOURS, distance_upper_bound=3.0 * seen.cell / seen.range)
    within = np.isfinite(angle).all(axis=1)
    if not within.any():
        return Comparison(0, 0.0, _UNSEEN)
    p, r, near = p[within], r[within], near[within]
    away = np.einsum("nki,nki->nk", p[:, None, :] - seen.points[near], seen.normals[near])
    least = np.take_along_axis(away, np.abs(away).argmin(axis=1)[:, None], axis=1)[:, 0]
    depth = np.linalg.norm(seen.points[near] - seen.sensor, axis=2)
    # a view's points are means over a cell, whose noise is below that of single points
    limit = _BEYOND * max(seen.noise, view.noise) + 0.25 * seen.cell
    off = np.abs(least) > limit
    front = off & (r < depth.min(axis=1) - limit)
    front[front] = seen.tree.query(p[front])[0] > _OUTLINE * limit
    costs = np.where(front, 1.0, np.where(off, _UNSEEN, np.square(least / limit)))
    summed = costs.sum() + _UNSEEN * np.count_nonzero(~within)
    return Comparison(int(within.sum()), float(front.mean()), float(summed / len(within)))


def cost(a: View, b: View, X_AB: Array, every: int = 1) -> float:
    """Cost of a pose of view b in the frame of view a, by both comparisons."""
    return 0.5 * (compare(a, b, X_AB, every).cost + compare(b, a, inverse(X_AB), every).cost)


def total(views: Sequence[View], poses: Sequence[Array]) -> float:
    """Mean cost of the poses of all views, over all pairs."""
    pairs = combinations(range(len(views)), 2)
    return float(np.mean([cost(views[i], views[j], inverse(poses[i]) @ poses[j], 4) for i, j in pairs]))


def worst(views: Sequence[View], poses: Sequence[Array]) -> tuple[float, str, str]:
    """Largest share of a view's points in front of what another one saw, and the names of the two; 0 for one view."""
    found = (0.0, "", "")
    for i, seen in enumerate(views):
        for j, view in enumerate(views):
            if i != j:
                one = compare(seen, view, inverse(poses[i]) @ poses[j])
                if one.compared >= FEWEST and one.in_front > found[0]:
                    found = (one.in_front, view.name, seen.name)
    return found
