"""A duodenum-like closed tube: the letter C around the head of the pancreas."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.world.shapes.surface_nets import Triangles, Vertices

#: Centre line [mm]: bulb, descending, horizontal and ascending part; x to the patient's left, y to the head.
_CENTRES = np.array([[14.0, 34.0, 8.0], [-6.0, 34.0, 4.0], [-24.0, 22.0, -2.0], [-27.0, -4.0, -5.0],
                     [-20.0, -27.0, -6.0], [2.0, -33.0, -4.0], [22.0, -26.0, 0.0], [30.0, -8.0, 4.0]])  # fmt: skip
_RADIUS, _FOLD, _FOLDS = 12.5, 0.7, 26  # of the wall, and the height and number of its folds [mm, mm, -]


def duodenum(triangles: int = 8000, seed: int = 0) -> tuple[Vertices, Triangles]:
    """A C-shaped tube, about 85 mm wide, with circular folds and closed ends; arguments and result as in `organ`."""
    if triangles < 2000:
        raise ValueError(f"triangles = {triangles}: the tube needs at least 2000 for its folds")
    around = max(24, int(np.sqrt(triangles / 6.0)))
    rings = triangles // (2 * around)
    centre, R = _centre_line(np.linspace(0.0, 1.0, rings))
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi)
    s = np.linspace(0.0, 1.0, rings)
    ends = np.sqrt(np.clip(1.0 - (2.0 * np.abs(s - 0.5)) ** 24, 0.0, 1.0))  # round off both ends
    radius = (_RADIUS + _FOLD * np.sin(2.0 * np.pi * _FOLDS * s + phase)) * np.maximum(ends, 0.02)
    angle = 2.0 * np.pi * np.arange(around) / around
    circle = np.cos(angle)[:, None] * R[:, None, :, 0] + np.sin(angle)[:, None] * R[:, None, :, 1]
    vertices = (centre[:, None] + radius[:, None, None] * circle).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(rings - 1), np.arange(around), indexing="ij")
    a, b = i * around + j, i * around + (j + 1) % around
    sides = np.stack([a, b, b + around, a, b + around, a + around], axis=-1).reshape(-1, 3)
    first, last = len(vertices), len(vertices) + 1
    j0, j1, top = np.arange(around), (np.arange(around) + 1) % around, (rings - 1) * around
    caps = np.concatenate([np.stack([np.full(around, first), j1, j0], axis=1),
                           np.stack([np.full(around, last), top + j0, top + j1], axis=1)])  # fmt: skip
    vertices = 1e-3 * np.vstack([vertices, centre[:1], centre[-1:]])
    faces = np.concatenate([sides, caps]).astype(np.int32)
    return vertices - 0.5 * (vertices.min(axis=0) + vertices.max(axis=0)), faces


def _centre_line(s: Array) -> tuple[Array, Array]:
    """Points (k, 3) [mm] of the centre line, and frames (k, 3, 3) with z along it and little twist."""
    from scipy.interpolate import CubicSpline

    knots = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(_CENTRES, axis=0), axis=1))]
    spline = CubicSpline(knots / knots[-1], _CENTRES)
    z = spline(s, 1)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    x = np.cross([0.0, 0.0, 1.0], z)  # the centre line is nearly horizontal
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return spline(s), np.stack([x, np.cross(z, x), z], axis=-1)
