"""Base class of primitives, grids and implicit surfaces."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import SurfaceError

Triangles = npt.NDArray[np.int32]

#: Cells along the longest side when a surface is triangulated for drawing.
DRAWN_CELLS = 60


class Surface(ABC):
    """A surface in its own frame O. Contact uses ``core``; the triangles are for drawing only."""

    name: str  #: name in plots and messages
    core: _core.Surface  #: the C++ surface that contact uses

    @abstractmethod
    def __str__(self) -> str:
        """Kind and size, for messages."""

    @abstractmethod
    def _drawing(self) -> tuple[Array, Triangles]:
        """Vertices (n, 3) [m] and triangles (m, 3) for drawing."""

    def nearest(self, points: npt.ArrayLike) -> tuple[Array, Array, Array]:
        """Nearest surface points to (n, 3) points [m]: signed distance (n,), point (n, 3), outward normal (n, 3)."""
        return self.core.nearest(np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3))

    @cached_property
    def _drawn(self) -> tuple[Array, Triangles]:
        vertices, triangles = self._drawing()
        return np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(triangles, dtype=np.int32)

    @property
    def vertices(self) -> Array:
        """(n, 3) [m], for drawing only."""
        return self._drawn[0]

    @property
    def triangles(self) -> Triangles:
        """(m, 3) indices into ``vertices``, for drawing only."""
        return self._drawn[1]

    def __repr__(self) -> str:
        """Name and kind."""
        return f"<{type(self).__name__} {self.name!r}: {self}>"


def nets(core: _core.Surface, lowest: Array, highest: Array, spacing: float) -> tuple[Array, Triangles]:
    """Triangulate a closed surface inside a box [m], with cells of ``spacing`` [m] or coarser."""
    from palpate.world.shapes.surface_nets import rough

    step = max(spacing, float((highest - lowest).max()) / DRAWN_CELLS)

    def distance(points: Array) -> Array:
        return core.nearest(np.ascontiguousarray(points.reshape(-1, 3)))[0].reshape(points.shape[:-1])

    vertices, triangles = rough(distance, lowest - 2.0 * step, highest + 2.0 * step, step)
    return core.nearest(vertices)[1], triangles


def length(name: str, value: float) -> float:
    """A positive length [m], or a SurfaceError that names it."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = float("nan")
    if not (np.isfinite(number) and number > 0):
        raise SurfaceError(f"{name} must be a positive length in metres, got {value!r}", mend="e.g. 0.03")
    return number


def three(name: str, values: npt.ArrayLike) -> Array:
    """Three finite numbers (3,), or a SurfaceError that names them."""
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise SurfaceError(f"{name} must be three finite numbers, got {values!r}", mend="give one for each axis")
    return array
