"""Shape of a surface under the tool's spheres, for drawing only: contact never sees it.

A sphere of radius r that presses a depth h into a flat surface touches it up to the contact radius a, where Hertz's
solution for an elastic half-space has a^2 = r h (K. L. Johnson, Contact Mechanics, 1985, section 4.2). The drawn
surface follows the sphere up to this radius, and leaves it along its tangent with a smooth decay.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array

STEEPEST = 0.9
"""Largest contact radius over the sphere's radius [-]: a deeper sphere sits at the bottom of a funnel."""
_FARTHEST = 12.0  # largest width of the funnel around the contact over the sphere's radius [-]
_ROUNDS = 12  # of bisection; a triangle of a metre then has edges of a quarter of a millimetre
_FINEST = 0.25  # edge length near the contact over the sphere's radius [-]
_GROWTH = 0.5  # increase of the edge length with the distance from the contact [-]
_MARGIN = 0.03  # distance kept from the sphere over its radius [-]: triangles that the funnel stretches cut its corners


@dataclass(frozen=True)
class Press:
    """A sphere that is pressed into a surface; all vectors in the frame O of the object."""

    centre: Array
    """(3,) centre of the sphere [m]."""
    radius: float
    """Radius of the sphere [m]."""
    point: Array
    """(3,) where the proxy touches the surface [m]."""
    normal: Array
    """(3,) outward unit normal of the surface at the point."""

    @property
    def depth(self) -> float:
        """Depth of the sphere's lowest point below the surface [m]."""
        return max(0.0, float((self.point - self.centre) @ self.normal) + self.radius)

    @property
    def reach(self) -> float:
        """Distance from the axis beyond which the surface is not lowered [m]."""
        a, _, decay = _contact(self.depth, self.radius)
        return a + min(3.0 * decay, _FARTHEST * self.radius) + 2.0 * self.radius


def lowering(rho: Array, press: Press) -> Array:
    """Displacement of a flat surface against its normal [m] at distances rho (n,) from the sphere's axis [m]."""
    h, r = press.depth, press.radius
    if h <= 0.0:
        return np.zeros_like(rho)
    a, u_a, decay = _contact(h, r)
    x = np.maximum(rho - a, 0.0)
    window = np.maximum(1.0 - (x / (press.reach - a)) ** 2, 0.0) ** 2
    outside = u_a * (1.0 + x / decay) ** -2 * window
    return np.where(rho < a, h - r + np.sqrt(np.maximum(r**2 - rho**2, 0.0)), outside)


def _contact(h: float, r: float) -> tuple[float, float, float]:
    """Contact radius, displacement there, and length over which it decays: its slope there is the sphere's [m]."""
    a = min(np.sqrt(max(h, 1e-9) * r), STEEPEST * r)
    height = np.sqrt(r**2 - a**2)
    u_a = max(h - (r - height), 1e-9)
    return float(a), float(u_a), float(2.0 * u_a * height / a)


def pressed(vertices: Array, triangles: NDArray[np.int32], press: Press) -> Array:
    """Vertices (n, 3) [m] of a surface under a sphere.

    Vertices are lowered along the normal at the contact, and those that would stay in the sphere are put under it. The
    far side of the object, which faces away, stays where it is.
    """
    n, offset = press.normal, vertices - press.centre
    z = offset @ n
    rho = np.linalg.norm(offset - z[:, None] * n, axis=1)
    facing = np.clip(2.0 * vertex_normals(vertices, triangles) @ n + 1.0, 0.0, 1.0)
    lowered = z - facing * lowering(rho, press)
    kept = press.radius * (1.0 + _MARGIN)
    below = -np.sqrt(np.maximum(kept**2 - rho**2, 0.0))
    lowered = np.where((rho < kept) & (facing > 0.0), np.minimum(lowered, below), lowered)
    return np.asarray(vertices + (lowered - z)[:, None] * n)


def vertex_normals(vertices: Array, triangles: NDArray[np.int32]) -> Array:
    """Unit normals (n, 3) of the vertices: means of their triangles' normals, weighted by area."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    total = np.stack(
        [np.bincount(triangles.ravel(), np.repeat(area[:, k], 3), minlength=len(vertices)) for k in range(3)], axis=1
    )
    return np.asarray(total / np.maximum(np.linalg.norm(total, axis=1), 1e-30)[:, None])


def refined(
    vertices: Array, triangles: NDArray[np.int32], labels: NDArray[np.int64], presses: list[Press]
) -> tuple[Array, NDArray[np.int32], NDArray[np.int64]]:
    """The same surface with edges that are short near the contacts.

    Every edge that is too long is halved in all of its triangles, so that no gaps open. Labels follow their triangles;
    columns of `vertices` beyond the first three, such as colours, are interpolated.
    """
    for _ in range(_ROUNDS):
        ends = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).astype(np.int64)
        keys, index = np.unique(ends @ [len(vertices), 1], return_inverse=True)  # one number per edge: faster than rows
        a, b = vertices[keys // len(vertices)], vertices[keys % len(vertices)]
        long = np.linalg.norm((a - b)[:, :3], axis=1) > _wanted(0.5 * (a + b)[:, :3], presses)
        if not long.any():
            break
        middle = np.where(long, len(vertices) + np.cumsum(long) - 1, -1)[index.reshape(-1, 3)]
        vertices = np.concatenate([vertices, 0.5 * (a + b)[long]])
        triangles, labels = _split(triangles, middle, labels)
    return vertices, triangles, labels


def _wanted(p: Array, presses: list[Press]) -> Array:
    """Largest edge length at points (n, 3) [m]."""
    sizes = []
    for press in presses:
        away = np.linalg.norm(p - press.point, axis=1) - 2.0 * press.radius
        sizes.append(np.maximum(_FINEST * press.radius, _GROWTH * away))
    return np.asarray(np.min(sizes, axis=0))


def _split(
    triangles: NDArray[np.int32], middle: NDArray[np.int64], labels: NDArray[np.int64]
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Triangles after their edges were halved; middle (m, 3): new vertex of each edge, or -1."""
    halved = middle >= 0
    count = halved.sum(axis=1)
    # Each triangle is turned so that its only halved edge, or its only whole one, is the first.
    first = np.argmax(np.where(count[:, None] == 1, halved, ~halved), axis=1)
    turn = (first[:, None] + np.arange(3)) % 3
    corner, mid = np.take_along_axis(triangles, turn, axis=1), np.take_along_axis(middle, turn, axis=1)
    (a, b, c), (ab, bc, ca) = corner.T, mid.T
    pieces = {
        0: [(a, b, c)],
        1: [(a, ab, c), (ab, b, c)],
        2: [(a, b, bc), (a, bc, ca), (ca, bc, c)],
        3: [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)],
    }
    out, names = [], []
    for number, parts in pieces.items():
        chosen = count == number
        for part in parts:
            out.append(np.stack(part, axis=1)[chosen])
            names.append(labels[chosen])
    return np.concatenate(out).astype(np.int32), np.concatenate(names)
