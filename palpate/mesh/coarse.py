"""Coarser copies of surfaces for drawing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from palpate.arrays import Array

Triangles = NDArray[np.int32]

MOST_TRIANGLES = 150_000
"""A finer surface is drawn coarser, so that the browser stays fluent; contact uses the full surface."""


def drawable(vertices: Array, triangles: Triangles, most: int = MOST_TRIANGLES) -> tuple[Array, Triangles]:
    """A mesh of about `most` triangles or fewer: all vertices in a grid cell are merged into their mean."""
    if len(triangles) <= most:
        return vertices, triangles
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    cell = np.sqrt(2.0 * area / most)  # about two triangles in each cell that the surface crosses
    _, group = np.unique(np.floor(vertices / cell).astype(np.int64), axis=0, return_inverse=True)
    group = group.reshape(-1)
    count = np.bincount(group)
    merged = np.stack([np.bincount(group, vertices[:, k]) for k in range(3)], axis=1) / count[:, None]
    coarse = group[triangles]
    kept = (coarse[:, 0] != coarse[:, 1]) & (coarse[:, 1] != coarse[:, 2]) & (coarse[:, 2] != coarse[:, 0])
    return merged, np.unique(coarse[kept], axis=0).astype(np.int32)
