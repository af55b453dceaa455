"""Shapes in closed form: tessellations of about n triangles, and the exact signed distance as their reference.

Metres. Distances are negative inside; normals point out. Dimensions are those of the contact benchmark.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array

Triangles = NDArray[np.int32]

MM = 1e-3


class Shape(ABC):
    """A surface in closed form: ``mesh`` approximates it, ``distance`` is exact, ``curve`` is a sliding path."""

    name: ClassVar[str]

    @abstractmethod
    def mesh(self, triangles: int) -> tuple[Array, Triangles]:
        """About ``triangles`` triangles: vertices (n, 3) [m], triangles (m, 3), counter-clockwise from outside."""

    @abstractmethod
    def distance(self, points: Array) -> tuple[Array, Array]:
        """Signed distance (n,) [m] and its gradient, the outward unit normal (n, 3), at points (n, 3) [m]."""

    def held(self, points: Array, radius: float) -> tuple[Array, Array]:
        """Deflection (n,) [m] and direction (n, 3) of a sphere held outside the surface, for tool positions ``points``.

        The deflection is r - phi along the normal if the sphere touches one point; concave shapes override this.
        """
        phi, normal = self.distance(points)
        return np.maximum(radius - phi, 0.0), normal

    @abstractmethod
    def curve(self, s: Array, offset: float) -> Array:
        """Points (n, 3) [m] at signed distance ``offset`` along a closed path, s (n,) in turns."""


class Sphere(Shape):
    """Geodesic sphere around the origin."""

    name = "sphere"

    def __init__(self, radius: float = 30 * MM) -> None:
        self.radius = radius

    def mesh(self, triangles: int) -> tuple[Array, Triangles]:
        """Geodesic tessellation: a subdivided icosahedron, projected onto the sphere."""
        vertices, faces = _icosahedron(max(1, round((triangles / 20) ** 0.5)))
        return vertices * self.radius, faces

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Distance from the centre minus the radius."""
        length = np.linalg.norm(points, axis=1)
        return length - self.radius, points / np.where(length > 0, length, 1.0)[:, None]

    def curve(self, s: Array, offset: float) -> Array:
        """A tilted path around the sphere whose latitude oscillates."""
        longitude, latitude = 2 * np.pi * s, 0.6 * np.sin(2 * np.pi * s / 3 + 0.3)
        direction = np.stack(
            [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], axis=1
        )
        return (self.radius + offset) * direction @ _TILT.T


