"""A checked mesh of tetrahedra in metres."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from palpate.arrays import Array
from palpate.errors import MeshError

Indices = npt.NDArray[np.int32]

MOST = 10_000_000
"""Largest number of tetrahedra."""

FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
"""Corners (4, 3) of the faces of a tetrahedron with positive volume, counter-clockwise seen from outside."""


@dataclass(frozen=True)
class TetMesh:
    """A volume of tetrahedra.

    Raises:
        MeshError: wrong shapes, an index out of range, a coordinate that is not finite, inverted or flat tetrahedra,
            a face of three tetrahedra, or more than `MOST` tetrahedra.
    """

    nodes: Array  #: (n, 3) [m]
    tets: Indices  #: (m, 4), each with a positive volume
    region: Indices = field(default_factory=lambda: np.zeros(0, dtype=np.int32))  #: (m,) material; 0 when left out
    name: str = "tetrahedra"  #: name in messages
    surface: Indices = field(init=False)  #: (k, 3) outer triangles, counter-clockwise seen from outside
    volumes: Array = field(init=False)  #: (m,) [m^3]

    def __post_init__(self) -> None:
        nodes, tets = _arrays(self.nodes, self.tets, self.name)
        region = np.asarray(self.region if len(self.region) else np.zeros(len(tets)), dtype=np.int32)
        if region.shape != (len(tets),):
            raise MeshError(f"region must have shape ({len(tets)},). Got: {region.shape}", where=self.name)
        volumes = signed_volumes(nodes, tets)
        _require_positive(volumes, self.name)
        for key, value in (("nodes", nodes), ("tets", tets), ("region", region), ("volumes", volumes)):
            object.__setattr__(self, key, value)
        object.__setattr__(self, "surface", _outer_faces(tets, self.name))

    def inside(self, points: Array) -> npt.NDArray[np.bool_]:
        """Whether points (k, 3) [m] lie in the box around the mesh."""
        return np.asarray(((points >= self.nodes.min(axis=0)) & (points <= self.nodes.max(axis=0))).all(axis=1))

    @property
    def centres(self) -> Array:
        """Centres (m, 3) of the tetrahedra [m]."""
        centres: Array = self.nodes[self.tets].mean(axis=1)
        return centres

    @property
    def parts(self) -> int:
        """Number of parts that share no node."""
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components

        a, b = self.tets[:, [0, 0, 0]].ravel(), self.tets[:, 1:].ravel()
        n = len(self.nodes)
        return int(connected_components(coo_matrix((np.ones(len(a)), (a, b)), (n, n)), directed=False)[0])


def signed_volumes(nodes: Array, tets: Indices) -> Array:
    """Volumes (m,) [m^3]; negative for inverted tetrahedra."""
    a, b, c, d = (nodes[tets[:, k]] for k in range(4))
    volumes: Array = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0
    return volumes


def _arrays(nodes: npt.ArrayLike, tets: npt.ArrayLike, name: str) -> tuple[Array, Indices]:
    v, t = np.ascontiguousarray(nodes, dtype=np.float64), np.asarray(tets)
    if v.ndim != 2 or v.shape[1] != 3:
        raise MeshError(f"nodes must have shape (n, 3). Got: {v.shape}", where=name, mend="one row per node [m]")
    if t.ndim != 2 or t.shape[1] != 4 or not np.issubdtype(t.dtype, np.integer) or len(t) == 0:
        raise MeshError(f"tets must be integers of shape (m, 4). Got: {t.dtype} {t.shape}", where=name)
    if len(t) > MOST:
        mend = "give a coarser resolution: the cycle steps some 10,000 tetrahedra"
        raise MeshError(f"{len(t):,} tetrahedra; a body has at most {MOST:,}", where=name, mend=mend)
    if t.min() < 0 or t.max() >= len(v):
        mend = "indices count from 0"
        raise MeshError(f"tets name node {int(t.max())}; the mesh has {len(v):,} nodes", where=name, mend=mend)
    used = np.unique(t)
    if not np.isfinite(v[used]).all():
        bad = int(used[np.argmin(np.isfinite(v[used]).all(axis=1))])
        raise MeshError(f"node {bad} is not finite: {v[bad].tolist()}", where=name, mend="export the mesh again")
    if len(used) < len(v):  # nodes without a tetrahedron would have no mass
        number = np.zeros(len(v), dtype=np.int32)
        number[used] = np.arange(len(used))
        v, t = v[used], number[t]
    return np.ascontiguousarray(v), np.ascontiguousarray(t, dtype=np.int32)


def _require_positive(volumes: Array, name: str) -> None:
    least = 1e-9 * float(np.median(np.abs(volumes)))
    bad = np.flatnonzero(volumes <= least)
    if len(bad) == 0:
        return
    raise MeshError(
        f"{len(bad):,} of {len(volumes):,} tetrahedra are inverted or flat; the first is {int(bad[0]):,} with "
        f"{volumes[bad[0]]:.3g} m^3",
        where=name,
        why="an element without a positive volume has no stiffness",
        mend="remesh the volume: palpate.tissue.tetrahedralize makes one from the closed surface",
    )


def _outer_faces(tets: Indices, name: str) -> Indices:
    """Faces of one tetrahedron only."""
    faces = tets[:, FACES].reshape(-1, 3)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    if count.max() > 2:
        i = int(first[np.argmax(count)]) // 4
        raise MeshError(f"tetrahedron {i:,} shares a face with {int(count.max()) - 1} others", where=name)
    return np.ascontiguousarray(faces[np.sort(first[count == 1])])
