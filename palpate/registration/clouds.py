"""Point clouds prepared for registration: normals, noise, samples of meshes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.arrays import Array

_NEIGHBOURS = 12


@dataclass(frozen=True)
class Cloud:
    """Points (N, 3) [m] with what their neighbourhoods tell."""

    points: Array

    @cached_property
    def tree(self) -> Any:
        """Search tree of the points (scipy's cKDTree)."""
        from scipy.spatial import cKDTree

        return cKDTree(self.points)

    @cached_property
    def _local(self) -> tuple[Array, Array, Array]:
        """Variances (N, 3) and axes (N, 3, 3) of the neighbourhood of each point, and its radius (N,)."""
        distances, index = self.tree.query(self.points, k=min(_NEIGHBOURS, len(self.points)))
        near = self.points[index]
        centred = near - near.mean(axis=1, keepdims=True)
        values, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", centred, centred) / (near.shape[1] - 3))
        return np.maximum(values, 0.0), axes, distances[:, -1]

    @property
    def normals(self) -> Array:
        """Unit normals (N, 3) of the planes through the neighbours, with arbitrary sign."""
        return self._local[1][:, :, 0]

    @property
    def noise(self) -> float:
        """Standard deviation of the points about their local planes, the median over the cloud [m]."""
        return float(np.sqrt(np.median(self._local[0][:, 0])))

    @property
    def spacing(self) -> float:
        """Median distance between neighbours [m]."""
        return float(np.median(self._local[2]) / np.sqrt(_NEIGHBOURS / np.pi))

    def thinned(self, n: int) -> Array:
        """About n points, chosen evenly by index from a random order that is always the same."""
        if len(self.points) <= n:
            return self.points
        return np.asarray(self.points[np.random.default_rng(0).permutation(len(self.points))[:n]])


def sampled(vertices: Array, triangles: npt.NDArray[np.integer], n: int, seed: int = 0) -> Array:
    """Points (n, 3) spread evenly by area over a mesh with vertices (V, 3) [m] and triangles (T, 3)."""
    rng = np.random.default_rng(seed)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    steps = (np.arange(n) + rng.random(n)) / n  # stratified
    chosen = np.minimum(np.searchsorted(np.cumsum(areas) / areas.sum(), steps), len(areas) - 1)
    u, v = np.sqrt(rng.random((n, 1))), rng.random((n, 1))
    return np.asarray((1 - u) * a[chosen] + u * (1 - v) * b[chosen] + u * v * c[chosen])