class Torus(Shape):
    """Torus around the z axis."""

    name = "torus"

    def __init__(self, major: float = 40 * MM, minor: float = 15 * MM) -> None:
        self.major, self.minor = major, minor

    def mesh(self, triangles: int) -> tuple[Array, Triangles]:
        """A grid of near-square cells."""
        n_minor = max(3, round((triangles / 2 * self.minor / self.major) ** 0.5))
        n_major = max(3, round(triangles / 2 / n_minor))
        u, v = np.meshgrid(np.arange(n_major), np.arange(n_minor), indexing="ij")
        points = self._points(2 * np.pi * u.ravel() / n_major, 2 * np.pi * v.ravel() / n_minor, 0.0)
        return points, _grid(n_major, n_minor, wrap=True)

    def _points(self, u: Array, v: Array, offset: float) -> Array:
        ring = self.major + (self.minor + offset) * np.cos(v)
        return np.stack([ring * np.cos(u), ring * np.sin(u), (self.minor + offset) * np.sin(v)], axis=1)

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Distance from the centre line of the tube minus its radius."""
        ring = np.hypot(points[:, 0], points[:, 1])
        outward = points[:, :2] / np.where(ring > 0, ring, 1.0)[:, None]
        from_circle = np.column_stack([outward * (ring - self.major)[:, None], points[:, 2]])
        length = np.linalg.norm(from_circle, axis=1)
        return length - self.minor, from_circle / np.where(length > 0, length, 1.0)[:, None]

    def curve(self, s: Array, offset: float) -> Array:
        """A helix on the tube: five turns around the tube per turn around the axis."""
        return self._points(2 * np.pi * (s / 5 + 0.013), 2 * np.pi * s + 0.4, offset)


class Box(Shape):
    """Closed box around the origin."""

    name = "box"

    def __init__(self, size: tuple[float, float, float] = (40 * MM, 40 * MM, 40 * MM)) -> None:
        self.half = np.array(size) / 2

    def mesh(self, triangles: int) -> tuple[Array, Triangles]:
        """Six grids that meet at the edges, with coincident but separate vertices there."""
        x, y, z = 2 * self.half
        step = (2 * (2 * (x * y + y * z + z * x)) / triangles) ** 0.5
        counts = np.maximum(1, np.round(2 * self.half / step).astype(int))
        parts = [self._face(axis, sign, counts) for axis in range(3) for sign in (-1.0, 1.0)]
        starts = np.cumsum([0] + [len(p) for p, _ in parts])
        faces = np.concatenate([f + start for (_, f), start in zip(parts, starts, strict=False)])
        return np.concatenate([p for p, _ in parts]), faces.astype(np.int32)

    def _face(self, axis: int, sign: float, counts: NDArray[np.int_]) -> tuple[Array, Triangles]:
        i, j = (axis + 1) % 3, (axis + 2) % 3
        a = np.linspace(-self.half[i], self.half[i], counts[i] + 1)
        b = np.linspace(-self.half[j], self.half[j], counts[j] + 1)
        points = np.zeros((len(a) * len(b), 3))
        points[:, i], points[:, j] = np.repeat(a, len(b)), np.tile(b, len(a))
        points[:, axis] = sign * self.half[axis]
        faces = _grid(len(a), len(b))
        return points, faces if sign > 0 else faces[:, ::-1].copy()

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Outside: distance to faces, edges and corners; inside: to the nearest face."""
        q = np.abs(points) - self.half
        outside = np.maximum(q, 0.0)
        length = np.linalg.norm(outside, axis=1)
        inside = np.zeros_like(points)
        inside[np.arange(len(points)), q.argmax(axis=1)] = 1.0
        beyond = length > 0
        normal = np.where(beyond[:, None], outside / np.where(beyond, length, 1.0)[:, None], inside)
        return np.where(beyond, length, q.max(axis=1)), normal * np.where(points < 0, -1.0, 1.0)

    def curve(self, s: Array, offset: float) -> Array:
        """For a negative offset a loop over one face, otherwise a path around four edges."""
        if offset < 0:
            r = 0.6 * min(self.half[0], self.half[1])
            x, y = r * np.cos(2 * np.pi * s), 0.9 * r * np.sin(2 * np.pi * s)
            return np.stack([x, y, np.full_like(s, self.half[2] + offset)], axis=1)
        hx, hz, arc = self.half[0], self.half[2], np.pi / 2 * offset
        # The path starts at the centre of the top face and continues over +x, the bottom and -x back to the top.
        legs = np.array([hx, arc, 2 * hz, arc, 2 * hx, arc, 2 * hz, arc, hx])
        ends = np.concatenate([[0.0], np.cumsum(legs)])
        path = (s % 1.0) * ends[-1]
        leg = np.clip(np.searchsorted(ends, path, side="right") - 1, 0, 8)
        turn, into = (leg + 1) // 2, path - ends[leg]  # quarter turns begun before or in this leg
        bent = leg % 2 == 1
        angle = np.pi / 2 * (turn - bent) + np.where(bent, into / (offset if offset > 0 else 1.0), 0.0)
        corners = np.array([[hx, hz], [hx, -hz], [-hx, -hz], [-hx, hz]])
        n = np.stack([np.sin(angle), np.cos(angle)], axis=1)
        along = np.stack([np.cos(angle), -np.sin(angle)], axis=1)
        start = np.where((leg == 0)[:, None], [[0.0, hz]], corners[(turn - 1) % 4])
        xz = start + offset * n + np.where(bent, 0.0, into)[:, None] * along
        return np.stack([xz[:, 0], np.full_like(s, 0.083 * self.half[1]), xz[:, 1]], axis=1)


class Plate(Box):
    """A thin closed plate, 60 x 60 x 1 mm."""

    name = "plate"

    def __init__(self, size: tuple[float, float, float] = (60 * MM, 60 * MM, 1 * MM)) -> None:
        super().__init__(size)


