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

from palpate import _core, _guidance, _tissue
from palpate.base.arrays import Array
from palpate.scene.guidance.curve import path as smooth_path

Distance = Callable[[Array], Array]


def up(p: Array) -> Array:
    """The z axis (3,) at any point."""
    return np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Specimen:
    """A geometry with its reference."""

    make: Callable[[], _guidance.Geometry]
    distance: Distance
    solid: bool
    axis: Callable[[Array], Array] = up
    """The z axis (3,) of the geometry's orientation at a point (3,)."""
    classes: tuple[type, ...] = ()
    """Classes of the core that this specimen covers."""
    near: float = 1e-9
    """Accepted difference between the geometry and its reference; a sampled geometry is approximate [m]."""
    wander: float = 0.0
    """Way along the surface by which a corrected goal may differ between two solutions: not zero where the geometry's
    normal is not exactly the gradient of its distance [m]."""

    def attitude(self, p: Array) -> Array:
        """Orientation (3, 3) at a point (3,). The core chooses the rotation about the axis of an axial geometry."""
        if self.axis is up:
            return np.eye(3)
        X = np.eye(4)
        X[:3, 3] = p
        return np.asarray(self._made.query(X[None], np.zeros(1))["attitude"][0])

    @cached_property
    def _made(self) -> _guidance.Geometry:
        return self.make()


WAYPOINTS = 1e-2 * np.array([[-3.0, -1.0, 0.0], [-1.5, 0.5, 0.4], [0.0, 0.8, 0.8], [1.5, 0.2, 0.5], [3.0, -0.8, 0.0]])
APEX, INWARD, OPENING = np.array([0.0, 0.0, -0.02]), np.array([0.0, 0.0, 1.0]), 0.5
A, B = np.array([-0.03, -0.01, 0.0]), np.array([0.03, 0.01, 0.01])
BOX = np.array([0.03, 0.024, 0.02])
HALF = np.array([0.03, 0.02, 0.015])
TUBE, BALL, MARGIN = 0.006, 0.02, 0.005
CLOUD = np.random.default_rng(3).uniform(-0.02, 0.02, (40, 3))


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


