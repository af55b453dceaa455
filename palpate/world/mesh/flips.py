"""Edge flips that replace thin triangles by better ones, without new vertices.

A triangle of 9.5 mm by 0.3 mm tilts by 22 degrees where one of its vertices is off by 0.06 mm: its normal carries no
knowledge of the surface. The other diagonal of the quadrilateral that it forms with a neighbour often does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array

Triangles = npt.NDArray[np.int32]
Index = npt.NDArray[np.int64]

THIN = 0.2
"""Height over longest edge of the triangles that are improved [-]."""
FOLD = 0.5
"""Cosine of the largest angle between the new triangles, and between each of them and the quadrilateral [-]."""
PASSES = 200


@dataclass(frozen=True)
class _Quads:
    """Inner edges (a, b) with the corners opposite: triangles ``left`` (a, b, c) and ``right`` (b, a, d)."""

    a: Index
    b: Index
    c: Index
    d: Index
    left: Index
    right: Index


def flip(v: Array, t: Triangles, tolerance: float) -> tuple[Triangles, int]:
    """Flip edges of thin triangles while the thinner one of the two triangles gets thicker.

    Args:
        v: vertices, shape (n, 3) [m].
        t: triangles, shape (m, 3), consistently wound.
        tolerance: largest distance of the two diagonals, by which the surface moves [m].

    Returns:
        The triangles, and the number of flips. The surface keeps its vertices, rims and topology.
    """
    t, flips = t.copy(), 0
    for _ in range(PASSES):
        q = _quads(t, len(v))
        new_left, new_right = np.stack([q.c, q.a, q.d], axis=1), np.stack([q.d, q.b, q.c], axis=1)
        before = np.minimum(thickness(v, t[q.left]), thickness(v, t[q.right]))
        after = np.minimum(thickness(v, new_left), thickness(v, new_right))
        good = (before < THIN) & (after > 1.01 * before) & (_gap(v, q) <= tolerance) & ~_taken(q, len(v))
        good &= _upright(v, q, new_left, new_right)
        order = np.flatnonzero(good)[np.argsort(before[good])]
        chosen = _apart(q, order)
        if len(chosen) == 0:
            break
        t[q.left[chosen]], t[q.right[chosen]] = new_left[chosen], new_right[chosen]
        flips += len(chosen)
    return t, flips


def thickness(v: Array, t: npt.NDArray[np.integer]) -> Array:
    """Height over longest edge, shape (m): .87 of an equilateral triangle, 0 of a degenerate one [-]."""
    sides = np.roll(v[t], -1, axis=1) - v[t]
    double = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    return np.asarray(double / np.maximum((sides**2).sum(axis=2).max(axis=1), 1e-300))


def _quads(t: Triangles, n: int) -> _Quads:
    """The inner edges; an edge of more than two triangles, or of two with unlike winding, is none."""
    start, end = t.ravel().astype(np.int64), np.roll(t, -1, axis=1).ravel().astype(np.int64)
    key, back = start * n + end, end * n + start
    order = np.argsort(key, kind="stable")
    found = order[np.minimum(np.searchsorted(key[order], back), len(order) - 1)]
    _, inverse, count = np.unique(key, return_inverse=True, return_counts=True)
    once = count[inverse] == 1
    half = np.flatnonzero((key[found] == back) & (start < end) & once & once[found])
    other = found[half]
    opposite = np.roll(t, -2, axis=1).ravel().astype(np.int64)
    return _Quads(start[half], end[half], opposite[half], opposite[other], half // 3, other // 3)


def _gap(v: Array, q: _Quads) -> Array:
    """Distance of the lines through the two diagonals [m]; infinite where they do not cross inside of both."""
    first, second, across = v[q.b] - v[q.a], v[q.d] - v[q.c], v[q.c] - v[q.a]
    normal = np.cross(first, second)
    square = np.maximum((normal**2).sum(axis=1), 1e-300)
    along = (np.cross(across, second) * normal).sum(axis=1) / square
    beside = (np.cross(across, first) * normal).sum(axis=1) / square
    inside = (along > 0.0) & (along < 1.0) & (beside > 0.0) & (beside < 1.0)
    return np.where(inside, np.abs((across * normal).sum(axis=1)) / np.sqrt(square), np.inf)


def _taken(q: _Quads, n: int) -> npt.NDArray[np.bool_]:
    """True where the other diagonal is an edge already."""
    edges = np.minimum(q.a, q.b) * n + np.maximum(q.a, q.b)
    return np.asarray(np.isin(np.minimum(q.c, q.d) * n + np.maximum(q.c, q.d), edges) | (q.c == q.d))


def _upright(v: Array, q: _Quads, left: Index, right: Index) -> npt.NDArray[np.bool_]:
    """True where the new triangles fold neither against each other nor against the quadrilateral."""
    whole = np.cross(v[q.b] - v[q.a], v[q.c] - v[q.d])
    normals = [np.cross(v[x[:, 1]] - v[x[:, 0]], v[x[:, 2]] - v[x[:, 0]]) for x in (left, right)]
    whole, one, two = (x / np.maximum(np.linalg.norm(x, axis=1, keepdims=True), 1e-300) for x in (whole, *normals))
    cosines = np.stack([(x * y).sum(axis=1) for x, y in ((whole, one), (whole, two), (one, two))])
    return np.asarray(cosines.min(axis=0) > FOLD)


def _apart(q: _Quads, order: Index) -> Index:
    """Of the edges in this order, those whose four vertices no earlier one has."""
    used: set[int] = set()
    chosen = []
    for i in order.tolist():
        corners = {int(q.a[i]), int(q.b[i]), int(q.c[i]), int(q.d[i])}
        if used.isdisjoint(corners):
            used |= corners
            chosen.append(i)
    return np.array(chosen, dtype=np.int64)