class WavySheet(Shape):
    """Open sheet z = a sin(kx) cos(ky); the outside is above."""

    name = "wavy"

    def __init__(self, amplitude: float = 3 * MM, wavelength: float = 40 * MM, side: float = 100 * MM) -> None:
        self.amplitude, self.k, self.side = amplitude, 2 * np.pi / wavelength, side

    def _height(self, x: Array, y: Array) -> Array:
        return np.asarray(self.amplitude * np.sin(self.k * x) * np.cos(self.k * y))

    def _slope(self, x: Array, y: Array) -> tuple[Array, Array]:
        a, k = self.amplitude * self.k, self.k
        return a * np.cos(k * x) * np.cos(k * y), -a * np.sin(k * x) * np.sin(k * y)

    def mesh(self, triangles: int) -> tuple[Array, Triangles]:
        """A square grid."""
        n = max(1, round((triangles / 2) ** 0.5)) + 1
        x, y = (c.ravel() for c in np.meshgrid(*[np.linspace(-self.side / 2, self.side / 2, n)] * 2, indexing="ij"))
        return np.stack([x, y, self._height(x, y)], axis=1), _grid(n, n)

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Distance by Gauss-Newton iteration on the foot of the perpendicular, to the unbounded sheet."""
        x, y = points[:, 0].copy(), points[:, 1].copy()
        for _ in range(60):  # converges for points closer than the radius of curvature
            zx, zy = self._slope(x, y)
            dx, dy, dz = points[:, 0] - x, points[:, 1] - y, points[:, 2] - self._height(x, y)
            rx, ry = dx + dz * zx, dy + dz * zy
            a, b, c = 1 + zx * zx, zx * zy, 1 + zy * zy
            det = a * c - b * b
            x += (c * rx - b * ry) / det
            y += (a * ry - b * rx) / det
        normal = self._normal(x, y)
        foot = np.stack([x, y, self._height(x, y)], axis=1)
        return np.einsum("ij,ij->i", points - foot, normal), normal

    def _normal(self, x: Array, y: Array) -> Array:
        zx, zy = self._slope(x, y)
        n = np.stack([-zx, -zy, np.ones_like(zx)], axis=1)
        return np.asarray(n / np.linalg.norm(n, axis=1, keepdims=True))

    def curve(self, s: Array, offset: float) -> Array:
        """An ellipse seen from above."""
        x = 0.36 * self.side * np.cos(2 * np.pi * s + 0.1)
        y = 0.31 * self.side * np.sin(2 * np.pi * s + 0.1)
        return np.stack([x, y, self._height(x, y)], axis=1) + offset * self._normal(x, y)


class Groove(Shape):
    """Open groove z = |x| with a concave right angle; the outside is above."""

    name = "groove"

    def __init__(self, side: float = 100 * MM) -> None:
        self.side = side

    def mesh(self, triangles: int) -> tuple[Array, Triangles]:
        """A grid with a line of vertices along the edge."""
        n = max(1, round((triangles / 4) ** 0.5))
        x, y = np.linspace(-self.side / 2, self.side / 2, 2 * n + 1), np.linspace(-self.side / 2, self.side / 2, n + 1)
        x[n] = 0.0
        xs, ys = np.repeat(x, len(y)), np.tile(y, len(x))
        return np.stack([xs, ys, np.abs(xs)], axis=1), _grid(len(x), len(y))

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Distance to the nearer half-plane, or to the edge for points below the edge."""
        side = np.where(points[:, 0] < 0, -1.0, 1.0)
        x, z = np.abs(points[:, 0]), points[:, 2]
        along, height = (x + z) / 2**0.5, (z - x) / 2**0.5  # coordinates along and above the nearer half-plane
        zero = np.zeros_like(x)
        edge = -np.stack([points[:, 0], zero, z], axis=1)  # from the point to the edge
        length = np.linalg.norm(edge, axis=1)
        plane = np.stack([-side, zero, np.ones_like(x)], axis=1) / 2**0.5
        on_edge = (along < 0) & (height < 0)
        normal = np.where(on_edge[:, None], edge / np.where(length > 0, length, 1.0)[:, None], plane)
        return np.where(on_edge, -length, height), normal

    def held(self, points: Array, radius: float) -> tuple[Array, Array]:
        """Sum of the deflections by the two walls, which are independent because they are perpendicular."""
        walls = np.array([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0]]) / 2**0.5
        delta = np.maximum(radius - points @ walls.T, 0.0) @ walls
        length = np.linalg.norm(delta, axis=1)
        direction = np.where(length[:, None] > 0, delta / np.where(length > 0, length, 1.0)[:, None], walls[0])
        return length, direction

    def curve(self, s: Array, offset: float) -> Array:
        """An ellipse seen from above, which crosses the edge twice per turn."""
        x = 0.3 * self.side * np.cos(2 * np.pi * s)
        y = 0.25 * self.side * np.sin(2 * np.pi * s)
        side = np.where(x < 0, -1.0, 1.0)
        return np.stack([x - side * offset / 2**0.5, y, np.abs(x) + offset / 2**0.5], axis=1)


