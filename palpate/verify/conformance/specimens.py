"""A specimen of every geometry with a reference distance in numpy, in closed form or by brute force.

Distance functions map points (n, 3) to signed distances (n,) [m], negative inside a solid. Points and curves have
unsigned distances. All specimens lie around the origin and are a few centimetres in size.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from palpate import _core
from palpate.arrays import Array
from palpate.guidance.curve import path as smooth_path

Distance = Callable[[Array], Array]


def up(p: Array) -> Array:
    """The z axis (3,) at any point."""
    return np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Specimen:
    """A geometry with its reference."""

    make: Callable[[], _core.Geometry]
    distance: Distance
    solid: bool
    axis: Callable[[Array], Array] = up
    """The z axis (3,) of the geometry's orientation at a point (3,)."""
    classes: tuple[type, ...] = ()
    """Classes of the core that this specimen covers."""
    near: float = 1e-9
    """Accepted difference between the geometry and its reference; a sampled geometry is approximate [m]."""

    def attitude(self, p: Array) -> Array:
        """Orientation (3, 3) at a point (3,). The core chooses the rotation about the axis of an axial geometry."""
        if self.axis is up:
            return np.eye(3)
        X = np.eye(4)
        X[:3, 3] = p
        return np.asarray(self._made.query(X[None], np.zeros(1))["attitude"][0])

    @cached_property
    def _made(self) -> _core.Geometry:
        return self.make()


WAYPOINTS = 1e-2 * np.array([[-3.0, -1.0, 0.0], [-1.5, 0.5, 0.4], [0.0, 0.8, 0.8], [1.5, 0.2, 0.5], [3.0, -0.8, 0.0]])
APEX, INWARD, OPENING = np.array([0.0, 0.0, -0.02]), np.array([0.0, 0.0, 1.0]), 0.5
A, B = np.array([-0.03, -0.01, 0.0]), np.array([0.03, 0.01, 0.01])
BOX = np.array([0.03, 0.024, 0.02])
HALF = np.array([0.03, 0.02, 0.015])
TUBE, BALL, MARGIN = 0.006, 0.02, 0.005


def segment(p: Array, a: Array, b: Array) -> Array:
    """Distance to the line segment from a to b."""
    fraction = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.asarray(np.linalg.norm(p - a - fraction[:, None] * (b - a), axis=1))


def infinite_line(p: Array) -> Array:
    """Distance to the infinite line through A and B."""
    u = (B - A) / np.linalg.norm(B - A)
    return np.asarray(np.linalg.norm(np.cross(p - A, u), axis=1))


@cache
def _curve() -> tuple[Array, Array, CubicSpline]:
    knots = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(WAYPOINTS, axis=0), axis=1))]
    spline = CubicSpline(knots, WAYPOINTS, bc_type="natural")
    u = np.linspace(0.0, knots[-1], 801)
    return u, spline(u), spline


def _foot(p: Array) -> float:
    """Parameter of the spline's point nearest to p (3,): the nearest of 801 samples, refined by Newton's method."""
    u, points, spline = _curve()
    s = u[int(np.argmin(((points - p) ** 2).sum(axis=1)))]
    for _ in range(4):
        out, v = spline(s) - p, spline(s, 1)
        s = np.clip(s - (out @ v) / (v @ v + out @ spline(s, 2)), u[0], u[-1])
    return float(s)


def curve(p: Array) -> Array:
    """Distance to the spline through WAYPOINTS."""
    return np.array([np.linalg.norm(_curve()[2](_foot(point)) - point) for point in p])


def tangent(p: Array) -> Array:
    """Unit tangent (3,) of the spline at its point nearest to p (3,)."""
    t = _curve()[2](_foot(p), 1)
    return np.asarray(t / np.linalg.norm(t))


def cone(p: Array) -> Array:
    """Distance to the cone with apex APEX, axis INWARD and half-angle OPENING [rad]."""
    h = (p - APEX) @ INWARD
    rho = np.linalg.norm(p - APEX - h[:, None] * INWARD, axis=1)
    c, s = np.cos(OPENING), np.sin(OPENING)
    return np.asarray(np.where(h * c + rho * s > 0.0, rho * c - h * s, np.hypot(h, rho)))


def box(p: Array, size: Array = BOX) -> Array:
    """Distance to a box around the origin."""
    q = np.abs(p) - 0.5 * size
    return np.asarray(np.linalg.norm(np.maximum(q, 0.0), axis=1) + np.minimum(q.max(axis=1), 0.0))


