"""Triangles as a surface: welding, edges, parts and windings. `palpate.check` says what they mean to a user."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Vertices = npt.NDArray[np.float64]  # (n, 3) [m]
Triangles = npt.NDArray[np.int32]  # (m, 3)
Index = npt.NDArray[np.integer]


def weld(vertices: Vertices, triangles: Triangles) -> tuple[Vertices, Triangles]:
    """Merge vertices with equal coordinates and forget unused ones; the order of the triangles stays."""
    used = triangles.reshape(-1)
    whole = len(used) == len(vertices) and bool((used == np.arange(len(used), dtype=used.dtype)).all())
    corners = np.ascontiguousarray(vertices if whole else vertices[used]) + 0.0  # -0 becomes 0
    key = _hash(corners)
    order = np.argsort(key)
    key = key[order]
    new = np.empty(len(order), dtype=bool)
    new[:1] = True
    np.not_equal(key[1:], key[:-1], out=new[1:])
    index = np.empty(len(order), dtype=np.int32)
    index[order] = np.cumsum(new, dtype=np.int32) - 1
    unique = corners[order[new]]
    if not np.array_equal(unique[index], corners):  # two places, one hash: once in a blue moon
        unique, inverse = np.unique(corners, axis=0, return_inverse=True)
        index = inverse.astype(np.int32)
    return unique, index.reshape(-1, 3)


def _hash(points: Vertices) -> npt.NDArray[np.uint64]:
    bits = points.view(np.uint64)
    key: npt.NDArray[np.uint64] = bits[:, 0] * np.uint64(0x9E3779B97F4A7C15)
    for column, factor in ((1, 0xC2B2AE3D27D4EB4F), (2, 0x165667B19E3779F9)):
        key ^= key >> np.uint64(31)
        key ^= bits[:, column]
        key *= np.uint64(factor)
    key ^= key >> np.uint64(29)
    return key


def normals(v: Vertices, t: Triangles) -> Vertices:
    """Outward normals, twice the area long."""
    a = v[t[:, 0]]
    (ax, ay, az), (bx, by, bz) = (v[t[:, 1]] - a).T, (v[t[:, 2]] - a).T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)


def wedges(v: Vertices, t: Triangles) -> npt.NDArray[np.float64]:
    """Signed volume between each triangle and the first vertex [m^3]."""
    return np.asarray(np.einsum("ij,ij->i", v[t[:, 0]] - v[0], normals(v, t)) / 6.0)


def distinct_corners(t: Triangles) -> npt.NDArray[np.bool_]:
    """False for a triangle that names a vertex twice."""
    return np.asarray((t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0]))


def first_of_each(t: Triangles) -> npt.NDArray[np.bool_]:
    """False for a triangle that was there before with the same corners in the same sense."""
    n = np.int64(t.max(initial=0)) + 1
    low = t.min(axis=1).astype(np.int64)
    shift = np.argmin(t, axis=1)
    rows = np.arange(len(t))
    second, third = t[rows, (shift + 1) % 3].astype(np.int64), t[rows, (shift + 2) % 3].astype(np.int64)
    # (second, third) names a directed edge: with the low corner it names the triangle and its sense.
    key = low * n + second if n * n < 2**62 else low
    order = np.lexsort((third, key))
    same = (key[order][1:] == key[order][:-1]) & (third[order][1:] == third[order][:-1])
    same &= second[order][1:] == second[order][:-1]
    keep = np.ones(len(t), dtype=bool)
    keep[order[1:][same]] = False
    return keep


def turned(t: Triangles, flip: npt.NDArray[np.bool_]) -> Triangles:
    """The triangles, some of them wound the other way."""
    out = t.copy()
    out[flip] = t[flip][:, ::-1]
    return out


@dataclass(frozen=True)
class Edges:
    """Edges by their number of triangles; ``pairs`` are the two triangles of an ordinary edge."""

    open: int
    crowded: int
    clashing: int  # ordinary edges that both triangles walk in the same sense
    pairs: Index  # (k, 2) triangles
    same_sense: npt.NDArray[np.bool_]  # (k,)
    border: npt.NDArray[np.bool_]  # (m,) triangles with an open edge

    @staticmethod
    def of(t: Triangles, n_vertices: int) -> Edges:
        """The edges of triangles (m, 3)."""
        a = t.T.reshape(-1).astype(np.int64)
        b = t[:, (1, 2, 0)].T.reshape(-1).astype(np.int64)
        key = np.minimum(a, b) * n_vertices + np.maximum(a, b)
        order = np.argsort(key)
        key = key[order]
        start = np.flatnonzero(np.concatenate(([True], key[1:] != key[:-1]))) if len(key) else np.empty(0, np.int64)
        count = np.diff(np.append(start, len(key)))
        first = start[count == 2]
        one, two = order[first], order[first + 1]
        m = len(t)
        same = (a < b)[one] == (a < b)[two]
        border = np.zeros(m, dtype=bool)
        border[order[start[count == 1]] % max(m, 1)] = True
        return Edges(
            open=int((count == 1).sum()),
            crowded=int((count > 2).sum()),
            clashing=int(same.sum()),
            pairs=np.stack([one % max(m, 1), two % max(m, 1)], axis=1),
            same_sense=same,
            border=border,
        )


def components(n: int, *links: npt.NDArray[np.integer]) -> tuple[Index, int]:
    """Label of each of ``n`` nodes by connected part, given links (k, 2); and the number of parts with links."""
    a = np.concatenate([link[:, 0] for link in links])
    b = np.concatenate([link[:, 1] for link in links])
    label = np.arange(n, dtype=a.dtype)
    linked = np.zeros(n, dtype=bool)
    linked[a] = True
    linked[b] = True
    while True:  # every part hooks onto the lowest label it sees, then labels are followed to their root
        la, lb = label[a], label[b]
        apart = la != lb
        if not apart.any():
            break
        a, b, la, lb = a[apart], b[apart], la[apart], lb[apart]
        high, low = np.maximum(la, lb), np.minimum(la, lb)
        label[high] = low  # any one of the competing links will do: low < high, so there is no cycle
        while True:
            up = label[label]
            if np.array_equal(up, label):
                break
            label = up
    return label, int(np.count_nonzero((label == np.arange(n)) & linked))


def orient(edges: Edges, m: int) -> tuple[npt.NDArray[np.bool_], bool]:
    """Which of ``m`` triangles to turn so that neighbours agree, turning as few as possible; and whether that works.

    Every triangle is two nodes: as it is (i) and turned (i + m). A link joins what fits together; a surface with
    two sides falls apart into mirrored halves.
    """
    i, j = edges.pairs[:, 0], edges.pairs[:, 1]
    other = np.where(edges.same_sense, m, 0)
    label, _ = components(2 * m, np.stack([i, j + other], 1), np.stack([i + m, j + m - other], 1))
    as_is, mirrored = label[:m], label[m:]
    one_sided = as_is == mirrored
    votes = np.bincount(as_is, minlength=2 * m)
    flip = (votes[mirrored] > votes[as_is]) | ((votes[mirrored] == votes[as_is]) & (mirrored < as_is))
    return flip & ~one_sided, not bool(one_sided.any())


def inside_out(
    v: Vertices, t: Triangles, wedge: npt.NDArray[np.float64], part: Index, edges: Edges | None
) -> tuple[npt.NDArray[np.bool_], float]:
    """Triangles of closed parts with negative volume that are not cavities of another part; total volume [m^3]."""
    parts, index = np.unique(part, return_inverse=True)
    closed = np.ones(len(parts), dtype=bool)
    if edges is not None:
        closed = np.bincount(index, weights=edges.border, minlength=len(parts)) == 0
    volume = np.bincount(index, weights=wedge, minlength=len(parts))
    flip = np.zeros(len(parts), dtype=bool)
    suspects = np.flatnonzero(closed & (volume < 0.0))
    if len(suspects):
        low, high = _boxes(v, t, index, len(parts))
        for s in suspects:
            around = (low <= low[s]).all(axis=1) & (high >= high[s]).all(axis=1) & closed
            flip[s] = np.count_nonzero(around) % 2 == 1  # itself only, or a solid within a cavity within a solid
    volume = np.where(flip, -volume, volume)
    return flip[index], float(volume[closed].sum())


def _boxes(v: Vertices, t: Triangles, index: Index, n: int) -> tuple[Vertices, Vertices]:
    low, high = np.full((n, 3), np.inf), np.full((n, 3), -np.inf)
    for k in range(3):
        np.minimum.at(low, index, v[t[:, k]])
        np.maximum.at(high, index, v[t[:, k]])
    return low, high
