"""Collision geometry of Coal from the surfaces of Palpate."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.errors import MissingExtraError
from palpate.planning.shapes import Capsule

if TYPE_CHECKING:
    from palpate.world.mesh import Mesh
    from palpate.world.surfaces.surface import Surface

_SPECK = 1e-5  # size of the triangle that stands for a point of a cloud [m]
_PLANE = 10.0  # half of the box that bounds a half-space for culling [m]


def require() -> None:
    """Check that the packages of the extra `planning` are installed.

    Raises:
        MissingExtraError: one of them is missing.
    """
    if any(find_spec(name) is None for name in ("coal", "ompl", "ruckig")):
        raise MissingExtraError("motion planning", "planning")


@dataclass(frozen=True)
class Solid:
    """A geometry of Coal with what the checker must know of it.

    The surface that it stands for lies within `inflation` [m] of the geometry; all distances are reduced by it.
    """

    coal: Any  # coal.CollisionGeometry
    bounds: Array  # (2, 3): box around it in its own frame [m]
    inflation: float = 0.0
    kind: str = "mesh"
    """What is checked: mesh, sphere, box, cylinder, capsule, half-space, cloud, or triangulated."""


def transform(R: Array, p: Array) -> Any:
    """Coal's transform with rotation R (3, 3) and position p (3,) [m]."""
    import coal

    return coal.Transform3s(R, p)


def mesh(vertices: Array, triangles: NDArray[Any], inflation: float = 0.0, kind: str = "mesh") -> Solid:
    """Triangles with their hierarchy of bounding volumes; vertices (v, 3) [m], triangles (t, 3)."""
    import coal

    model = coal.BVHModelOBBRSS()
    model.beginModel(len(triangles), len(vertices))
    model.addVertices(np.ascontiguousarray(vertices, dtype=np.float64))
    model.addTriangles(np.ascontiguousarray(triangles, dtype=np.int64))
    model.endModel()
    bounds = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
    return Solid(model, bounds, inflation, kind)


def cloud(points: Array, spacing: float) -> Solid:
    """Points (n, 3) [m] as small triangles, inflated by their spacing [m]."""
    corners = points[:, None, :] + _SPECK * np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    return mesh(corners.reshape(-1, 3), np.arange(3 * len(points)).reshape(-1, 3), spacing + _SPECK, "cloud")


def capsule(value: Capsule) -> tuple[Solid, Array]:
    """A capsule in Coal and its pose (4, 4): Coal's own capsules lie along z."""
    import coal

    half = 0.5 * value.length
    made = coal.Capsule(value.radius, 2.0 * half) if half > 1e-9 else coal.Sphere(value.radius)
    box = np.array([value.radius, value.radius, value.radius + half])
    return Solid(made, np.stack([-box, box]), kind="capsule"), value.pose()


def primitive(shape: str, size: tuple[float, ...]) -> Solid:
    """A box (x, y, z), or a cylinder, capsule (radius, length of its straight part, along z) or sphere (radius) [m]."""
    import coal

    if shape == "box":
        return Solid(coal.Box(*size), _box(0.5 * np.array(size)), kind="box")
    if shape == "sphere":
        return Solid(coal.Sphere(*size), _box(np.full(3, size[0])), kind="sphere")
    if shape == "cylinder":
        return Solid(coal.Cylinder(*size), _box(np.array([size[0], size[0], 0.5 * size[1]])), kind="cylinder")
    return Solid(coal.Capsule(*size), _box(np.array([size[0], size[0], 0.5 * size[1] + size[0]])), kind="capsule")


def of_surface(surface: Mesh | Surface) -> Solid:
    """The geometry of an object of a scene, in its own frame.

    Meshes are used whole and primitives as they are. A cloud becomes a small triangle at each averaged point, inflated
    by their spacing. Other surfaces are triangulated, inflated by the largest error found on their triangles.
    """
    import coal

    from palpate.world import surfaces
    from palpate.world.mesh import Mesh

    if isinstance(surface, Mesh):
        return mesh(surface.vertices, surface.triangles)
    if isinstance(surface, surfaces.Sphere):
        return primitive("sphere", (surface.radius,))
    if isinstance(surface, surfaces.Box):
        return primitive("box", tuple(surface.size))
    if isinstance(surface, surfaces.Cylinder):
        return primitive("cylinder", (surface.radius, surface.length))
    if isinstance(surface, surfaces.Capsule):
        return primitive("capsule", (surface.radius, surface.length))
    if isinstance(surface, surfaces.Plane):
        bounds = np.array([[-_PLANE, -_PLANE, -_PLANE], [_PLANE, _PLANE, 0.0]])
        return Solid(coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0), bounds, kind="half-space")
    if isinstance(surface, (surfaces.PointSurface, surfaces.LiveCloud)):
        spacing = surface.scales.voxel if isinstance(surface, surfaces.PointSurface) else 0.0
        return mesh(surface.vertices, surface.triangles, spacing, "cloud")
    return mesh(surface.vertices, surface.triangles, _error(surface), "triangulated")


def _box(half: Array) -> Array:
    return np.stack([-half, half])


def _error(surface: Surface) -> float:
    """Largest distance [m] of the surface found at the corners, edges and centres of its triangles."""
    corners = surface.vertices[surface.triangles]
    points = np.concatenate(
        [surface.vertices, corners.mean(axis=1), 0.5 * (corners + np.roll(corners, 1, axis=1)).reshape(-1, 3)]
    )
    return float(np.abs(surface.nearest(points)[0]).max())
