"""Polylines: distance of points, and even spacing."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array


def distance(p: Array, path: Array) -> tuple[Array, Array]:
    """Distances (n,) from points (n, 3) to a polyline (m, 3), and the nearest points (n, 3) on the polyline."""
    begins, steps = path[:-1], np.diff(path, axis=0)
    columns = np.ascontiguousarray(p.T)  # rows of coordinates: three times as fast as points of three numbers
    best, where = np.full(len(p), np.inf), np.zeros_like(columns)
    for begin, step in zip(begins[:, :, None], steps, strict=True):
        from_begin = columns - begin
        share = np.clip(step @ from_begin / max(step @ step, 1e-30), 0.0, 1.0)
        q = begin + step[:, None] * share
        square = ((columns - q) ** 2).sum(axis=0)
        closer = square < best
        np.copyto(best, square, where=closer)
        np.copyto(where, q, where=closer)
    return np.sqrt(best), where.T


def evenly(curve: Array, step: float = 0.0005) -> Array:
    """The curve (n, 3), resampled with the spacing ``step`` [m]."""
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])
    at = np.linspace(0.0, s[-1], int(s[-1] / step) + 1)
    return np.column_stack([np.interp(at, s, curve[:, j]) for j in range(3)])
