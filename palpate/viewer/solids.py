"""Triangles of primitives, with sharp edges kept, merged so that they are few nodes in the browser."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from palpate.arm.shapes import Visual
from palpate.base.arrays import Array

SIDES = 16
"""Sides of a drawn cylinder: its surface is at most 1.9 % of the radius inside the true one."""
Surface = tuple[Array, NDArray[np.uint32]]
"""Vertices (n, 3) [m] and triangles (m, 3)."""


def box(x: float, y: float, z: float) -> Surface:
    """A box with its centre at the origin; its faces share no vertices, so that they are drawn flat."""
    square = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float)
    turned = [np.roll(square * [1, 1, side], axis, axis=1) for axis in range(3) for side in (1, -1)]
    faces = [[0, 1, 2], [0, 2, 3]], [[0, 2, 1], [0, 3, 2]]
    triangles = [np.array(faces[k % 2]) + 4 * k for k in range(6)]
    return np.concatenate(turned) * [0.5 * x, 0.5 * y, 0.5 * z], np.concatenate(triangles).astype(np.uint32)


def cylinder(radius: float, length: float) -> Surface:
    """A cylinder along z with its centre at the origin; side and ends share no vertices."""
    a, k = 2.0 * np.pi * np.arange(SIDES) / SIDES, np.arange(SIDES)
    low = np.stack([radius * np.cos(a), radius * np.sin(a), np.full(SIDES, -0.5 * length)], axis=1)
    high = low * [1, 1, -1]
    after = (k + 1) % SIDES
    side = [np.stack([k, after, SIDES + k], axis=1), np.stack([after, SIDES + after, SIDES + k], axis=1)]
    fan = k[1:-1]
    bottom = np.stack([np.zeros_like(fan), fan + 1, fan], axis=1) + 2 * SIDES
    top = np.stack([np.zeros_like(fan), fan, fan + 1], axis=1) + 3 * SIDES
    return np.concatenate([low, high, low, high]), np.concatenate([*side, bottom, top]).astype(np.uint32)


def ball(radius: float) -> Surface:
    """A sphere with its centre at the origin, of 320 triangles."""
    from trimesh.creation import icosphere

    made = icosphere(subdivisions=2, radius=radius)
    return np.asarray(made.vertices), np.asarray(made.faces, dtype=np.uint32)


def merged(visuals: Sequence[Visual]) -> tuple[Array, NDArray[np.uint32], NDArray[np.int64]]:
    """One surface of primitives: vertices (n, 3) [m], each in the frame of its link, triangles (m, 3), and the
    number (n,) of the primitive that a vertex belongs to."""
    made: dict[str, Callable[..., Surface]] = {"box": box, "cylinder": cylinder, "sphere": ball}
    vertices, triangles, owner, count = [], [], [], 0
    for k, visual in enumerate(visuals):
        points, faces = made[visual.shape](*visual.size)
        X = visual.X_link_visual
        vertices.append(points @ X[:3, :3].T + X[:3, 3])
        triangles.append(faces + np.uint32(count))
        owner.append(np.full(len(points), k))
        count += len(points)
    return np.concatenate(vertices), np.concatenate(triangles), np.concatenate(owner)
