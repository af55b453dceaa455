"""Plane, sphere, box, cylinder, capsule: distances in closed form (core/palpate/scene/primitives.hpp)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base.arrays import Array
from palpate.world.surfaces.surface import Surface, Triangles, length, three


class Plane(Surface):
    """The half-space z <= 0; a square of side ``size`` [m] is drawn.

    Raises:
        SurfaceError: the size is not a positive length [m].
    """

    def __init__(self, size: float = 0.2, *, name: str = "plane") -> None:
        self.name, self.size = name, length("size of a plane", size)
        self.core = _core.Plane()

    def __str__(self) -> str:
        """Kind and size, for messages."""
        return "plane without an end"

    def _drawing(self) -> tuple[Array, Triangles]:
        h = 0.5 * self.size
        corners = np.array([[-h, -h, 0.0], [h, -h, 0.0], [h, h, 0.0], [-h, h, 0.0]])
        return corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32)


class Sphere(Surface):
    """A sphere around the origin.

    Raises:
        SurfaceError: the radius is not a positive length [m].
    """

    def __init__(self, radius: float, *, name: str = "sphere") -> None:
        self.name, self.radius = name, length("radius of a sphere", radius)
        self.core = _core.Sphere(self.radius)

    def __str__(self) -> str:
        """Kind and size, for messages."""
        return f"sphere, radius {_mm(self.radius)}"

    def _drawing(self) -> tuple[Array, Triangles]:
        from palpate.world.shapes import analytic

        return analytic.Sphere(self.radius).mesh(5000)


class Box(Surface):
    """A box around the origin with sides (x, y, z) along the axes; its distance is exact at edges and corners.

    Raises:
        SurfaceError: the size is not three positive lengths [m].
    """

    def __init__(self, size: npt.ArrayLike, *, name: str = "box") -> None:
        sides = three("size of a box", size)
        self.name = name
        self.size = (float(length("side of a box", sides[0])), *(length("side of a box", s) for s in sides[1:]))
        self.core = _core.Box(sides)

    def __str__(self) -> str:
        """Kind and size, for messages."""
        return f"box, {' x '.join(f'{1e3 * s:g}' for s in self.size)} mm"

    def _drawing(self) -> tuple[Array, Triangles]:
        from palpate.world.shapes import analytic

        x, y, z = self.size
        return analytic.Box((x, y, z)).mesh(12)


class Cylinder(Surface):
    """A cylinder around the z axis with flat ends, centred at the origin.

    Raises:
        SurfaceError: the radius or the length is not a positive length [m].
    """

    def __init__(self, radius: float, length: float, *, name: str = "cylinder") -> None:
        self.name, self.radius, self.length = name, *_radius_and_length("cylinder", radius, length)
        self.core = _core.Cylinder(self.radius, self.length)

    def __str__(self) -> str:
        """Kind and size, for messages."""
        return f"cylinder, radius {_mm(self.radius)}, length {_mm(self.length)}"

    def _drawing(self) -> tuple[Array, Triangles]:
        import trimesh

        drawn = trimesh.creation.cylinder(self.radius, self.length, sections=64)
        return np.asarray(drawn.vertices), np.asarray(drawn.faces, dtype=np.int32)


class Capsule(Surface):
    """All points within ``radius`` of a segment of ``length`` along the z axis, centred at the origin.

    Raises:
        SurfaceError: the radius or the length is not a positive length [m].
    """

    def __init__(self, radius: float, length: float, *, name: str = "capsule") -> None:
        self.name, self.radius, self.length = name, *_radius_and_length("capsule", radius, length)
        self.core = _core.Capsule(self.radius, self.length)

    def __str__(self) -> str:
        """Kind and size, for messages."""
        return f"capsule, radius {_mm(self.radius)}, length {_mm(self.length)} between its centres"

    def _drawing(self) -> tuple[Array, Triangles]:
        import trimesh

        drawn = trimesh.creation.capsule(self.length, self.radius, count=[64, 64])
        low, high = np.asarray(drawn.bounds)
        return np.asarray(drawn.vertices) - 0.5 * (low + high), np.asarray(drawn.faces, dtype=np.int32)


def _radius_and_length(kind: str, radius: float, extent: float) -> tuple[float, float]:
    return length(f"radius of a {kind}", radius), length(f"length of a {kind}", extent)


def _mm(metres: float) -> str:
    return f"{1e3 * metres:g} mm"
