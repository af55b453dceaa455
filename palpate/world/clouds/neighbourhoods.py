"""What the neighbourhoods of points tell: spacing, noise, layers, and normals of a cloud without a viewpoint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from palpate.base.arrays import Array

_SIZES = (16, 48, 128, 320, 800)  # neighbours at most; larger sets are needed where the noise exceeds the spacing
_FLAT = 0.4  # ratio of the standard deviations across and along a plane below which a neighbourhood shows the plane
_STEP = 0.01  # noise over spacing below which the nearest points may lie within one step of the camera's depth
_SAMPLES = 400  # points whose neighbourhoods are measured


@dataclass(frozen=True)
class Sampling:
    """How densely and how precisely a cloud samples its surface."""

    spacing: float  #: distance between neighbours on the surface, the median over the cloud [m]
    noise: float  #: standard deviation of the points across the surface, the median over the cloud [m]
    neighbours: int = _SIZES[0]  #: number of neighbours among which the surface is a plane


def sampling(points: Array) -> Sampling:
    """Spacing and noise of a cloud of points (N, 3) [m], from the planes through the neighbours of some points.

    A neighbourhood grows until it is flat, because the nearest points of a noisy cloud are a ball and not a disc; where
    none is, the largest counts. It grows on while it shows no noise at all: a camera that measures depth in steps puts
    the nearest points into one plane.
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    rng = np.random.default_rng(0)
    chosen = points[rng.permutation(len(points))[:_SAMPLES]]
    found = Sampling(0.0, 0.0, min(_SIZES[0], len(points)))
    for size in _SIZES:
        k = min(size, len(points))
        _, index = tree.query(chosen, k=k, workers=-1)
        values = _variances(_disc(points[index]))
        held, freedom = max(k // 2, 3), max(k // 2 - 3, 1)
        across, along = np.sqrt(values[:, 0]), np.sqrt(values[:, 1])
        flatness = float(np.median(across / np.maximum(along, 1e-300)))
        # a disc of radius r has the variance r^2 / 4 along each axis
        spacing = np.median(np.sqrt(4.0 * np.pi * along * np.sqrt(values[:, 2]) / held))
        middle = (1.0 - 2.0 / (9.0 * freedom)) ** 1.5  # root of the median of chi-square over its mean
        found = Sampling(float(spacing), float(np.median(across) / middle), k)
        if k == len(points) or (flatness < _FLAT and found.noise > _STEP * found.spacing):
            break
    return found


def _disc(near: Array) -> Array:
    """The half (N, k // 2, 3) of the neighbours (N, k, 3) that is nearest along the surface.

    The nearest neighbours fill a ball, which cuts the noise off near its rim, but not within 0.7 of its radius.
    """
    centred = near - near.mean(axis=1, keepdims=True)
    normals = np.linalg.eigh(np.einsum("nki,nkj->nij", centred, centred))[1][:, :, 0]
    from_first = near - near[:, :1]
    across = np.einsum("nki,ni->nk", from_first, normals)
    aside = np.square(from_first).sum(axis=2) - across**2
    chosen = np.argsort(aside, axis=1)[:, : max(near.shape[1] // 2, 3)]
    return np.asarray(np.take_along_axis(near, chosen[:, :, None], axis=1))


def _variances(near: Array) -> Array:
    """Ascending variances (N, 3) of neighbourhoods (N, k, 3) along their principal axes."""
    centred = near - near.mean(axis=1, keepdims=True)
    cov = np.einsum("nki,nkj->nij", centred, centred) / max(near.shape[1] - 3, 1)
    return np.maximum(np.linalg.eigvalsh(cov), 0.0)


_CLEAR = 4.5  # distance between two layers over their scatter; the halves of one layer reach 2.7, of a uniform one 3.5
_SHARE = 0.2  # smaller parts of a neighbourhood are outliers
_APART = 0.5  # [radius of gyration] farther apart along the surface, two parts are the sides of a step
_LAYERED = 0.05  # share of the neighbourhoods with two layers above which a cloud has them


def layer_gap(points: Array, reach: float, normals: Array | None = None) -> float:
    """Distance between two layers of points that lie above each other within `reach` [m]; 0 for a single layer.

    In the neighbourhoods of some points the heights above the fitted paraboloid are split in two where that leaves the
    least scatter. Two layers are farther apart than they scatter, and share the same part of the surface.

    Args:
        points: (N, 3) [m].
        reach: radius of a neighbourhood, that within which points shape a surface [m].
        normals: (N, 3); points whose normals oppose each other belong to different surfaces anyway.
    """
    from scipy.spatial import cKDTree

    chosen = np.random.default_rng(0).permutation(len(points))[: _SAMPLES // 2]
    gaps = []
    for i, near in zip(chosen, cKDTree(points).query_ball_point(points[chosen], reach), strict=True):
        index = np.asarray(near)
        if normals is not None:
            index = index[normals[index] @ normals[i] >= 0.0]
        if len(index) > 20:
            gaps.append(_gap(points[index[:: max(1, len(index) // 400)]] - points[i]))
    found = [gap for gap in gaps if gap > 0.0]
    return float(np.median(found)) if len(found) >= max(_LAYERED * len(gaps), 5) else 0.0


def _gap(near: Array) -> float:
    """Distance between two layers among points (k, 3) of a neighbourhood [m]; 0 for one layer."""
    centred = near - near.mean(axis=0)
    u, v, height = (centred @ np.linalg.eigh(centred.T @ centred)[1][:, ::-1]).T
    size = np.sqrt(np.mean(u * u + v * v))
    basis = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=1) / [1.0, size, size, *3 * [size * size]]
    height = height - basis @ np.linalg.lstsq(basis, height, rcond=None)[0]
    order = np.argsort(height)
    h, k = height[order], len(height)
    n = np.arange(1, k)
    below, above = np.cumsum(h)[:-1] / n, (h.sum() - np.cumsum(h)[:-1]) / (k - n)
    allowed = np.minimum(n, k - n) >= _SHARE * k
    split = int(np.argmax(np.where(allowed, n * (k - n) * (above - below) ** 2, -1.0))) + 1
    low, high = order[:split], order[split:]
    scatter = np.sqrt(0.5 * (height[low].var() + height[high].var()))
    gap = float(height[high].mean() - height[low].mean())
    aside = np.hypot(u[low].mean() - u[high].mean(), v[low].mean() - v[high].mean())
    return gap if gap > _CLEAR * scatter and aside < _APART * size else 0.0


def outward_normals(points: Array, reach: float) -> Array:
    """Unit normals (N, 3) of points (N, 3) [m], oriented alike over the surface and away from its inside.

    The signs spread along the minimum spanning tree of the neighbourhood graph (Hoppe et al., SIGGRAPH 1992). The
    largest component then decides: more of its points look away from the mean than towards it.

    Args:
        points: one sheet or a closed surface.
        reach: radius of a neighbourhood [m].
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
    from scipy.spatial import cKDTree

    k = min(max(8, min(48, _within(points, reach))), len(points))
    _, index = cKDTree(points).query(points, k=k, workers=-1)
    near = points[index]
    centred = near - near.mean(axis=1, keepdims=True)
    normals = np.linalg.eigh(np.einsum("nki,nkj->nij", centred, centred))[1][:, :, 0]
    rows = np.repeat(np.arange(len(points)), min(k, 12) - 1)
    columns = index[:, 1 : min(k, 12)].ravel()
    cost = 1.0 - np.abs(np.einsum("ni,ni->n", normals[rows], normals[columns])) + 1e-6
    tree = minimum_spanning_tree(coo_matrix((cost, (rows, columns)), shape=(len(points),) * 2))
    count, label = connected_components(tree, directed=False)
    for part in range(count):
        members = np.flatnonzero(label == part)
        away = points[members] - points[members].mean(axis=0)
        root = members[np.argmax(np.linalg.norm(away, axis=1))]
        order, before = breadth_first_order(tree, root, directed=False)
        _spread_signs(normals, order, before)
        if np.einsum("ni,ni->", normals[members], away) < 0.0:
            normals[members] *= -1.0
    return np.asarray(normals)


def _within(points: Array, reach: float) -> int:
    """Typical number of neighbours within a radius."""
    spacing = max(sampling(points).spacing, 1e-9)
    return int(np.pi * (reach / spacing) ** 2)


def _spread_signs(normals: Array, order: Any, before: Any) -> None:
    """Give each normal the sign of its predecessor in a tree, in the order of the tree."""
    signs = np.ones(len(normals))
    own = np.einsum("ni,ni->n", normals[order[1:]], normals[before[order[1:]]])
    for i, cosine in zip(order[1:], own, strict=True):
        signs[i] = signs[before[i]] * (1.0 if cosine >= 0.0 else -1.0)
    normals[order] *= signs[order][:, None]
