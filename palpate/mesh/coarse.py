"""Coarser copies of surfaces for drawing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from palpate import cache
from palpate.arrays import Array

Triangles = NDArray[np.int32]

MOST_TRIANGLES = 150_000
"""A finer surface is drawn coarser, so that the browser stays fluent; contact uses the full surface."""
_MOST_CELLS = 2**20  # along an axis


def drawable(
    vertices: Array, triangles: Triangles, most: int = MOST_TRIANGLES, key: str = ""
) -> tuple[Array, Triangles]:
    """A mesh of about `most` triangles or fewer: all vertices in a grid cell are merged into their mean.

    key: of the mesh in the user's cache, where the result is kept; empty: it is computed each time.
    """

    def made() -> cache.Arrays:
        coarse, faces, _ = coarser(vertices, triangles, most)
        return {"vertices": coarse, "triangles": faces}

    if len(triangles) <= most:
        return vertices, triangles
    found = cache.load_or_make("mesh_coarse", cache.source_key([__file__], most, key), made) if key else made()
    return found["vertices"], found["triangles"]


def coarser(vertices: Array, triangles: Triangles, most: int) -> tuple[Array, Triangles, NDArray[np.int64]]:
    """As `drawable`, for vertices (n, 3 + k) with further columns such as colours, which are averaged as well; and the
    number (m,) of a triangle of the given surface for each one."""
    if len(triangles) <= most:
        return vertices, triangles, np.arange(len(triangles))
    a, b, c = (vertices[triangles[:, k], :3] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    low = vertices[:, :3].min(axis=0)
    extent = float((vertices[:, :3].max(axis=0) - low).max())
    # About two triangles in each cell that the surface crosses; numbers of cells have 63 bits.
    cell = max(float(np.sqrt(2.0 * area / most)), extent / _MOST_CELLS)
    place = np.floor((vertices[:, :3] - low) / cell).astype(np.int64)
    _, group = np.unique(np.ravel_multi_index(place.T, place.max(axis=0) + 1), return_inverse=True)
    count = np.bincount(group)
    sums = np.stack([np.bincount(group, vertices[:, k]) for k in range(vertices.shape[1])], axis=1)
    merged = np.asarray(sums / count[:, None])
    coarse = group[triangles]
    kept = (coarse[:, 0] != coarse[:, 1]) & (coarse[:, 1] != coarse[:, 2]) & (coarse[:, 2] != coarse[:, 0])
    faces, first = np.unique(coarse[kept], axis=0, return_index=True)
    return merged, faces.astype(np.int32), np.asarray(np.flatnonzero(kept)[first], dtype=np.int64)
