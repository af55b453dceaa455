"""Closed triangle mesh of an implicit solid: surface nets, followed by relaxation on the surface.

The surface is {p : f(p) = 0}, f < 0 inside. Every grid cell that the surface crosses gets one vertex, every grid
edge that it crosses gets one quadrilateral between the four cells around it (naive surface nets). The vertices are then
moved towards the mean of their neighbours in the tangent plane, and back onto f = 0 by Newton steps. The triangles
become well shaped, and the vertices lie on the exact surface.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Vertices = NDArray[np.float64]  # (n, 3) [m]
Triangles = NDArray[np.int32]  # (m, 3) counter-clockwise seen from outside
Field = Callable[[NDArray[np.float64]], NDArray[np.float64]]  # (..., 3) [m] -> (...) [m], negative inside

RELAX_ROUNDS = 8


def extract(field: Field, lower: Vertices, upper: Vertices, spacing: float) -> tuple[Vertices, Triangles]:
    """Surface {f = 0} inside the box [lower, upper] as a closed mesh of about `spacing` metres edge length.

    The solid must lie strictly inside the box and be thicker than two cells everywhere; f must approximate a
    distance near its zero. Raises ValueError if the solid touches the box or no grid point is inside it.
    """
    vertices, quads = _nets(field, lower, upper, spacing)
    vertices = _relax(field, vertices, quads, spacing)
    return vertices, _split(vertices, quads)


def rough(field: Field, lower: Vertices, upper: Vertices, spacing: float) -> tuple[Vertices, Triangles]:
    """As `extract` without relaxation: ten times faster, with vertices a fraction of a cell off the surface."""
    vertices, quads = _nets(field, lower, upper, spacing)
    return vertices, _split(vertices, quads)


def triangle_count(field: Field, lower: Vertices, upper: Vertices, spacing: float) -> int:
    """Number of triangles that `extract` would return: two per grid edge that the surface crosses."""
    inside = _sample(field, lower, upper, spacing) < 0.0
    return 2 * int(sum(np.count_nonzero(np.diff(inside, axis=a)) for a in range(3)))


def refine(field: Field, vertices: Vertices, triangles: Triangles, spacing: float) -> tuple[Vertices, Triangles]:
    """Split each triangle into four and move the new vertices onto f = 0; `spacing` is the edge length before [m]."""
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges, which = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    middle = _project(field, vertices[edges].mean(axis=1), 0.5 * spacing)
    ab, bc, ca = len(vertices) + which.reshape(3, -1)
    a, b, c = triangles.T
    quarters = np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return np.concatenate([vertices, middle]), quarters.astype(np.int32)


def _nets(field: Field, lower: Vertices, upper: Vertices, spacing: float) -> tuple[Vertices, NDArray[np.int64]]:
    """Vertices (one per crossed cell) and quadrilaterals (m, 4) (one per crossed grid edge)."""
    values = _sample(field, lower, upper, spacing)
    inside = values < 0.0
    if not inside.any():
        raise ValueError("no point of the grid is inside the solid: the box misses it, or the spacing is too coarse")
    shell = np.ones_like(inside)
    shell[1:-1, 1:-1, 1:-1] = False
    if (inside & shell).any():
        raise ValueError("the solid touches the box: enlarge the box, otherwise the surface stays open")
    cell_id, vertices = _cell_vertices(values, inside, lower, spacing)
    return vertices, _quads(inside, cell_id)


def _sample(field: Field, lower: Vertices, upper: Vertices, spacing: float) -> NDArray[np.float64]:
    """f at the grid points, evaluated slab by slab to limit the memory."""
    counts = np.ceil((upper - lower) / spacing).astype(int) + 1
    x, y, z = (lower[a] + spacing * np.arange(counts[a]) for a in range(3))
    slab = np.empty((counts[1], counts[2], 3))
    slab[..., 1], slab[..., 2] = y[:, None], z
    values = np.empty(counts)
    for i, value in enumerate(x):
        slab[..., 0] = value
        values[i] = field(slab)
    return values


def _cell_vertices(
    values: NDArray[np.float64], inside: NDArray[np.bool_], lower: Vertices, spacing: float
) -> tuple[NDArray[np.int64], Vertices]:
    """One vertex per crossed cell: the mean of the points where the surface crosses the cell's edges."""
    corners = [(slice(dx, dx - 1 or None), slice(dy, dy - 1 or None), slice(dz, dz - 1 or None))
               for dx in (0, 1) for dy in (0, 1) for dz in (0, 1)]  # fmt: skip
    count = np.sum([inside[c] for c in corners], axis=0, dtype=np.int8)
    crossed = (count > 0) & (count < 8)
    cell_id = np.full(crossed.shape, -1, dtype=np.int64)
    cell_id[crossed] = np.arange(crossed.sum())

    base = np.argwhere(crossed)  # (n, 3) cell indices
    corner_values = np.stack([values[c][crossed] for c in corners], axis=1)  # (n, 8)
    total, hits = np.zeros(base.shape), np.zeros(len(base))
    for axis, step in ((0, 4), (1, 2), (2, 1)):
        for start in (c for c in range(8) if not c & step):
            f0, f1 = corner_values[:, start], corner_values[:, start + step]
            cut = (f0 < 0.0) != (f1 < 0.0)
            point = np.tile([(start >> 2) & 1, (start >> 1) & 1, start & 1], (len(base), 1)).astype(float)
            point[cut, axis] = f0[cut] / (f0[cut] - f1[cut])
            total[cut] += point[cut]
            hits += cut
    return cell_id, lower + spacing * (base + total / hits[:, None])


