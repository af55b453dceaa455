"""Point clouds prepared for registration: normals, noise, samples of meshes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.world.clouds.neighbourhoods import Sampling, sampling
from palpate.world.registration.fit import Indices


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
    def sampling(self) -> Sampling:
        """Spacing, noise, and the neighbours that show the surface."""
        return sampling(self.points)

    @cached_property
    def normals(self) -> Array:
        """Unit normals (N, 3) of the planes through the neighbours, with arbitrary sign."""
        _, index = self.tree.query(self.points, k=self.sampling.neighbours)
        near = self.points[index]
        centred = near - near.mean(axis=1, keepdims=True)
        return np.asarray(np.linalg.eigh(np.einsum("nki,nkj->nij", centred, centred))[1][:, :, 0])

    @cached_property
    def for_small_gicp(self) -> tuple[Any, Any]:
        """The points with normals as small_gicp takes them, and its search tree."""
        import small_gicp

        points = small_gicp.PointCloud(self.points)
        tree = small_gicp.KdTree(points)
        small_gicp.estimate_normals(points, tree)
        return points, tree

    @property
    def noise(self) -> float:
        """Standard deviation of the points about their local planes, the median over the cloud [m]."""
        return self.sampling.noise

    @property
    def spacing(self) -> float:
        """Median distance between neighbours [m]."""
        return self.sampling.spacing

    def sparse(self, n: int) -> Cloud:
        """The cloud of the points of `thinned`, made once."""
        if n not in self._sparse:
            self._sparse[n] = Cloud(self.thinned(n))
        return self._sparse[n]

    @cached_property
    def _sparse(self) -> dict[int, Cloud]:
        return {}

    def rows(self, n: int) -> Indices:
        """About n rows, evenly from a random order that is always the same."""
        if len(self.points) <= n:
            return np.arange(len(self.points))
        return np.random.default_rng(0).permutation(len(self.points))[:n]

    def thinned(self, n: int) -> Array:
        """The points of `rows`."""
        return np.asarray(self.points[self.rows(n)])


def sampled(vertices: Array, triangles: npt.NDArray[np.integer], n: int, seed: int = 0) -> Array:
    """Points (n, 3) spread evenly by area over a mesh with vertices (V, 3) [m] and triangles (T, 3)."""
    rng = np.random.default_rng(seed)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    steps = (np.arange(n) + rng.random(n)) / n  # stratified
    chosen = np.minimum(np.searchsorted(np.cumsum(areas) / areas.sum(), steps), len(areas) - 1)
    u, v = np.sqrt(rng.random((n, 1))), rng.random((n, 1))
    return np.asarray((1 - u) * a[chosen] + u * (1 - v) * b[chosen] + u * v * c[chosen])