def cylinder(p: Array, radius: float = 0.012, length: float = 0.04) -> Array:
    """Distance to a cylinder around z with flat ends."""
    q = np.column_stack([np.hypot(p[:, 0], p[:, 1]) - radius, np.abs(p[:, 2]) - 0.5 * length])
    return np.asarray(np.linalg.norm(np.maximum(q, 0.0), axis=1) + np.minimum(q.max(axis=1), 0.0))


def capsule(p: Array, radius: float = 0.01, length: float = 0.03) -> Array:
    """Distance to a cylinder around z with round ends."""
    e = np.array([0.0, 0.0, 0.5 * length])
    return segment(p, -e, e) - radius


def ball(p: Array, centre: tuple[float, float, float] = (0.0, 0.0, 0.0), radius: float = BALL) -> Array:
    """Distance to a ball."""
    return np.asarray(np.linalg.norm(p - np.array(centre), axis=1) - radius)


def ellipsoid(p: Array) -> Array:
    """Distance to the ellipsoid with semi-axes HALF, from the root of its Lagrange multiplier.

    Source: Eberly, Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid.
    """
    return np.array([_ellipsoid(point) for point in p])


def _ellipsoid(p: Array) -> float:
    a2, y = HALF**2, np.maximum(np.abs(p), 1e-12)

    def over(t: float) -> float:
        return float(((HALF * y / (t + a2)) ** 2).sum() - 1.0)

    least = float((HALF * y - a2).max())  # over() is not below zero there
    most = float(np.linalg.norm(HALF * y))
    t = brentq(over, least + 1e-15, most + 1e-9, xtol=1e-16, rtol=1e-14)
    q = a2 * y / (t + a2)
    return float(np.sign(over(0.0)) * np.linalg.norm(y - q))