SHAPES: dict[str, Shape] = {s.name: s for s in (Sphere(), Torus(), Box(), WavySheet(), Plate(), Groove())}


def _rotation(x: float, z: float) -> Array:
    cx, sx, cz, sz = np.cos(x), np.sin(x), np.cos(z), np.sin(z)
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return np.asarray(about_z @ np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]]))


_TILT = _rotation(0.7, 0.4)  # keeps paths from following the edges of the tessellation


def _grid(n: int, m: int, wrap: bool = False) -> Triangles:
    """Two triangles for each cell of a grid of n x m points (row-major), with alternating diagonals."""
    cells = np.meshgrid(np.arange(n if wrap else n - 1), np.arange(m if wrap else m - 1), indexing="ij")
    i, j = (c.ravel() for c in cells)
    a, b = i * m + j, (i + 1) % n * m + j
    c, d = (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    even = ((i + j) % 2 == 0)[:, None]
    first = np.where(even, np.stack([a, b, c], axis=1), np.stack([a, b, d], axis=1))
    second = np.where(even, np.stack([a, c, d], axis=1), np.stack([b, c, d], axis=1))
    return np.stack([first, second], axis=1).reshape(-1, 3).astype(np.int32)


def _icosahedron(frequency: int) -> tuple[Array, Triangles]:
    """Unit icosahedron with each face subdivided into frequency^2 triangles and projected onto the sphere."""
    g = (1 + 5**0.5) / 2
    corners = np.array([(0, y, z) for y in (-1, 1) for z in (-g, g)])
    corners = np.concatenate([np.roll(corners, k, axis=1) for k in range(3)]) / (1 + g * g) ** 0.5
    near = corners @ corners.T > 0.4  # 1/sqrt(5) for neighbours, 1 for the corner itself
    triples = [
        (i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] and near[j, k] and near[k, i]
    ]
    faces = np.array([t if np.linalg.det(corners[list(t)]) > 0 else t[::-1] for t in triples])
    i, j = (c.ravel() for c in np.meshgrid(np.arange(frequency + 1), np.arange(frequency + 1), indexing="ij"))
    i, j = i[i + j <= frequency], j[i + j <= frequency]
    row = np.full((frequency + 2, frequency + 2), -1)
    row[i, j] = np.arange(len(i))
    up = i + j < frequency
    down = i + j < frequency - 1
    cells = np.concatenate(
        [
            np.stack([row[i, j], row[i + 1, j], row[i, j + 1]], axis=1)[up],
            np.stack([row[i + 1, j], row[i + 1, j + 1], row[i, j + 1]], axis=1)[down],
        ]
    )
    a, b, c = (corners[faces[:, k]][:, None, :] for k in range(3))
    k = frequency - i - j
    points = (k[:, None] * a + i[:, None] * b + j[:, None] * c).reshape(-1, 3)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    triangles = (cells[None] + (np.arange(20) * len(i))[:, None, None]).reshape(-1, 3)
    return _weld(points, triangles)


def _weld(points: Array, triangles: NDArray[np.int_]) -> tuple[Array, Triangles]:
    """Merge vertices that neighbouring faces share, which differ by rounding only."""
    key = np.round(points * 2**40).astype(np.int64)
    _, first, inverse = np.unique(key, axis=0, return_index=True, return_inverse=True)
    return points[first], inverse.reshape(-1)[triangles].astype(np.int32)
