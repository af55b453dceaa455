"""The surface of a field: triangles where it is zero, its holes, and its parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import CloudError, MissingExtraError
from palpate.world.scan.field import Field

Triangles = npt.NDArray[np.int32]

CLOSED_BELOW = 0.2
"""Largest share of the area without points that is closed; above it, the surface stays open."""
_SMALL_PART = 0.05  # parts with a smaller share of the largest part's area are dropped


@dataclass(frozen=True)
class Hole:
    """A part of the surface where the camera saw nothing."""

    area: float  #: area of the membrane across the hole [m^2]
    centre: Array  #: (3,) [m]


@dataclass(frozen=True)
class Extracted:
    """A surface with its holes."""

    vertices: Array  #: (n, 3) [m]
    triangles: Triangles  #: (m, 3), counter-clockwise seen from outside
    closed: bool  #: True: the holes are closed by smooth membranes; False: they are open
    holes: tuple[Hole, ...]  #: the largest first


def extract(field: Field, close: bool | None = None) -> Extracted:
    """The surface where the field is zero.

    Args:
        field: the field.
        close: close the holes; None: if they are at most a fifth of the area.

    Raises:
        CloudError: there is no surface. MissingExtraError: scikit-image is not installed.
    """
    vertices, triangles = _zero(field)
    parts = _parts(len(vertices), triangles)
    area = _areas(vertices, triangles)
    of_part = np.bincount(parts[triangles[:, 0]], area)
    kept = of_part[parts[triangles[:, 0]]] > _SMALL_PART * of_part.max()
    triangles, area = triangles[kept], area[kept]
    seen = field.known[tuple(np.round((vertices - field.origin) / field.spacing).astype(int).T)]
    unseen = ~seen[triangles].all(axis=1)
    holes = _holes(vertices, triangles[unseen], area[unseen], field.spacing)
    open_share = float(area[unseen].sum() / area.sum())
    closed = open_share <= CLOSED_BELOW if close is None else close
    if not closed:
        triangles = triangles[~unseen]
    used, renumbered = np.unique(triangles, return_inverse=True)
    return Extracted(vertices[used], renumbered.reshape(-1, 3).astype(np.int32), closed, holes)


def _zero(field: Field) -> tuple[Array, Triangles]:
    try:
        from skimage.measure import marching_cubes
    except ModuleNotFoundError as missing:
        raise MissingExtraError("scikit-image, which extracts the surface,", "files") from missing
    try:
        vertices, triangles, _, _ = marching_cubes(  # type: ignore[no-untyped-call]
            field.values, 0.0, spacing=(field.spacing,) * 3, gradient_direction="descent", allow_degenerate=False
        )
    except ValueError as error:
        raise CloudError("the views have no common surface", why=str(error), mend="give more views") from None
    return np.asarray(vertices, dtype=np.float64) + field.origin, np.asarray(triangles, dtype=np.int32)


def _areas(vertices: Array, triangles: Triangles) -> Array:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def _parts(n: int, triangles: Triangles) -> npt.NDArray[np.int32]:
    """Number of the connected part (n,) of each of n vertices."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    i, j = triangles[:, [0, 1]].ravel(), triangles[:, [1, 2]].ravel()
    return np.asarray(connected_components(coo_matrix((np.ones(len(i)), (i, j)), (n, n)), directed=False)[1])


def _holes(vertices: Array, triangles: Triangles, area: Array, spacing: float) -> tuple[Hole, ...]:
    """Connected parts of the triangles without points, apart from slivers smaller than a few cells."""
    if not len(triangles):
        return ()
    part = _parts(len(vertices), triangles)[triangles[:, 0]]
    total = np.bincount(part, area)
    middles = vertices[triangles].mean(axis=1)
    found = []
    for k in np.flatnonzero(total > 4.0 * spacing**2):
        own = part == k
        found.append(Hole(float(total[k]), np.average(middles[own], axis=0, weights=area[own])))
    return tuple(sorted(found, key=lambda hole: -hole.area))
