"""Coarser copies of surfaces for drawing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array

if TYPE_CHECKING:
    from palpate.base.cache import Arrays

Triangles = NDArray[np.int32]

MOST_TRIANGLES = 150_000
"""A finer surface is drawn coarser, so that the browser stays fluent; contact uses the full surface."""
_MOST_CELLS = 2**20  # along an axis
_AT_ONCE = 100_000  # triangles: a large mesh takes little memory more


def drawable(
    vertices: Array, triangles: Triangles, most: int = MOST_TRIANGLES, key: str = ""
) -> tuple[Array, Triangles]:
    """A mesh of about `most` triangles or fewer: all vertices in a grid cell are merged into their mean.

    key: of the mesh in the user's cache, where the result is kept; empty: it is computed each time.
    """

    def made() -> Arrays:
        coarse, faces, _ = coarser(vertices, triangles, most)
        return {"vertices": coarse, "triangles": faces}

    if len(triangles) <= most:
        return vertices, triangles
    if not key:
        found = made()
    else:
        from palpate.base import cache

        found = cache.load_or_make("mesh_coarse", cache.source_key([__file__], most, key), made)
    return found["vertices"], found["triangles"]


def coarser(vertices: Array, triangles: Triangles, most: int) -> tuple[Array, Triangles, NDArray[np.int64]]:
    """As `drawable`, for vertices (n, 3 + k) with further columns such as colours, which are averaged as well; and the
    number (m,) of a triangle of the given surface for each one."""
    if len(triangles) <= most:
        return vertices, triangles, np.arange(len(triangles))
    area = sum(_area(vertices, triangles[k : k + _AT_ONCE]) for k in range(0, len(triangles), _AT_ONCE))
    low = vertices[:, :3].min(axis=0)
    extent = float((vertices[:, :3].max(axis=0) - low).max())
    # About two triangles in each cell that the surface crosses; numbers of cells have 63 bits.
    cell = max(float(np.sqrt(2.0 * area / most)), extent / _MOST_CELLS)
    place = [np.floor((vertices[:, k] - low[k]) / cell).astype(np.int64) for k in range(3)]
    numbers = np.ravel_multi_index(place, [int(one.max()) + 1 for one in place])
    del place
    _, group = np.unique(numbers, return_inverse=True)
    group = group.astype(np.int32)
    count = np.bincount(group)
    sums = np.stack([np.bincount(group, vertices[:, k]) for k in range(vertices.shape[1])], axis=1)
    merged = np.asarray(sums / count[:, None])
    coarse = group[triangles]
    kept = (coarse[:, 0] != coarse[:, 1]) & (coarse[:, 1] != coarse[:, 2]) & (coarse[:, 2] != coarse[:, 0])
    faces, first = np.unique(coarse[kept], axis=0, return_index=True)
    return merged, faces.astype(np.int32, copy=False), np.asarray(np.flatnonzero(kept)[first], dtype=np.int64)


def _area(vertices: Array, triangles: Triangles) -> float:
    """Area of triangles (m, 3) [m^2]."""
    a, b, c = (vertices[triangles[:, k], :3] for k in range(3))
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())