@cache
def _solid_mesh() -> tuple[Array, NDArray[np.int32]]:
    """A closed mesh of 80 facets: an icosahedron, subdivided once, on an ellipsoid."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=1, radius=1.0)
    return np.asarray(mesh.vertices * HALF), np.asarray(mesh.faces, dtype=np.int32)


def mesh(p: Array) -> Array:
    """Distance to all triangles by brute force; sign from their solid angles (Van Oosterom and Strackee 1983)."""
    vertices, triangles = _solid_mesh()
    corners = vertices[triangles]  # (m, 3, 3)
    return np.array([_to_mesh(point, corners) for point in p])


def _to_mesh(p: Array, corners: Array) -> float:
    a, b, c = (corners[:, k] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = np.einsum("ij,ij->i", normal, p - a)
    foot = p - height[:, None] * normal
    over = np.ones(len(corners), dtype=bool)
    edges = np.full(len(corners), np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        over &= np.einsum("ij,ij->i", np.cross(v - u, foot - u), normal) >= 0.0
        fraction = np.clip(np.einsum("ij,ij->i", p - u, v - u) / np.einsum("ij,ij->i", v - u, v - u), 0.0, 1.0)
        edges = np.minimum(edges, np.linalg.norm(p - u - fraction[:, None] * (v - u), axis=1))
    d = float(np.where(over, np.abs(height), edges).min())
    x, y, z = a - p, b - p, c - p
    n = [np.linalg.norm(w, axis=1) for w in (x, y, z)]
    det = np.einsum("ij,ij->i", x, np.cross(y, z))
    rest = (
        n[0] * n[1] * n[2]
        + np.einsum("ij,ij->i", x, y) * n[2]
        + np.einsum("ij,ij->i", x, z) * n[1]
        + np.einsum("ij,ij->i", y, z) * n[0]
    )
    inside = abs(2.0 * np.arctan2(det, rest).sum()) > 2.0 * np.pi
    return -d if inside else d


@cache
def _cloud() -> Array:
    return np.random.default_rng(3).uniform(-0.02, 0.02, (40, 3))


def cloud(p: Array) -> Array:
    """Distance to balls of 3 mm around every point; inside, it is a lower bound of the true depth."""
    return np.asarray(np.linalg.norm(p[:, None] - _cloud(), axis=2).min(axis=1) - 0.003)


@cache
def _grid() -> _core.DistanceGrid:
    """A distance grid that covers all points of the mean normals; outside its box, distances are underestimated."""
    axis = np.arange(-0.046, 0.0461, 0.001)
    p = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    values = ball(p).reshape(3 * (len(axis),)).astype(np.float32)
    return _core.DistanceGrid(np.full(3, axis[0]), np.full(3, 0.001), values)


def _surface(make: Callable[[], _core.Surface]) -> Callable[[], _core.Geometry]:
    return lambda: _core.SurfaceGeometry(make())


def _placed_ball(x: float) -> _core.Geometry:
    X = np.eye(4)
    X[0, 3] = x
    return _core.PlacedGeometry(_core.SurfaceGeometry(_core.Sphere(0.015)), X)


def _combined(kind: str) -> Callable[[], _core.Geometry]:
    def make() -> _core.Geometry:
        parts = [_placed_ball(-0.008), _placed_ball(0.008)]
        return _core.CombinedGeometry(kind, parts)  # type: ignore[arg-type]

    return make


def _two(p: Array) -> tuple[Array, Array]:
    return ball(p, (-0.008, 0.0, 0.0), 0.015), ball(p, (0.008, 0.0, 0.0), 0.015)


def _along(a: Array) -> Callable[[Array], Array]:
    unit = a / np.linalg.norm(a)
    return lambda _: unit


#: Specimens by name; `classes` lists the core's classes that each one covers.
SPECIMENS: dict[str, Specimen] = {
    "point": Specimen(_core.PointGeometry, lambda p: np.linalg.norm(p, axis=1), False, classes=(_core.PointGeometry,)),
    "line": Specimen(lambda: _core.LineGeometry(A, B), lambda p: segment(p, A, B), False, _along(B - A),
                     (_core.LineGeometry,)),
    "line without end": Specimen(lambda: _core.LineGeometry(A, B, True), infinite_line, False, _along(B - A)),
    "plane": Specimen(_surface(_core.Plane), lambda p: p[:, 2], True, classes=(_core.SurfaceGeometry, _core.Plane)),
    "path": Specimen(lambda: smooth_path(WAYPOINTS), curve, False, tangent, (_core.PathGeometry,)),
    "tube": Specimen(lambda: _core.OffsetGeometry(smooth_path(WAYPOINTS), TUBE), lambda p: curve(p) - TUBE, True,
                     tangent, (_core.OffsetGeometry,)),
    "cone": Specimen(lambda: _core.ConeGeometry(APEX, INWARD, OPENING), cone, True, _along(-INWARD),
                     (_core.ConeGeometry,)),
    "sphere": Specimen(_surface(lambda: _core.Sphere(BALL)), ball, True, classes=(_core.Sphere,)),
    "box": Specimen(_surface(lambda: _core.Box(BOX)), box, True, classes=(_core.Box,)),
    "cylinder": Specimen(_surface(lambda: _core.Cylinder(0.012, 0.04)), cylinder, True, classes=(_core.Cylinder,)),
    "capsule": Specimen(_surface(lambda: _core.Capsule(0.01, 0.03)), capsule, True, classes=(_core.Capsule,)),
    "implicit surface": Specimen(_surface(lambda: _core.ImplicitSurface(HALF**-2.0, (2, 2, 2), 1.0)), ellipsoid, True,
                                 classes=(_core.ImplicitSurface,), near=1e-7),
    "mesh": Specimen(_surface(lambda: _core.Mesh(*_solid_mesh())), mesh, True, classes=(_core.Mesh,), near=1e-8),
    "cloud": Specimen(_surface(lambda: _core.Cloud(_cloud(), 0.003)), cloud, True, classes=(_core.Cloud,), near=1e-8),
    "distance grid": Specimen(_surface(_grid), ball, True, classes=(_core.DistanceGrid,), near=2e-5),
    "offset": Specimen(lambda: _core.OffsetGeometry(_core.SurfaceGeometry(_core.Box(BOX)), MARGIN),
                       lambda p: box(p) - MARGIN, True),
    "union": Specimen(_combined("union"), lambda p: np.minimum(*_two(p)), True, classes=(_core.CombinedGeometry,)),
    "intersection": Specimen(_combined("intersection"), lambda p: np.maximum(*_two(p)), True),
    "difference": Specimen(_combined("difference"), lambda p: np.maximum(_two(p)[0], -_two(p)[1]), True),
    "placed": Specimen(lambda: _placed_ball(0.01), lambda p: ball(p, (0.01, 0.0, 0.0), 0.015), True,
                       classes=(_core.PlacedGeometry,)),
}  # fmt: skip


def unjudged() -> list[str]:
    """Geometries and surfaces of the core that no specimen covers."""
    covered = {cls for specimen in SPECIMENS.values() for cls in specimen.classes}
    known = [cls for cls in vars(_core).values() if isinstance(cls, type)]
    of_core = [cls for cls in known if issubclass(cls, (_core.Geometry, _core.Surface))]
    return sorted(cls.__name__ for cls in of_core if cls not in covered | {_core.Geometry, _core.Surface})