def _in_parts(distance: Distance, n: int = 400) -> Distance:
    """A distance function that evaluates n points at a time, so that its arrays stay small."""
    return lambda p: np.concatenate([distance(part) for part in np.array_split(p, -(-len(p) // n))])


def _feet(p: Array) -> Array:
    """Parameters (n,) of the spline's points nearest to p (n, 3): the nearest of 801 samples, refined by Newton."""
    u, points, spline = _curve()
    s = u[np.argmin(((p[:, None] - points) ** 2).sum(axis=2), axis=1)]
    for _ in range(4):
        out, v = spline(s) - p, spline(s, 1)
        s = np.clip(s - (out * v).sum(axis=1) / (v * v + out * spline(s, 2)).sum(axis=1), u[0], u[-1])
    return np.asarray(s)


@_in_parts
def curve(p: Array) -> Array:
    """Distance to the spline through WAYPOINTS."""
    return np.asarray(np.linalg.norm(_curve()[2](_feet(p)) - p, axis=1))


def tangent(p: Array) -> Array:
    """Unit tangent (3,) of the spline at its point nearest to p (3,)."""
    t = _curve()[2](_feet(p[None])[0], 1)
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
    """Distance to the ellipsoid with semi-axes HALF, from the root of its Lagrange multiplier by Newton's method.

    Source: Eberly, Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid. The function is convex and
    falls, so that Newton's method converges from a start below the root.
    """
    a2, y = HALF**2, np.maximum(np.abs(p), 1e-12)
    t = (HALF * y - a2).max(axis=1)
    for _ in range(60):
        parts = (HALF * y / (t[:, None] + a2)) ** 2
        t = t + np.maximum(parts.sum(axis=1) - 1.0, 0.0) / (2.0 * (parts / (t[:, None] + a2)).sum(axis=1))
    q = a2 * y / (t[:, None] + a2)
    return np.asarray(np.sign(((y / HALF) ** 2).sum(axis=1) - 1.0) * np.linalg.norm(y - q, axis=1))


@cache
def _solid_mesh() -> tuple[Array, NDArray[np.int32]]:
    """A closed mesh of 80 facets: an icosahedron, subdivided once, on an ellipsoid."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=1, radius=1.0)
    return np.asarray(mesh.vertices * HALF), np.asarray(mesh.faces, dtype=np.int32)


@_in_parts
def mesh(p: Array) -> Array:
    """Distance to all triangles by brute force; sign from their solid angles (Van Oosterom and Strackee 1983)."""
    vertices, triangles = _solid_mesh()
    corners = vertices[triangles]  # (m, 3, 3)
    a, b, c = (corners[:, k] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    height = _dot(p[:, None] - a, normal)  # (n, m)
    foot = p[:, None] - height[..., None] * normal
    over = np.ones(height.shape, dtype=bool)
    edges = np.full(height.shape, np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        over &= _dot(foot - u, np.cross(normal, v - u)) >= 0.0
        fraction = np.clip(_dot(p[:, None] - u, v - u) / _dot(v - u, v - u), 0.0, 1.0)
        edges = np.minimum(edges, np.linalg.norm(p[:, None] - u - fraction[..., None] * (v - u), axis=2))
    d = np.where(over, np.abs(height), edges).min(axis=1)
    return np.asarray(np.where(_inside(p, a, b, c), -d, d))


def _dot(u: Array, v: Array) -> Array:
    return np.asarray(np.einsum("...i,...i->...", u, v))


def _inside(p: Array, a: Array, b: Array, c: Array) -> NDArray[np.bool_]:
    """True (n,) where the solid angles of all triangles add up to a full sphere."""
    x, y, z = (corner - p[:, None] for corner in (a, b, c))
    r, s, t = (np.linalg.norm(w, axis=2) for w in (x, y, z))
    rest = r * s * t + _dot(x, y) * t + _dot(x, z) * s + _dot(y, z) * r
    return np.asarray(np.abs(2.0 * np.arctan2(_dot(x, np.cross(y, z)), rest).sum(axis=1)) > 2.0 * np.pi)


def cloud(p: Array) -> Array:
    """Distance to balls of 3 mm around every point; inside, it is a lower bound of the true depth."""
    return np.asarray(np.linalg.norm(p[:, None] - CLOUD, axis=2).min(axis=1) - 0.003)


@cache
def _grid() -> _core.DistanceGrid:
    """A distance grid that covers all points of the mean normals; outside its box, distances are underestimated."""
    axis = np.arange(-0.046, 0.0461, 0.001)
    p = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    values = ball(p).reshape(3 * (len(axis),)).astype(np.float32)
    return _core.DistanceGrid(np.full(3, axis[0]), np.full(3, 0.001), values)


def _surface(make: Callable[[], _core.Surface]) -> Callable[[], _guidance.Geometry]:
    return lambda: _guidance.SurfaceGeometry(make())


def _placed_ball(x: float) -> _guidance.Geometry:
    X = np.eye(4)
    X[0, 3] = x
    return _guidance.PlacedGeometry(_guidance.SurfaceGeometry(_core.Sphere(0.015)), X)


def _placed_box(x: float) -> _guidance.Geometry:
    X = np.eye(4)
    X[0, 3] = x
    return _guidance.PlacedGeometry(_guidance.SurfaceGeometry(_core.Box(BOX)), X)


def _combined(kind: str) -> Callable[[], _guidance.Geometry]:
    def make() -> _guidance.Geometry:
        parts = [_placed_ball(-0.008), _placed_ball(0.008)]
        return _guidance.CombinedGeometry(kind, parts)  # type: ignore[arg-type]

    return make


def _two(p: Array) -> tuple[Array, Array]:
    return ball(p, (-0.008, 0.0, 0.0), 0.015), ball(p, (0.008, 0.0, 0.0), 0.015)


def _along(a: Array) -> Callable[[Array], Array]:
    unit = a / np.linalg.norm(a)
    return lambda _: unit


#: Specimens by name; `classes` lists the core's classes that each one covers.
SPECIMENS: dict[str, Specimen] = {
    "point": Specimen(_guidance.PointGeometry, lambda p: np.linalg.norm(p, axis=1), False,
                      classes=(_guidance.PointGeometry,)),
    "line": Specimen(lambda: _guidance.LineGeometry(A, B), lambda p: segment(p, A, B), False, _along(B - A),
                     (_guidance.LineGeometry,)),
    "line without end": Specimen(lambda: _guidance.LineGeometry(A, B, True), infinite_line, False, _along(B - A)),
    "plane": Specimen(_surface(_core.Plane), lambda p: p[:, 2], True, classes=(_guidance.SurfaceGeometry, _core.Plane)),
    "path": Specimen(lambda: smooth_path(WAYPOINTS), curve, False, tangent, (_guidance.PathGeometry,)),
    "tube": Specimen(lambda: _guidance.OffsetGeometry(smooth_path(WAYPOINTS), TUBE), lambda p: curve(p) - TUBE, True,
                     tangent, (_guidance.OffsetGeometry,)),
    "cone": Specimen(lambda: _guidance.ConeGeometry(APEX, INWARD, OPENING), cone, True, _along(-INWARD),
                     (_guidance.ConeGeometry,)),
    "sphere": Specimen(_surface(lambda: _core.Sphere(BALL)), ball, True, classes=(_core.Sphere,)),
    "box": Specimen(_surface(lambda: _core.Box(BOX)), box, True, classes=(_core.Box,)),
    "cylinder": Specimen(_surface(lambda: _core.Cylinder(0.012, 0.04)), cylinder, True, classes=(_core.Cylinder,)),
    "capsule": Specimen(_surface(lambda: _core.Capsule(0.01, 0.03)), capsule, True, classes=(_core.Capsule,)),
    "implicit surface": Specimen(_surface(lambda: _core.ImplicitSurface(HALF**-2.0, (2, 2, 2), 1.0)), ellipsoid, True,
                                 classes=(_core.ImplicitSurface,), near=1e-7),
    "mesh": Specimen(_surface(lambda: _core.Mesh(*_solid_mesh())), mesh, True, classes=(_core.Mesh,), near=1e-8),
    "cloud": Specimen(_surface(lambda: _core.Cloud(CLOUD, 0.003)), cloud, True, classes=(_core.Cloud,), near=1e-8,
                      wander=5e-6),
    "distance grid": Specimen(_surface(_grid), ball, True, classes=(_core.DistanceGrid,), near=2e-5),
    "offset": Specimen(lambda: _guidance.OffsetGeometry(_guidance.SurfaceGeometry(_core.Box(BOX)), MARGIN),
                       lambda p: box(p) - MARGIN, True),
    "union": Specimen(_combined("union"), lambda p: np.minimum(*_two(p)), True, classes=(_guidance.CombinedGeometry,)),
    "intersection": Specimen(_combined("intersection"), lambda p: np.maximum(*_two(p)), True),
    "difference": Specimen(_combined("difference"), lambda p: np.maximum(_two(p)[0], -_two(p)[1]), True),
    "union of boxes": Specimen(lambda: _guidance.CombinedGeometry("union", [_placed_box(-0.01), _placed_box(0.012)]),
                               lambda p: np.minimum(box(p - [-0.01, 0.0, 0.0]), box(p - [0.012, 0.0, 0.0])), True),
    "placed": Specimen(lambda: _placed_ball(0.01), lambda p: ball(p, (0.01, 0.0, 0.0), 0.015), True,
                       classes=(_guidance.PlacedGeometry,)),
}  # fmt: skip


_NO_FIXTURE = {_tissue.PointSurface, _tissue.TissueSurface, _tissue.SharedTissue}
"""Surfaces of the contact stage of which no fixture is made: a fixture around points is `Cloud`, and one at a soft body
takes its mesh at rest."""


def unjudged() -> list[str]:
    """Geometries and surfaces of the core that no specimen covers."""
    covered = _NO_FIXTURE.union(*(specimen.classes for specimen in SPECIMENS.values()))
    known = [cls for cls in (vars(_core) | vars(_tissue)).values() if isinstance(cls, type)]
    of_core = [cls for cls in known if issubclass(cls, (_guidance.Geometry, _core.Surface))]
    return sorted(cls.__name__ for cls in of_core if cls not in covered | {_guidance.Geometry, _core.Surface})
