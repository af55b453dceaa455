"""Robust point-to-plane iterations from many starts at once, and the starts themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displaced, exp, rigid, transform
from palpate.base.arrays.so3 import about, onto
from palpate.world.registration.clouds import Cloud
from palpate.world.registration.fit import Indices

_FEWEST = 20  # explained points from which a step is computed
_ANCHORS, _SPINS = 60, 12  # starts without a rough pose: places on the surface, and turns about their normals


def iterate(X: Array, moving: Array, fixed: Cloud, floor: float, steps: int) -> tuple[Array, Array]:
    """Poses (B, 4, 4) after robust point-to-plane steps (Chen and Medioni, 1992), and their costs (B,) [m^2].

    Distances are weighted by ``1 / (1 + d^2 / s^2)^2`` (Geman and McClure) with s from their median. The cost is the
    mean of the squared distances, truncated at (3 floor)^2.

    Args:
        X: starts (B, 4, 4).
        moving: points (P, 3) [m].
        fixed: the surface.
        floor: smallest s, the noise of both clouds [m].
        steps: number of steps.
    """
    normals = fixed.normals
    for _ in range(steps):
        q = moving @ np.swapaxes(X[:, :3, :3], 1, 2) + X[:, None, :3, 3]
        d, nearest = fixed.tree.query(q)
        n = normals[nearest]
        s = np.maximum(np.median(d, axis=1, keepdims=True), floor)
        w = 1.0 / (1.0 + np.square(d / s)) ** 2
        centre = q.mean(axis=1, keepdims=True)
        J = np.concatenate([n, np.cross(q - centre, n)], axis=2)
        r = ((fixed.points[nearest] - q) * n).sum(axis=2)
        H = np.einsum("bpi,bp,bpj->bij", J, w, J)
        H += 1e-9 * np.trace(H, axis1=1, axis2=2)[:, None, None] * np.eye(6)
        xi = np.linalg.solve(H, np.einsum("bpi,bp,bp->bi", J, w, r)[..., None])[..., 0]
        R = exp(xi[:, 3:])
        c = centre[:, 0]
        moved = c + xi[:, :3] + (R @ (X[:, :3, 3] - c)[..., None])[..., 0]
        X = rigid(R @ X[:, :3, :3], moved)
    return X, costs(X, moving, fixed, floor)


@dataclass(frozen=True)
class Residuals:
    """Distances of moved points from a surface."""

    r: Array  #: (N,) along the normal [m]
    J: Array  #: (N, 6) derivatives by the displacement of the pose
    distance: Array  #: (N,) to the nearest point of the surface [m]
    nearest: Indices  #: (N,) that point
    explained: NDArray[np.bool_]  #: (N,) within three standard deviations of the surface


def residuals(X: Array, moving: Array, fixed: Cloud, sigma: float) -> Residuals:
    """Distances of the points (N, 3) moved by X (4, 4) from the surface, of the standard deviation `sigma` [m]."""
    moved = transform(X, moving)
    d, nearest = fixed.tree.query(moved)
    n = fixed.normals[nearest]
    r = ((fixed.points[nearest] - moved) * n).sum(axis=1)
    lateral = np.sqrt(np.maximum(d**2 - r**2, 0.0))
    good = (np.abs(r) < 3.0 * sigma) & (lateral < 4.0 * fixed.spacing + 3.0 * sigma)
    return Residuals(r, np.hstack([n, np.cross(moved - X[:3, 3], n)]), d, nearest, good)


def least_squares(X: Array, moving: Array, fixed: Cloud, sigma: float, steps: int) -> Array:
    """The pose (4, 4) after point-to-plane steps with equal weights for all explained points.

    The weights of `iterate` find the minimum, but more than double the variance of the answer.
    """
    for _ in range(steps):
        found = residuals(X, moving, fixed, sigma)
        J, r = found.J[found.explained], found.r[found.explained]
        if len(J) < _FEWEST:
            break
        X = displaced(X, np.linalg.lstsq(J, r, rcond=1e-9)[0])
    return X


def costs(X: Array, moving: Array, fixed: Cloud, floor: float) -> Array:
    """Mean squared distances (B,) of the moved points from the surface, truncated at (3 floor)^2 [m^2]."""
    gate = 3.0 * floor
    d, _ = fixed.tree.query(moving @ np.swapaxes(X[:, :3, :3], 1, 2) + X[:, None, :3, 3], distance_upper_bound=gate)
    return np.asarray(np.square(np.minimum(d, gate)).mean(axis=1))


def distinct(X: Array, cost: Array, moving: Array, apart: float) -> list[int]:
    """Indices of poses whose points differ by more than `apart` rms [m], the cheapest first."""
    places = np.einsum("bij,pj->bpi", X[:, :3, :3], moving[:100]) + X[:, None, :3, 3]
    kept: list[int] = []
    for k in np.argsort(cost):
        if all(np.sqrt(np.square(places[k] - places[j]).sum(axis=1).mean()) > apart for j in kept):
            kept.append(int(k))
    return kept


def starts_near(X: Array, moving: Array, angle: float, reach: float, n: int) -> Array:
    """The pose X and n - 1 poses (n, 4, 4) spread over `angle` [rad] and `reach` [m] about the points' centroid."""
    rng = np.random.default_rng(0)
    c = X[:3, :3] @ moving.mean(axis=0) + X[:3, 3]

    def ball(radius: float) -> Array:
        v = rng.normal(size=(n, 3))
        return np.asarray(radius * rng.random((n, 1)) ** (1 / 3) * v / np.linalg.norm(v, axis=1, keepdims=True))

    theta, dp = ball(angle), ball(reach)
    theta[0], dp[0] = 0.0, 0.0
    R = exp(theta)
    return rigid(R @ X[:3, :3], c + dp + (R @ (X[:3, 3] - c)))


def starts_anywhere(moving: Cloud, fixed: Cloud) -> Array:
    """Poses that lay the middle of the moving cloud onto places spread over the surface, normal onto normal."""
    middle = moving.points.mean(axis=0)
    nearest = int(moving.tree.query(middle)[1])
    near = moving.tree.query(moving.points[nearest], k=min(60, len(moving.points)))[1]
    patch = moving.points[near]
    normal = np.linalg.svd(patch - patch.mean(axis=0))[2][2]
    found = []
    for k in _spread(fixed.points, _ANCHORS):
        for sign in (1.0, -1.0):
            turned = onto(fixed.normals[k]) @ onto(sign * normal).T
            for angle in np.arange(_SPINS) * 2.0 * np.pi / _SPINS:
                R = about(fixed.normals[k], float(angle)) @ turned
                found.append(rigid(R, fixed.points[k] - R @ patch.mean(axis=0)))
    return np.stack(found)


def _spread(points: Array, n: int) -> list[int]:
    """Indices of n points, each the farthest from those before."""
    chosen, gap = [0], np.full(len(points), np.inf)
    for _ in range(n - 1):
        gap = np.minimum(gap, np.linalg.norm(points - points[chosen[-1]], axis=1))
        chosen.append(int(gap.argmax()))
    return chosen
