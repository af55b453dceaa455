"""A checked mesh of tetrahedra in metres."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import MeshError

Indices = npt.NDArray[np.int32]

MOST = 10_000_000
"""Largest number of tetrahedra."""

FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
"""Corners (4, 3) of the faces of a tetrahedron with positive volume, counter-clockwise seen from outside."""


NEAR = 1e-3
"""Distance below which two nodes are the same one, over the shortest edge of the tetrahedra [-]."""


@dataclass(frozen=True)
class Finding:
    """What was corrected in a mesh of tetrahedra."""

    what: str
    why: str
    mend: str


@dataclass(frozen=True)
class TetMesh:
    """A volume of tetrahedra.

    Tetrahedra that list their nodes in the other order are turned, and nodes at one place are joined; `findings` tells
    how many.

    Raises:
        MeshError: wrong shapes, an index out of range, a coordinate that is not finite, flat tetrahedra, tetrahedra
            that lie on the same side of a face, a face of three tetrahedra, or more than `MOST` tetrahedra.
    """

    nodes: Array  #: (n, 3) [m]
    tets: Indices  #: (m, 4), each with a positive volume
    region: Indices = field(default_factory=lambda: np.zeros(0, dtype=np.int32))  #: (m,) material; 0 when left out
    name: str = "tetrahedra"  #: name in messages
    surface: Indices = field(init=False)  #: (k, 3) outer triangles, counter-clockwise seen from outside
    volumes: Array = field(init=False)  #: (m,) [m^3]
    turned: int = field(init=False)  #: tetrahedra whose order of nodes was turned
    joined: int = field(init=False)  #: nodes that were joined with another one at the same place

    def __post_init__(self) -> None:
        nodes, tets = _arrays(self.nodes, self.tets, self.name)
        nodes, tets, joined = _joined(nodes, tets)
        region = np.asarray(self.region if len(self.region) else np.zeros(len(tets)), dtype=np.int32)
        if region.shape != (len(tets),):
            raise MeshError(f"region must have shape ({len(tets)},). Got: {region.shape}", where=self.name)
        volumes = signed_volumes(nodes, tets)
        other = volumes < 0.0
        tets[other] = tets[other][:, [0, 2, 1, 3]]
        volumes = np.abs(volumes)
        _require_volume(volumes, self.name)
        for key, value in (("nodes", nodes), ("tets", tets), ("region", region), ("volumes", volumes)):
            object.__setattr__(self, key, value)
        object.__setattr__(self, "turned", int(other.sum()))
        object.__setattr__(self, "joined", joined)
        object.__setattr__(self, "surface", _outer_faces(nodes, tets, self.name))

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was corrected."""
        found = []
        if self.turned:
            what = f"{self.turned:,} of {len(self.tets):,} tetrahedra list their nodes in the other order: turned"
            found.append(
                Finding(what, "their volume came out negative", "none is needed; another program may refuse it")
            )
        if self.joined:
            what = f"{self.joined:,} nodes lie at the place of another one: joined"
            mend = "none is needed, unless the parts are meant to slide on each other: then give them as two objects"
            found.append(Finding(what, "parts that share no node do not hold each other", mend))
        return tuple(found)

    def inside(self, points: Array) -> npt.NDArray[np.bool_]:
        """Whether points (k, 3) [m] lie in the box around the mesh."""
        return np.asarray(((points >= self.nodes.min(axis=0)) & (points <= self.nodes.max(axis=0))).all(axis=1))

    @property
    def centres(self) -> Array:
        """Centres (m, 3) of the tetrahedra [m]."""
        centres: Array = self.nodes[self.tets].mean(axis=1)
        return centres

    @property
    def part(self) -> Indices:
        """Number (n,) of the part to which each node belongs, from 0; parts share no node."""
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components

        a, b = self.tets[:, [0, 0, 0]].ravel(), self.tets[:, 1:].ravel()
        n = len(self.nodes)
        return np.asarray(connected_components(coo_matrix((np.ones(len(a)), (a, b)), (n, n)), directed=False)[1])

    @property
    def parts(self) -> int:
        """Number of parts that share no node."""
        return int(self.part.max()) + 1


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


def _joined(nodes: Array, tets: Indices) -> tuple[Array, Indices, int]:
    """Joins nodes at one place. Also returns how many went."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    edges = nodes[tets] - nodes[np.roll(tets, 1, axis=1)]
    near = NEAR * float(np.sqrt((edges**2).sum(axis=2).min()))
    pairs = cKDTree(nodes).query_pairs(near, output_type="ndarray")
    if len(pairs) == 0:
        return nodes, tets, 0
    n = len(nodes)
    number = connected_components(coo_matrix((np.ones(len(pairs)), pairs.T), (n, n)), directed=False)[1]
    kept, place = np.unique(number, return_index=True)
    return np.ascontiguousarray(nodes[place]), number[tets].astype(np.int32), n - len(kept)


def _require_volume(volumes: Array, name: str) -> None:
    bad = np.flatnonzero(volumes <= 1e-9 * float(np.median(volumes)))
    if len(bad) == 0:
        return
    raise MeshError(
        f"{len(bad):,} of {len(volumes):,} tetrahedra are flat; the first is {int(bad[0]):,} with "
        f"{volumes[bad[0]]:.3g} m^3",
        where=name,
        why="an element without a volume has no stiffness",
        mend=_REMESH,
    )


_REMESH = "remesh the volume: palpate.world.tissue.tetrahedralize makes one from the closed surface"


def _outer_faces(nodes: Array, tets: Indices, name: str) -> Indices:
    """Faces of one tetrahedron only. Two tetrahedra of positive volume see the face between them from both sides."""
    faces = tets[:, FACES].reshape(-1, 3)
    order = np.argsort(faces, axis=1)
    odd = (order[:, 1] - order[:, 0]) % 3 == 2
    _, first, at, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    if count.max() > 2:
        i = int(first[np.argmax(count)]) // 4
        raise MeshError(f"tetrahedron {i:,} shares a face with {int(count.max()) - 1} others", where=name)
    seen = np.bincount(at.reshape(-1), np.where(odd, -1.0, 1.0))
    folded = np.flatnonzero((count == 2) & (seen != 0.0))
    if len(folded):
        i = int(first[folded[0]]) // 4
        raise MeshError(
            f"{len(folded):,} pairs of tetrahedra lie on the same side of the face between them, the first at "
            f"tetrahedron {i:,}: one of each is inverted",
            where=name,
            why="the tetrahedra fill a space twice",
            mend=_REMESH,
        )
    return np.ascontiguousarray(faces[np.sort(first[count == 1])])
