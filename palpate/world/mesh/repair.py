"""Repair of a mesh without user decisions: cracks are sewn, slivers collapsed or flipped, small holes filled."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.world.mesh.flips import flip

Vertices = npt.NDArray[np.float64]
Triangles = npt.NDArray[np.int32]

CRACK = 0.01
"""Rims closer than this fraction of the median edge length are merged [-]."""
SLIVER = 1e-4
"""Edges shorter than this fraction of the median edge length are collapsed [-]."""
FLAT = 0.04
"""Edges of thin triangles are flipped where the surface moves by less than this fraction of the median edge [-]."""
LONGEST_LOOP = 120
"""Most vertices around a hole that is filled: the computation grows with their third power."""
CRUMB = 0.01
"""Parts with less than this fraction of the triangles count as small [-]."""


@dataclass(frozen=True)
class Repairs:
    """What was repaired, and which holes stay open."""

    sewn: int  #: rim vertices moved onto their neighbours across a crack
    collapsed: int  #: triangles removed by merging vertices (slivers)
    flipped: int  #: edges of thin triangles replaced by the other diagonal
    filled: int  #: holes closed with triangles of least area
    left_open: int  #: holes wider than the limit, or with too many vertices
    widest_left_mm: float  #: width of the widest of them [mm]


def repair(mesh: _core.Mesh, widest_hole: float) -> tuple[Vertices, Triangles, Repairs]:
    """Repair cracks, slivers and small holes. The core has already corrected winding, duplicates and zero areas.

    Args:
        mesh: as loaded.
        widest_hole: holes with a larger bounding-box diagonal stay open [m].

    Returns:
        Vertices (n, 3) [m], triangles (m, 3), and a summary of the repairs.
    """
    v, before = np.array(mesh.vertices), mesh.triangle_count
    edge = float(np.median(np.linalg.norm(v[mesh.triangles[:, 0]] - v[mesh.triangles[:, 1]], axis=1)))
    t, sewn = _merge(v, np.array(mesh.triangles), np.unique(mesh.rims()), CRACK * edge)
    t, _ = _merge(v, t, np.unique(_short_edges(v, t, SLIVER * edge)), SLIVER * edge)
    collapsed = before - len(t)
    mesh = _core.Mesh(v, t)
    v = np.array(mesh.vertices)
    t, flipped = flip(v, np.array(mesh.triangles), FLAT * edge)
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
    return v, t, Repairs(sewn, collapsed, flipped, len(patches), len(left) - 1, max(left))


def small_parts(mesh: _core.Mesh) -> int:
    """Number of parts with less than ``CRUMB`` of the triangles."""
    label = np.arange(len(mesh.vertices))
    t = mesh.triangles
    while True:  # each vertex takes the smallest label of its triangles, until no label changes
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
    """Closed loops of vertices along the rims (k, 2), in the winding of the triangles that would fill them."""
    leaving: dict[int, list[int]] = {}
    for a, b in rims.tolist():
        leaving.setdefault(b, []).append(a)
    for start in list(leaving):
        path, place = [start], {start: 0}
        while leaving.get(path[-1]):
            after = leaving[path[-1]].pop()
            if after in place:  # a loop closes; the path before it continues (two holes share a vertex)
                loop = path[place[after] :]
                yield loop
                for x in loop[1:]:
                    del place[x]
                path = path[: place[after] + 1]
            else:
                place[after] = len(path)
                path.append(after)


def fill(v: Vertices, loop: list[int], edges: set[tuple[int, int]]) -> Triangles | None:
    """Triangles of least area over a closed loop (Barequet and Sharir 1995); None if that needs an existing edge."""
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
    """Merge vertices among ``which`` that are closer than ``limit``; drop triangles that lose a corner."""
    if len(which) == 0:
        return t, 0
    cell = np.floor(v[which] / limit).astype(np.int64)
    lists: dict[tuple[int, ...], list[int]] = {}
    target = np.arange(len(v), dtype=np.int32)
    steps = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
    merged = 0
    for i, c in zip(which.tolist(), cell.tolist(), strict=True):
        near = [j for s in steps for j in lists.get((c[0] + s[0], c[1] + s[1], c[2] + s[2]), ())]
        close = [j for j in near if np.linalg.norm(v[i] - v[j]) < limit]
        if close:
            target[i] = close[0]
            merged += 1
        else:
            lists.setdefault(tuple(c), []).append(i)
    t = target[t]
    return t[(t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 2] != t[:, 0])], merged
