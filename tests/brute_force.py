"""Brute-force reference for nearest-point queries: the minimum over all triangles."""

import numpy as np


def distance_by_segments_and_planes(vertices, triangles, points):
    """Distances (n,) [m] of points (n, 3) to the nearest triangle, from its sides and its plane, without BVH."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    n = np.cross(b - a, c - a)
    area2 = (n * n).sum(axis=1)

    def to_segment(p, start, end):
        d = end - start
        t = np.clip(((p - start) * d).sum(axis=1) / np.maximum((d * d).sum(axis=1), 1e-300), 0.0, 1.0)
        return np.linalg.norm(p - start - t[:, None] * d, axis=1)

    out = []
    for p in points:
        d = np.minimum(np.minimum(to_segment(p, a, b), to_segment(p, b, c)), to_segment(p, c, a))
        above = np.full(len(a), True)
        for start, end in ((a, b), (b, c), (c, a)):
            above &= (np.cross(end - start, p - start) * n).sum(axis=1) > 0.0
        above &= area2 > 0.0
        plane = np.abs(((p - a) * n).sum(axis=1)) / np.sqrt(np.where(area2 > 0.0, area2, 1.0))
        out.append(np.where(above, np.minimum(d, plane), d).min())
    return np.array(out)
