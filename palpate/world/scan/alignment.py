"""Alignment of views: poses of the camera that lay all views onto one surface."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import exp, inverse, log, rigid, transform
from palpate.base.errors import CloudError
from palpate.world.scan.agreement import cost, total
from palpate.world.scan.view import View
from palpate.world.scan.views import small_gicp

_STEPS = 20  # of the joint alignment
_SAMPLES = 500  # points of a view that are compared with each other view in one step
_OVERLAP = 0.25  # smallest share of a view's points that must lie on another view
_COMPARED = 500  # points of a view that are compared after a coarse alignment
_BEST = 5  # of the coarse alignments that are refined
_TURNS = (np.radians(12.0), np.radians(24.0))  # of the starts of an alignment
_MOST_DRIFT = np.radians(4.0)  # of a sequence, from each view to the next
_FACING = 0.6  # smallest cosine of the angle between corresponding normals


def in_order(views: Sequence[View], reach: float) -> list[Array]:
    """Poses (4, 4) of views in the order of the camera's motion, in the frame of the first one; around a body or not.

    reach: see `in_sequence`.

    Raises:
        CloudError: a view does not overlap with any other.
    """
    chain = in_sequence(views, reach)
    again = closed(views, chain, reach) if len(views) > 2 else None
    found = [jointly(views, poses, 0.3 * reach) for poses in (chain, again) if poses is not None]
    return min(found, key=lambda poses: total(views, poses))


def in_sequence(views: Sequence[View], reach: float) -> list[Array]:
    """Poses (4, 4) in the frame of the first view, each found from the one before.

    Every alignment begins at several poses: where the camera was, where it would be if it went on as before, and turned
    about the middle of what it saw by up to 25 degrees. The pose that contradicts neither view is taken.

    reach: largest motion of the points between two views, from the best of these poses [m].
    """
    poses, step = [np.eye(4)], np.eye(4)
    for before, now in pairwise(views):
        step = _next(before, now, step, reach)
        poses.append(poses[-1] @ step)
    return poses


def closed(views: Sequence[View], poses: Sequence[Array], reach: float) -> list[Array] | None:
    """The poses of a sequence whose last view sees the first one again, with the drift spread over all of them.

    None where the last view does not show what the first one does, as little as neighbours contradict each other.
    """
    n = len(views) - 1
    neighbours = [cost(a, b, inverse(X) @ Y) for (a, b), (X, Y) in zip(pairwise(views), pairwise(poses), strict=True)]
    X = _next(views[0], views[-1], inverse(poses[0]) @ poses[-1], reach)
    drift = inverse(poses[-1]) @ poses[0] @ X
    if cost(views[0], views[-1], X) > max(neighbours) or np.linalg.norm(log(drift[:3, :3])) > _MOST_DRIFT * n:
        return None
    middle = views[-1].points.mean(axis=0)
    turn, shift = log(drift[:3, :3]), transform(drift, middle) - middle
    spread = []
    for k, pose in enumerate(poses):
        R = exp(k / n * turn)
        spread.append(pose @ rigid(R, middle + k / n * shift - R @ middle))
    return spread


def _next(before: View, now: View, step: Array, reach: float) -> Array:
    cell = max(before.cell, now.cell)
    starts = [np.eye(4), step, *_turned(before.points.mean(axis=0), now.points.mean(axis=0))]
    rough = [_icp(before, now.few, X, (reach, 4.0 * cell), 15) for X in starts]
    every = max(1, max(len(before.points), len(now.points)) // _COMPARED)
    rough.sort(key=lambda X: cost(before, now, X, every))
    fine = [_icp(before, now.prepared[0], X, (4.0 * cell, 1.5 * cell), 40) for X in rough[:_BEST]]
    return min(fine, key=lambda X: cost(before, now, X))


def _turned(to: Array, middle: Array) -> Iterator[Array]:
    """Poses that lay `middle` on `to` and turn about it."""
    yield rigid(np.eye(3), to - middle)
    for axis in product((-1.0, 0.0, 1.0), repeat=3):
        if any(axis):
            for angle in _TURNS:
                R = exp(angle * np.array(axis) / np.linalg.norm(axis))
                yield rigid(R, to - R @ middle)


def _icp(before: View, cloud: Any, X: Array, gates: Sequence[float], most: int) -> Array:
    """The pose of a cloud in the frame of a view from a start X, by small_gicp (point to plane)."""
    for gate in gates:
        found = small_gicp().align(
            before.prepared[0], cloud, before.prepared[1], X, registration_type="PLANE_ICP",
            max_correspondence_distance=gate, max_iterations=most,
        )  # fmt: skip
        T = np.asarray(found.T_target_source, dtype=np.float64)
        X = rigid(T[:3, :3], T[:3, 3])
    return X


def jointly(views: Sequence[View], poses: Sequence[Array], reach: float) -> list[Array]:
    """Poses (4, 4) of all views at once, so that no errors add up along the sequence; the first one stays.

    Gauss-Newton steps on the distances of points from the tangent planes of the nearest points in all other views (K.
    Pulli, "Multiview registration for large data sets", 3DIM 1999), weighted as by Geman and McClure.

    Args:
        views: the views.
        poses: rough poses, wrong by less than `reach` at the points.
        reach: largest distance between corresponding points in the first step [m].

    Raises:
        CloudError: a view does not overlap with any other.
    """
    X, rng = [np.array(pose) for pose in poses], np.random.default_rng(0)
    cell = max(one.cell for one in views)
    gates = np.maximum(reach * 0.7 ** np.arange(_STEPS), 1.5 * cell)
    for gate in gates:
        H, g = np.zeros((6 * len(X), 6 * len(X))), np.zeros(6 * len(X))
        for i, moving in enumerate(views):
            chosen = rng.permutation(len(moving.points))[:_SAMPLES]
            p = transform(X[i], moving.points[chosen])
            n = moving.normals[chosen] @ X[i][:3, :3].T
            for j, fixed in enumerate(views):
                if i != j:
                    _add_pair(H, g, i, j, p, n, fixed, X, float(gate))
        H[np.diag_indices_from(H)] += 1e-9 * np.trace(H) + 1e-12
        xi = np.linalg.solve(H[6:, 6:], g[6:]).reshape(-1, 6)
        X = [X[0], *(_moved(pose, step) for pose, step in zip(X[1:], xi, strict=True))]
    _require_overlap(views, X, 2.0 * cell)
    return X


def _add_pair(H: Array, g: Array, i: int, j: int, p: Array, n: Array, fixed: View, X: list[Array], gate: float) -> None:
    """Add the normal equations of the distances of points p with normals n of view i from view j."""
    d, nearest = fixed.tree.query(transform(inverse(X[j]), p), distance_upper_bound=gate)
    near = np.isfinite(d)
    nearest, p = nearest[near], p[near]
    m = fixed.normals[nearest] @ X[j][:3, :3].T
    facing = np.einsum("ni,ni->n", n[near], m) > _FACING
    nearest, p, m = nearest[facing], p[facing], m[facing]
    if len(p) < 6:
        return
    q = transform(X[j], fixed.points[nearest])
    r = np.einsum("ni,ni->n", q - p, m)
    s = max(2.0 * float(np.median(np.abs(r))), 1e-6)
    w = 1.0 / (1.0 + np.square(r / s)) ** 2
    J = np.concatenate([m, np.cross(p, m)], axis=1)  # by the displacement of view i; that of view j is opposite
    A, b = np.einsum("ni,n,nj->ij", J, w, J), J.T @ (w * r)
    a, c = slice(6 * i, 6 * i + 6), slice(6 * j, 6 * j + 6)
    H[a, a] += A
    H[c, c] += A
    H[a, c] -= A
    H[c, a] -= A
    g[a] += b
    g[c] -= b


def _moved(X: Array, xi: npt.NDArray[np.floating]) -> Array:
    """The pose X moved by the translation xi[:3] and the rotation vector xi[3:] about the world's origin."""
    return np.asarray(rigid(exp(xi[3:]), xi[:3]) @ X)


def _require_overlap(views: Sequence[View], X: Sequence[Array], near: float) -> None:
    for i, one in enumerate(views):
        p, found = transform(X[i], one.points), np.zeros(len(one.points), dtype=bool)
        for j, other in enumerate(views):
            if i != j:
                found |= np.isfinite(other.tree.query(transform(inverse(X[j]), p), distance_upper_bound=near)[0])
        if found.mean() < _OVERLAP:
            raise CloudError(
                f"only {100 * found.mean():.0f} % of the view lies on the other views",
                where=one.name,
                why="the views do not overlap, or the camera moved farther between them than the alignment can find",
                mend="give views in the order of the camera's motion, with more overlap, or their rough --poses",
            )
