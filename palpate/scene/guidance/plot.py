"""Draws fixtures with matplotlib: allowed regions green, forbidden regions red, and the normals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.scene.guidance.sections import Role

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from palpate import _guidance


ALLOWED, FORBIDDEN = "#2a9d5c", "#c8372d"
_VIEW = 0.15  # half the size of the drawn part of an unbounded geometry [m]
_CELLS = 48  # number of cells along the longest side
_ARROWS = 40  # maximum number of drawn normals


def query(geometry: _guidance.Geometry, points: npt.ArrayLike, t: float = 0.0) -> dict[str, npt.NDArray[Any]]:
    """Query the geometry for a tool at points (n, 3) [m], aligned with W: arrays by the names of the core's Query."""
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    X = np.tile(np.eye(4), (len(points), 1, 1))
    X[:, :3, 3] = points
    return geometry.query(X, np.full(len(points), float(t)))


def extent(geometry: _guidance.Geometry) -> Array:
    """Corners (2, 3) of a box around a geometry; of an unbounded geometry, around the part near the origin [m]."""
    rng, middle, half = np.random.default_rng(0), query(geometry, [[0.0, 0.0, 0.0]])["point"][0], _VIEW
    places = query(geometry, middle + rng.uniform(-half, half, (4000, 3)))["point"]
    places = places[(abs(places - middle) <= _VIEW).all(axis=1)]
    places = np.vstack([places, middle])
    return np.stack([places.min(axis=0), places.max(axis=0)])


def drawing(geometry: _guidance.Geometry, level: float = 0.0) -> tuple[Array, npt.NDArray[np.int32]]:
    """Triangles of the level set distance = `level` [m]: vertices (n, 3) in W and indices (m, 3), possibly none."""
    from palpate.world.shapes.surface_nets import rough

    low, high = extent(geometry) + np.array([[-1.0], [1.0]]) * (abs(level) + 1e-3)
    step = float((high - low).max()) / _CELLS

    def distance(points: Array) -> Array:
        """Distance to the part of the geometry inside the box."""
        found = query(geometry, points)["distance"].reshape(points.shape[:-1]) - level
        beyond = np.maximum(low - points, points - high).max(axis=-1)
        return np.asarray(np.maximum(found, beyond))

    vertices, triangles = rough(distance, low - 2.0 * step, high + 2.0 * step, step)
    cut = abs(query(geometry, vertices)["distance"] - level) > 0.7 * step
    return vertices, triangles[~cut[triangles].any(axis=1)]


def curve(geometry: _guidance.Geometry) -> Array:
    """Samples (n, 3) of a point, a line or a path, ordered along the curve [m]."""
    low, high = extent(geometry)
    found = query(geometry, np.random.default_rng(1).uniform(low - 0.02, high + 0.02, (4000, 3)))
    return np.asarray(found["point"][np.argsort(found["along"], kind="stable")])


def plot(geometry: _guidance.Geometry, role: Role, title: str, ax: Axes | None) -> Axes:
    """Draw the geometry of a fixture into 3-D axes, or into new ones when `ax` is None; lengths in millimetres."""
    import matplotlib.pyplot as plt

    axes: Any = plt.figure().add_subplot(projection="3d") if ax is None else ax
    colour = FORBIDDEN if role.name == "forbid" else ALLOWED
    if geometry.solid:
        places = _surface(axes, geometry, 0.0, colour, 0.5)
    else:
        places = curve(geometry)
        axes.plot(*1e3 * places.T, color=colour, lw=2, marker="o" if np.ptp(places) < 1e-9 else None)
    if role.margin > 0.0:
        sign = -1.0 if role.name == "keep-in" else 1.0
        places = _surface(axes, geometry, sign * role.margin, colour, 0.18)
    _normals(axes, geometry, places)
    axes.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]", title=title)
    axes.set_aspect("equal")
    return axes  # type: ignore[no-any-return]  # 3-D axes of matplotlib


def _surface(axes: Any, geometry: _guidance.Geometry, level: float, colour: str, alpha: float) -> Array:
    vertices, triangles = drawing(geometry, level)
    if len(triangles):
        axes.plot_trisurf(*1e3 * vertices.T, triangles=triangles, color=colour, alpha=alpha, lw=0)
    return vertices


def _normals(axes: Any, geometry: _guidance.Geometry, places: Array) -> None:
    if not len(places) or not geometry.solid:
        return
    chosen = places[np.linspace(0, len(places) - 1, min(_ARROWS, len(places))).astype(int)]
    n = query(geometry, chosen)["normal"]
    length = 0.08 * float(np.ptp(1e3 * places, axis=0).max())
    axes.quiver(*1e3 * chosen.T, *length * n.T, color="0.25", lw=0.8)
