"""Distances of capsules from triangles by brute force, without any hierarchy and without Coal."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.planning.own import segment_distance


def to_triangles(a: Array, b: Array, corners: Array) -> Array:
    """Distances (K, T) [m] of the segments from a to b (K, 3) from triangles (T, 3, 3); 0 where one pierces the other.

    The nearest points lie on an edge, at an end of the segment above the face, or where the segment pierces it.
    """
    K, T = len(a), len(corners)
    best = np.full((K, T), np.inf)
    segments = np.stack([np.repeat(a, T, 0), np.repeat(b, T, 0)], axis=1)
    for i in range(3):
        edges = np.tile(np.stack([corners[:, i], corners[:, (i + 1) % 3]], axis=1), (K, 1, 1))
        best = np.minimum(best, segment_distance(segments, edges).reshape(K, T))
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    n = np.cross(u, v)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    to_local = np.linalg.inv(np.stack([u, v, n], axis=-1))  # barycentric coordinates, and the height over the face
    ends = [np.einsum("tij,ktj->kti", to_local, p[:, None] - corners[:, 0]) for p in (a, b)]
    for x in ends:
        best = np.where(_inside(x), np.minimum(best, np.abs(x[..., 2])), best)
    h0, h1 = ends[0][..., 2], ends[1][..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        x = ends[0] + (h0 / (h0 - h1))[..., None] * (ends[1] - ends[0])
    return np.where((h0 * h1 < 0.0) & _inside(x), 0.0, best)


def _inside(x: Array) -> Array:
    """True where barycentric coordinates x (..., 3) lie in the triangle."""
    return np.asarray((x[..., 0] >= 0.0) & (x[..., 1] >= 0.0) & (x[..., 0] + x[..., 1] <= 1.0))
