"""Removal of noise from the vertices of a measured mesh: a smooth surface within the noise of every vertex."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from palpate.world.mesh.mesh import Mesh

if TYPE_CHECKING:
    from scipy.sparse import csr_array

FARTHEST = 3.0
"""Largest displacement of a vertex over the noise [-]: 99.7 % of a normal distribution."""
_FACTOR = 0.6
"""Part of the way to the mean of the neighbours. A step damps a feature by `1 - (0.6 k)^2` with k < 2 the eigenvalue of
the neighbours' Laplacian: its size changes in second order only."""
_STEPS = 200


def denoise(mesh: Mesh, noise: float) -> Mesh:
    """A mesh with the same triangles, whose vertices are smoothed as far as their noise allows.

    Vertices move towards the mean of their neighbours and back by as much, which keeps the size of the surface (Taubin,
    "A signal processing approach to fair surface design", SIGGRAPH 1995, section 3), until they have moved by `noise`
    rms along the normal (the discrepancy principle; Morozov, Soviet Math. Dokl. 7, 1966). No vertex moves by
    more than `FARTHEST` times the noise: an edge or a ridge becomes blunt by at most that. Vertices of open rims stay.

    Args:
        mesh: the mesh.
        noise: standard deviation of its vertices along the normal [m], >= 0; `palpate check` estimates it.
    """
    if noise <= 0.0:
        return mesh
    v, t = mesh.vertices, mesh.triangles
    mean, free = _means(t, len(v))
    normals, x = _normals(v, t), v - v.mean(axis=0)
    moved = np.zeros_like(x)
    for _ in range(_STEPS):
        for factor in (_FACTOR, -_FACTOR):
            d = x + moved
            moved = moved + factor * free[:, None] * (mean @ d - d)
        moved *= np.minimum(1.0, FARTHEST * noise / np.maximum(np.linalg.norm(moved, axis=1, keepdims=True), 1e-300))
        if np.sqrt(((moved * normals).sum(axis=1) ** 2).mean()) >= noise:
            break
    return Mesh(v + moved, t, name=mesh.name)


def _means(t: npt.NDArray[np.int32], n: int) -> tuple[csr_array, npt.NDArray[np.float64]]:
    """The matrix (n, n) of the means of each vertex's neighbours, and 0 at vertices (n,) of open rims, else 1."""
    from scipy import sparse

    ends = np.sort(t[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, uses = np.unique(ends, axis=0, return_counts=True)
    a, b = np.concatenate([edges, edges[:, ::-1]]).T
    neighbours = sparse.csr_array((np.ones(len(a)), (a, b)), shape=(n, n))
    free = np.ones(n)
    free[edges[uses == 1].ravel()] = 0.0
    return sparse.diags_array(1.0 / np.maximum(neighbours.sum(axis=1), 1.0)) @ neighbours, free


def _normals(v: npt.NDArray[np.float64], t: npt.NDArray[np.int32]) -> npt.NDArray[np.float64]:
    """Unit normals (n, 3) of the vertices: the sum of the triangles' area vectors."""
    area = np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]])
    sums = np.stack([np.bincount(t.ravel(), np.repeat(area[:, k], 3), len(v)) for k in range(3)], axis=1)
    return np.asarray(sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-300))
