"""Brute-force reference for nearest-point queries: the minimum over all triangles."""

import numpy as np


def distance_by_segments_and_planes(vertices, triangles, points):
    """Distances (n,) [m] of points (n, 3) to the nearest triangle, from its sides and its plane, without BVH."""
    a, b, c = (np.ascontiguousarray(vertices[triangles[:, k]].T) for k in range(3))  # (3, m): a component is contiguous
    n = _cross(b - a, c - a)
    area2 = _dot(n, n)
    height = np.sqrt(np.where(area2 > 0.0, area2, 1.0))
    sides = [(start, end - start) for start, end in ((a, b), (b, c), (c, a))]
    squares = [np.maximum(_dot(along, along), 1e-300) for _, along in sides]
    out = []
    for p in np.asarray(points)[:, :, None]:
        d, above = np.full(a.shape[1], np.inf), area2 > 0.0
        for (start, along), square in zip(sides, squares, strict=True):
            r = p - start
            rest = r - np.clip(_dot(r, along) / square, 0.0, 1.0) * along
            d = np.minimum(d, np.sqrt(_dot(rest, rest)))
            above &= _dot(_cross(along, r), n) > 0.0
        out.append(np.where(above, np.minimum(d, np.abs(_dot(p - a, n)) / height), d).min())
    return np.array(out)


def _dot(x, y):
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


def _cross(x, y):
    return np.stack([x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]])
