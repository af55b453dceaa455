"""A repaired copy of a mesh: cracks sewn, slivers collapsed, small holes filled. Nothing that the user must judge."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate import _core

Vertices = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.int32]

CRACK = 0.01
"""Rims nearer to each other than this share of the median edge are one [-]."""
SLIVER = 1e-4
"""Edges shorter than this share of the median edge are points [-]."""
LONGEST_LOOP = 120
"""Vertices around a hole that is filled: the work grows with the third power."""
CRUMB = 0.01
"""Parts with less than this share of the triangles are small [-]."""


@dataclass(frozen=True)
class Repairs:
    """What was done, and what was left to the user."""

    sewn: int  #: rim vertices moved onto their neighbours across a crack
    collapsed: int  #: slivers without area to speak of: gone, their neighbours meet
    filled: int  #: holes closed with triangles of least area
    left_open: int  #: holes wider than asked, or with too many corners
    widest_left_mm: float


def repair(mesh: _core.Mesh, widest_hole: float) -> tuple[Vertices, Triangles, Repairs]:
    """Mend what needs no judgement; the winding, duplicates and triangles without area the core has mended already.

    Args:
        mesh: as loaded.
        widest_hole: holes whose corners lie farther apart stay open [m].

    Returns:
        Vertices (n, 3) [m], triangles (m, 3), and what was done.
    """
    v, before = np.array(mesh.vertices), mesh.triangle_count
    edge = float(np.median(np.linalg.norm(v[mesh.triangles[:, 0]] - v[mesh.triangles[:, 1]], axis=1)))
    t, sewn = _merge(v, np.array(mesh.triangles), np.unique(mesh.rims()), CRACK * edge)
    t, _ = _merge(v, t, np.unique(_short_edges(v, t, SLIVER * edge)), SLIVER * edge)
    collapsed = before - len(t)
    mesh = _core.Mesh(v, t)
    v, t = np.array(mesh.vertices), np.array(mesh.triangles)
    edges = (
        {(min(a, b), max(a, b)) for a, b in t[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()}
        if len(mesh.rims())
        else set()
    )
    patches, left = [], [0.0]
    for loop in loops(mesh.rims()):
        width = float(np.linalg.norm(np.ptp(v[loop], axis=0)))
        patch = fill(v, loop, edges) if width <= widest_hole and len(loop) <= LONGEST_LOOP else None
        if patch is None:
            left.append(1e3 * width)
        else:
            patches.append(patch)
            edges |= {(min(a, b), max(a, b)) for a, b in patch[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).tolist()}
    t = np.concatenate([t, *patches]).astype(np.int32)
    return v, t, Repairs(sewn, collapsed, len(patches), len(left) - 1, max(left))


def small_parts(mesh: _core.Mesh) -> int:
    """How many parts have less than ``CRUMB`` of the triangles."""
    label = np.arange(len(mesh.vertices))
    t = mesh.triangles
    while True:  # each vertex takes the least label of its triangles, until all agree
        least = label[t].min(axis=1)
        new = label.copy()
        np.minimum.at(new, t.ravel(), np.repeat(least, 3))
        new = new[new]
        if np.array_equal(new, label):
            break
        label = new
    _, sizes = np.unique(label[t[:, 0]], return_counts=True)
    return int((sizes < CRUMB * len(t)).sum())


def loops(rims: npt.NDArray[np.int32]) -> Iterator[list[int]]:
    """Closed ways along the rims (k, 2), against the triangles' turn: the turn of what would fill them."""
    leaving: dict[int, list[int]] = {}
    for a, b in rims.tolist():
        leaving.setdefault(b, []).append(a)
    for start in list(leaving):
        way, place = [start], {start: 0}
        while leaving.get(way[-1]):
            after = leaving[way[-1]].pop()
            if after in place:  # a loop closes; what came before it goes on, as where two holes touch in a vertex
                loop = way[place[after] :]
                yield loop
                for x in loop[1:]:
                    del place[x]
                way = way[: place[after] + 1]
            else:
                place[after] = len(way)
                way.append(after)


def fill(v: Vertices, loop: list[int], edges: set[tuple[int, int]]) -> Triangles | None:
    """Triangles of least area over a closed loop (Barequet and Sharir 1995); no inner edge that is there already."""
    n = len(loop)
    if n < 3:
        return None
    p = v[loop]
    cost, cut = np.zeros((n, n)), np.zeros((n, n), dtype=int)
    taken = np.array([[(min(a, b), max(a, b)) in edges for b in loop] for a in loop])
    for width in range(2, n):
        for i in range(n - width):
            k = i + width
            between = np.arange(i + 1, k)
            area = np.linalg.norm(np.cross(p[between] - p[i], p[k] - p[i]), axis=1)
            total = cost[i, between] + cost[between, k] + area
            cut[i, k] = between[np.argmin(total)]
            cost[i, k] = total.min()
            if taken[i, k] and width < n - 1:
                cost[i, k] = np.inf
    if not np.isfinite(cost[0, n - 1]):
        return None
    out, open_spans = [], [(0, n - 1)]
    while open_spans:
        i, k = open_spans.pop()
        if k - i < 2:
            continue
        j = int(cut[i, k])
        out.append([loop[i], loop[j], loop[k]])
        open_spans += [(i, j), (j, k)]
    return np.array(out, dtype=np.int32)


def _short_edges(v: Vertices, t: Triangles, limit: float) -> Triangles:
    e = t[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return np.asarray(e[np.linalg.norm(v[e[:, 0]] - v[e[:, 1]], axis=1) < limit])


def _merge(v: Vertices, t: Triangles, which: npt.NDArray[np.integer], limit: float) -> tuple[Triangles, int]:
    """Vertices among ``which`` nearer than ``limit`` become one; triangles that lose a corner go."""
    if len(which) == 0:
        return t, 0
    cell = np.floor(v[which] / limit).astype(np.int64)
    lists: dict[tuple[int, ...], list[int]] = {}
    onto = np.arange(len(v), dtype=np.int32)
    steps = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
    moved = 0
    for i, c in zip(which.tolist(), cell.tolist(), strict=True):
        near = [j for s in steps for j in lists.get((c[0] + s[0], c[1] + s[1], c[2] + s[2]), ())]
        close = [j for j in near if np.linalg.norm(v[i] - v[j]) < limit]
        if close:
            onto[i] = close[0]
            moved += 1
        else:
            lists.setdefault(tuple(c), []).append(i)
    t = onto[t]
    return t[(t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0])], moved
