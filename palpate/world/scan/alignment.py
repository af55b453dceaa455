"""Alignment of views: poses of the camera that lay all views onto one surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import exp, inverse, rigid, transform
from palpate.base.errors import CloudError
from palpate.world.scan.views import small_gicp

_STEPS = 20  # of the joint alignment
_SAMPLES = 500  # points of a view that are compared with each other view in one step
_OVERLAP = 0.25  # smallest share of a view's points that must lie on another view
_FACING = 0.6  # smallest cosine of the angle between corresponding normals


@dataclass(frozen=True)
class View:
    """Averaged points of one view, in its own frame."""

    points: Array  #: (N, 3) [m]
    normals: Array  #: (N, 3) unit normals towards the sensor
    tree: Any  #: search tree of the points (scipy's cKDTree)
    prepared: Any  #: the same for small_gicp: cloud and tree
    name: str


def view(points: Array, sensor: Array, cell: float, name: str) -> View:
    """A view averaged over cells [m], with normals towards the sensor at (3,) [m]."""
    from scipy.spatial import cKDTree

    cloud, tree = small_gicp().preprocess_points(points, downsampling_resolution=cell, num_neighbors=20)
    p, n = np.asarray(cloud.points())[:, :3].copy(), np.asarray(cloud.normals())[:, :3].copy()
    n *= np.where(np.einsum("ni,ni->n", n, sensor - p) < 0.0, -1.0, 1.0)[:, None]
    return View(p, n, cKDTree(p), (cloud, tree), name)


def in_sequence(views: Sequence[View], cell: float, reach: float) -> list[Array]:
    """Poses (4, 4) in the frame of the first view, each found from the one before by small_gicp (point to plane).

    cell: size of the cells of the views [m]; reach: largest motion of the points between two views [m].
    """
    poses = [np.eye(4)]
    for before, now in pairwise(views):
        X = np.eye(4)
        for gate in (reach, 0.3 * reach, 3.0 * cell):
            found = small_gicp().align(
                before.prepared[0], now.prepared[0], before.prepared[1], X, registration_type="PLANE_ICP",
                max_correspondence_distance=gate, max_iterations=40,
            )  # fmt: skip
            T = np.asarray(found.T_target_source, dtype=np.float64)
            X = rigid(T[:3, :3], T[:3, 3])
        poses.append(poses[-1] @ X)
    return poses


def jointly(views: Sequence[View], poses: Sequence[Array], cell: float, reach: float) -> list[Array]:
    """Poses (4, 4) of all views at once, so that no errors add up along the sequence; the first one stays.

    Gauss-Newton steps on the distances of points from the tangent planes of the nearest points in all other views (K.
    Pulli, "Multiview registration for large data sets", 3DIM 1999), weighted as by Geman and McClure.

    Args:
        views: the views.
        poses: rough poses, wrong by less than `reach` at the points.
        cell: size of the cells of the views [m].
        reach: largest distance between corresponding points in the first step [m].

    Raises:
        CloudError: a view does not overlap with any other.
    """
    X, rng = [np.array(pose) for pose in poses], np.random.default_rng(0)
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
