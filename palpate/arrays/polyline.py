"""Polylines: distance of points, and even spacing."""

from __future__ import annotations

import numpy as np

from palpate.arrays import Array


def distance(p: Array, path: Array) -> tuple[Array, Array]:
    """Distances (n,) from points (n, 3) to a polyline (m, 3), and the nearest points (n, 3) on the polyline."""
    a, d = path[:-1], np.diff(path, axis=0)
    best, where = np.full(len(p), np.inf), np.zeros_like(p)
    for begin, step in zip(a, d, strict=True):
        share = np.clip((p - begin) @ step / max(step @ step, 1e-30), 0.0, 1.0)
        q = begin + share[:, None] * step
        away = np.linalg.norm(p - q, axis=1)
        closer = away < best
        best[closer], where[closer] = away[closer], q[closer]
    return best, where


def evenly(curve: Array, step: float = 0.0005) -> Array:
    """The curve (n, 3), resampled with the spacing ``step`` [m]."""
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    at = np.linspace(0.0, s[-1], int(s[-1] / step) + 1)
    return np.column_stack([np.interp(at, s, curve[:, j]) for j in range(3)])
