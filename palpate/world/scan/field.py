"""The field of a scan: signed distances on a grid, from the planes through the points of all views.

Around each point lies a plane with a Gaussian weight of width s. The field at a node g is the weighted mean of two
distances: from the planes of the points, n_i . (g - p_i), and from the mean point along the mean normal,
n(g) . (g - p_i). On a surface with curvature k the first one is wrong by +k s^2 and the second by -k s^2, so that their
mean has neither error (as in the symmetric objective of S. Rusinkiewicz, "A symmetric objective function for ICP", ACM
Transactions on Graphics 38, 2019). The first term alone is the implicit moving-least-squares surface of R. Kolluri
(SODA 2005). All sums are convolutions with the Gaussian, n . g - sum(n_i . p_i), so that the time does not depend on
the number of points within s.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array

Mask = npt.NDArray[np.bool_]

MOST_NODES = 4_000_000
"""Largest number of nodes of the grid."""
_MARGIN = 4  # nodes around the points
_SUPPORT = 0.02  # smallest weight of a known node, relative to the 95th percentile
_CUT = 3.0  # extent of the Gaussian, in its widths
_SWEEPS = 30  # of the solution in unknown nodes, on every grid


@dataclass(frozen=True)
class Field:
    """Signed distances on the nodes of a grid, positive outside."""

    values: Array  #: (nx, ny, nz), at most two spacings in magnitude [m]
    known: Mask  #: (nx, ny, nz) True where points are near; the other values continue them smoothly
    origin: Array  #: (3,) position of the first node [m]
    spacing: float  #: distance of the nodes [m]


def fuse(points: Array, to_sensor: Array, spacing: float) -> Field:
    """The field of points (N, 3) [m] with directions (N, 3) to the sensor, on a grid with this spacing [m]."""
    grid = _Grid(points, spacing)
    centre = points.mean(axis=0)
    p = points - centre  # relative to the middle, for precision
    weight = grid.sums(np.ones(len(p)))
    known = weight > _SUPPORT * np.percentile(weight[weight > 0.0], 95)
    w = weight[known]

    def mean(values: Array) -> Array:
        return np.stack([grid.sums(column)[known] / w for column in values.T], axis=1)

    p_mean = mean(p)
    normals = _normals(p_mean, mean(p[:, [0, 0, 0, 1, 1, 2]] * p[:, [0, 1, 2, 1, 2, 2]]), mean(to_sensor))
    at_nodes = np.zeros((known.size, 3))
    at_nodes[known.ravel()] = normals
    n = at_nodes[grid.nearest]
    g = (np.argwhere(known) * spacing + grid.origin) - centre
    n_mean = mean(n)
    from_planes = np.einsum("ni,ni->n", g, n_mean) - mean(np.einsum("ni,ni->n", n, p)[:, None])[:, 0]
    along = n_mean / np.maximum(np.linalg.norm(n_mean, axis=1, keepdims=True), 1e-9)
    from_middle = np.einsum("ni,ni->n", g - p_mean, along)
    values = np.zeros(known.shape)
    values[known] = np.clip(0.5 * (from_planes + from_middle), -2.0 * spacing, 2.0 * spacing)
    return Field(continued(values, known, 2.0 * spacing), known, grid.origin, spacing)


class _Grid:
    """A grid around points, and weighted sums of the points' values at its nodes."""

    def __init__(self, points: Array, spacing: float) -> None:
        low, high = points.min(axis=0), points.max(axis=0)
        self.origin = low - _MARGIN * spacing
        self.shape = tuple(int(n) for n in np.ceil((high - low) / spacing).astype(int) + 2 * _MARGIN + 1)
        index = np.round((points - self.origin) / spacing).astype(np.int64)
        self.nearest = np.ravel_multi_index(tuple(index.T), self.shape)

    def sums(self, values: Array) -> Array:
        """Sums of values (N,) weighted by a Gaussian of one spacing about every node."""
        from scipy.ndimage import gaussian_filter

        at_nodes = np.bincount(self.nearest, values, int(np.prod(self.shape))).reshape(self.shape)
        return np.asarray(gaussian_filter(at_nodes, 1.0, truncate=_CUT, mode="constant"))


def _normals(p_mean: Array, squares: Array, to_sensor: Array) -> Array:
    """Unit normals (M, 3) towards the sensor from mean points, mean products xx xy xz yy yz zz and mean directions."""
    C = squares[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3) - p_mean[:, :, None] * p_mean[:, None, :]
    normals = np.linalg.eigh(C)[1][:, :, 0]
    towards = np.einsum("ni,ni->n", normals, to_sensor)
    return np.asarray(normals * np.where(towards < 0.0, -1.0, 1.0)[:, None])


def continued(values: Array, known: Mask, outside: float) -> Array:
    """Values continued from the known nodes to all others as a membrane (Laplace's equation), `outside` at the border.

    J. Davis et al., "Filling holes in complex surfaces using volumetric diffusion", 3DPVT 2002. The start on each grid
    is the solution on one of half the resolution (cascadic iteration).
    """
    filled = np.where(known, values, outside)
    if min(values.shape) > 16:
        mean, count = _halved(np.where(known, values, 0.0)), _halved(known.astype(float))
        coarse = continued(mean / np.maximum(count, 1e-9), count > 0.0, outside)
        fine = coarse.repeat(2, 0).repeat(2, 1).repeat(2, 2)[tuple(slice(n) for n in values.shape)]
        np.copyto(filled, fine, where=~known)
    inner = (slice(1, -1),) * 3
    border = np.ones(values.shape, dtype=bool)
    border[inner] = False
    filled[border & ~known] = outside
    free, middle = ~known[inner], filled[inner]
    for _ in range(_SWEEPS):
        mean = (filled[2:, 1:-1, 1:-1] + filled[:-2, 1:-1, 1:-1] + filled[1:-1, 2:, 1:-1]) / 6.0
        mean += (filled[1:-1, :-2, 1:-1] + filled[1:-1, 1:-1, 2:] + filled[1:-1, 1:-1, :-2]) / 6.0
        np.copyto(middle, mean, where=free)
    return filled


def _halved(values: Array) -> Array:
    """Sums over blocks of 2 x 2 x 2 nodes."""
    padded = np.pad(values, [(0, n % 2) for n in values.shape])
    x, y, z = (n // 2 for n in padded.shape)
    return np.asarray(padded.reshape(x, 2, y, 2, z, 2).sum(axis=(1, 3, 5)))
