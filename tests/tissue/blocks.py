"""Bodies of known solutions: a block of tetrahedra, and the forces of its strain energy by differences."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from palpate import _core


def block(cells, size):
    """Nodes (n, 3), tetrahedra (m, 4) and boundary triangles (k, 3) of a box, six tetrahedra a cell (Kuhn)."""
    axes = [np.linspace(0.0, length, n + 1) for n, length in zip(cells, size, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    shape = np.array(cells) + 1
    corner = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 3)
    tets = []
    for order in permutations(range(3)):
        path = [corner]
        for axis in order:
            path.append(path[-1] + np.eye(3, dtype=int)[axis])
        tets.append(np.stack([np.ravel_multi_index(p.T, shape) for p in path], axis=1))
    tets = np.stack(tets, axis=1).reshape(-1, 4)
    edges = nodes[tets[:, 1:]] - nodes[tets[:, :1]]
    inverted = np.linalg.det(edges) < 0
    tets[inverted] = tets[inverted][:, [0, 2, 1, 3]]
    return nodes, tets.astype(np.int32), boundary(tets)


def boundary(tets):
    """Triangles (k, 3) of only one tetrahedron, wound outwards."""
    faces = np.concatenate([tets[:, f] for f in ([0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3])])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return np.ascontiguousarray(faces[first[count == 1]].astype(np.int32))


def body(
    mesh, young=5000.0, poisson=0.45, density=1000.0, *, fixed=None, yeoh=0.0, prony=(), spring=None, mu=None, **options
):
    """A ``TissueBody`` of one material; ``mu`` (m,) replaces the shear modulus."""
    nodes, tets, surface = mesh
    m = len(tets)
    shear = np.full(m, young / (2.0 * (1.0 + poisson))) if mu is None else mu
    return _core.TissueBody(
        nodes=np.ascontiguousarray(nodes),
        tets=tets,
        surface=surface,
        mu=shear,
        bulk=np.full(m, young / (3.0 * (1.0 - 2.0 * poisson))),
        density=np.full(m, density),
        yeoh=np.full(m, float(yeoh)),
        prony=list(prony),
        fixed=np.zeros(len(nodes), bool) if fixed is None else fixed,
        spring=np.zeros(len(nodes)) if spring is None else spring,
        **options,
    )


def settle(soft, seconds, brake=200):
    """Relax the body by dynamic relaxation: velocities are zeroed every ``brake`` steps."""
    n = len(soft.positions())
    for _ in range(int(seconds / soft.time_step / brake)):
        soft.step(brake)
        soft.set_state(soft.positions(), np.zeros((n, 3)))
