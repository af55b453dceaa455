"""Surfaces that are no meshes: primitives, signed distance grids, the paper's implicit surface. Exact, nothing to weld.

Accepted wherever a mesh is: ``palpate.contact.render(surface=...)``, and by name in scene files.
"""

from palpate.surfaces.grid import DistanceGrid
from palpate.surfaces.implicit import ImplicitSurface
from palpate.surfaces.primitives import Box, Capsule, Cylinder, Plane, Sphere
from palpate.surfaces.surface import Surface

__all__ = ["Box", "Capsule", "Cylinder", "DistanceGrid", "ImplicitSurface", "Plane", "Sphere", "Surface"]
