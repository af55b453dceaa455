"""Blocks of tetrahedra, for benchmarks and first trials."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array


def block(cells: Sequence[int], size: npt.ArrayLike) -> tuple[Array, npt.NDArray[np.int32]]:
    """A box with one corner at the origin, with six tetrahedra per cell (Kuhn's division).

    Args:
        cells: number of cells along each axis.
        size: (3,) lengths of the box [m].

    Returns:
        Nodes (n, 3) [m] and tetrahedra (m, 4) of positive volume.
    """
    axes = [np.linspace(0.0, length, n + 1) for n, length in zip(cells, np.asarray(size), strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    shape = tuple(n + 1 for n in cells)
    corner = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 3)
    found = []
    for order in permutations(range(3)):
        path = [corner]
        for axis in order:
            path.append(path[-1] + np.eye(3, dtype=np.int64)[axis])
        found.append(np.stack([np.ravel_multi_index(tuple(p.T), shape) for p in path], axis=1))
    tets = np.stack(found, axis=1).reshape(-1, 4)
    inverted = np.linalg.det(nodes[tets[:, 1:]] - nodes[tets[:, :1]]) < 0.0
    tets[inverted] = tets[inverted][:, [0, 2, 1, 3]]
    return nodes, np.ascontiguousarray(tets, dtype=np.int32)