def _quads(inside: NDArray[np.bool_], cell_id: NDArray[np.int64]) -> NDArray[np.int64]:
    """The four cells around every crossed grid edge, counter-clockwise seen from outside: (m, 4)."""
    quads = []
    for axis in range(3):
        u, w = (axis + 1) % 3, (axis + 2) % 3
        first = np.take(inside, range(inside.shape[axis] - 1), axis=axis)
        second = np.take(inside, range(1, inside.shape[axis]), axis=axis)
        edges = np.argwhere(first != second)
        unit_u, unit_w = np.eye(3, dtype=int)[u], np.eye(3, dtype=int)[w]
        ring = [cell_id[tuple((edges - d).T)] for d in (unit_u + unit_w, unit_w, 0 * unit_u, unit_u)]
        quad = np.stack(ring, axis=1)
        leaving = first[tuple(edges.T)]  # the solid is on the lower side: the outward normal points along +axis
        quads.append(np.where(leaving[:, None], quad, quad[:, ::-1]))
    return np.concatenate(quads)


def _gradient(field: Field, points: Vertices, step: float) -> Vertices:
    return np.stack([field(points + e) - field(points - e) for e in step * np.eye(3)], axis=-1) / (2.0 * step)


def _project(field: Field, points: Vertices, spacing: float, rounds: int = 2) -> Vertices:
    """Newton steps along the gradient, each limited to half a cell."""
    for _ in range(rounds):
        g = _gradient(field, points, 0.05 * spacing)
        move = -field(points)[:, None] * g / np.maximum((g * g).sum(axis=1, keepdims=True), 1e-12)
        length = np.linalg.norm(move, axis=1, keepdims=True)
        points = points + move * np.minimum(1.0, 0.5 * spacing / np.maximum(length, 1e-300))
    return points


def _relax(field: Field, vertices: Vertices, quads: NDArray[np.int64], spacing: float) -> Vertices:
    sides = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
    a, b = np.unique(np.sort(sides, axis=1), axis=0).T
    degree = np.bincount(a, minlength=len(vertices)) + np.bincount(b, minlength=len(vertices))
    for _ in range(RELAX_ROUNDS):
        total = np.stack(
            [
                np.bincount(a, vertices[b, k], len(vertices)) + np.bincount(b, vertices[a, k], len(vertices))
                for k in range(3)
            ],
            axis=1,
        )
        g = _gradient(field, vertices, 0.05 * spacing)
        n = g / np.linalg.norm(g, axis=1, keepdims=True)
        offset = total / degree[:, None] - vertices
        vertices = vertices + 0.6 * (offset - (offset * n).sum(axis=1, keepdims=True) * n)
        vertices = _project(field, vertices, spacing, rounds=1)
    return _project(field, vertices, spacing)


def _split(vertices: Vertices, quads: NDArray[np.int64]) -> Triangles:
    """Split each quadrilateral along its shorter diagonal."""
    v = vertices[quads]
    short = np.linalg.norm(v[:, 0] - v[:, 2], axis=1) <= np.linalg.norm(v[:, 1] - v[:, 3], axis=1)
    first = np.where(short[:, None], quads[:, [0, 1, 2]], quads[:, [0, 1, 3]])
    second = np.where(short[:, None], quads[:, [0, 2, 3]], quads[:, [1, 2, 3]])
    return np.concatenate([first, second]).astype(np.int32)
