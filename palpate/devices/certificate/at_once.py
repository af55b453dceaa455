"""Objects so close to each other that the tool's tip can touch them at once: their springs add.

The stiffness of touched surfaces in a direction n is n^T (sum K_i n_i n_i^T) n <= sum K_i, as that of fixtures is.
"""

from __future__ import annotations

from collections.abc import Collection
from itertools import combinations

import numpy as np

from palpate.base.arrays import Array
from palpate.scene import placing
from palpate.scene.rig import Rig
from palpate.scene.surface import PlacedSurface

_POINTS = 4000  # points on each surface


def groups(rig: Rig, length: float = 0.0) -> list[tuple[int, ...]]:
    """The largest sets of two and more objects (by index) that are pairwise close enough for the tool to touch both.

    Two objects are close when points spread over one of them come within the diameter of the tip's sphere of the other
    one, plus the strokes of both and the spacing of the points. A tool of several spheres reaches over its ``length``
    [m] instead. Objects that are tracked or sensed can be anywhere.
    """
    scene = rig.scene
    count = len(scene.objects)
    if count < 2:
        return []
    tracked = placing.tracked(scene, placing.graph(scene)) if scene.trackers else {}
    stroke = {i: _stroke(rig, i, tracked) for i in range(count)}
    spread = {i: _points(rig.surfaces[i]) for i in stroke if np.isfinite(stroke[i])}
    close = np.zeros((count, count), dtype=bool)
    for i, j in combinations(range(count), 2):
        slack = max(2.0 * scene.contact.radius, length) + stroke[i] + stroke[j]
        close[i, j] = close[j, i] = np.isinf(slack) or min(
            _gap(spread[i], rig.surfaces[j]), _gap(spread[j], rig.surfaces[i])
        ) < slack  # fmt: skip
    return sorted(clique for clique in _cliques(close, (), set(range(count)), set()) if len(clique) > 1)


def _points(surface: PlacedSurface) -> tuple[Array, float]:
    """Points (n, 3) in W spread over a surface by area, and their spacing [m]."""
    v, t = np.asarray(surface.body.vertices), np.asarray(surface.body.triangles)
    area = 0.5 * np.linalg.norm(np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]), axis=1)
    rng = np.random.default_rng(0)
    chosen = t[rng.choice(len(t), _POINTS, p=area / area.sum())]
    a, b = np.sqrt(rng.random(_POINTS)), rng.random(_POINTS)
    weights = np.stack([1.0 - a, a * (1.0 - b), a * b], axis=1)
    points = np.einsum("nk,nki->ni", weights, v[chosen])
    return points @ surface.X_WO[:3, :3].T + surface.X_WO[:3, 3], float(np.sqrt(area.sum() / _POINTS))


def _gap(spread: tuple[Array, float], surface: PlacedSurface) -> float:
    """A lower bound, nearly always, of the distance of points from a surface [m]; negative where they are inside."""
    points, spacing = spread
    nearest, normal = surface.nearest(points)
    outside = np.einsum("ni,ni->n", points - nearest, normal) >= 0.0
    return float(np.where(outside, np.linalg.norm(points - nearest, axis=1), 0.0).min()) - spacing


def _stroke(rig: Rig, i: int, tracked: Collection[str]) -> float:
    """How far the motions of an object carry its points [m]; infinite where there is no limit."""
    one = rig.scene.objects[i]
    if one.is_sensed or one.name in tracked or any(np.any(m.velocity) or np.any(m.spin_deg) for m in one.motion):
        return float("inf")
    extent = 0.5 * float(np.linalg.norm(np.diff(rig.surfaces[i].bounds, axis=0)))
    return float(sum(np.linalg.norm(m.amplitude) + extent * np.radians(np.linalg.norm(m.turn_deg)) for m in one.motion))


def _cliques(close: Array, chosen: tuple[int, ...], free: set[int], used: set[int]) -> list[tuple[int, ...]]:
    """All sets that cannot grow of pairwise close objects (Bron and Kerbosch, Communications of the ACM 16, 1973)."""
    if not free and not used:
        return [tuple(sorted(chosen))]
    found = []
    for i in sorted(free):
        beside = set(np.flatnonzero(close[i]).tolist())
        found += _cliques(close, (*chosen, i), free & beside, used & beside)
        free, used = free - {i}, used | {i}
    return found
