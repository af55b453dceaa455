"""Surfaces other than meshes: primitives, distance grids, point clouds and the paper's implicit surface.

They are accepted wherever a mesh is: in ``palpate.contact.render(surface=...)``, and by name in scene files.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.base import lazy

if TYPE_CHECKING:
    from palpate.world.surfaces.grid import DistanceGrid
    from palpate.world.surfaces.implicit import ImplicitSurface
    from palpate.world.surfaces.points import LiveCloud, PointSurface
    from palpate.world.surfaces.primitives import Box, Capsule, Cylinder, Plane, Sphere
    from palpate.world.surfaces.surface import Surface

__all__ = [
    "Box",
    "Capsule",
    "Cylinder",
    "DistanceGrid",
    "ImplicitSurface",
    "LiveCloud",
    "Plane",
    "PointSurface",
    "Sphere",
    "Surface",
]

_HOMES = {
    "DistanceGrid": "grid",
    "ImplicitSurface": "implicit",
    "LiveCloud": "points",
    "PointSurface": "points",
    "Box": "primitives",
    "Capsule": "primitives",
    "Cylinder": "primitives",
    "Plane": "primitives",
    "Sphere": "primitives",
    "Surface": "surface",
}

__getattr__ = lazy.names(__name__, _HOMES)
