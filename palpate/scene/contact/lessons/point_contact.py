"""The paper's section 3.2: two surfaces in contact have collinear normals at the contact point (Eqs 14-17, Fig 6A).

U is at rest; V moves along an oblique path and touches U at one point. The contact point y* of V and its normal psi(y*)
move with V; x* is the point of U nearest to y*. Delta(U, V) = |x* - y*|. The normals become collinear as Delta -> 0:

    |n_U x n_V| -> 0,    n_U . n_V -> -1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.world.surfaces import ImplicitSurface


@dataclass(frozen=True)
class Pair:
    """Both points and outward unit normals (3,), in U's frame."""

    x: Array  #: point on U [m]
    y: Array  #: point on V [m]
    n_U: Array
    n_V: Array
    p_V: Array  #: position of V's centre [m]

    @property
    def gap(self) -> float:
        """Delta(U, V) [m]."""
        return float(np.linalg.norm(self.x - self.y))

    @property
    def cross(self) -> float:
        """|n_U x n_V|, the sine of the angle between the normals' lines."""
        return float(np.linalg.norm(np.cross(self.n_U, self.n_V)))

    @property
    def dot(self) -> float:
        """n_U . n_V; -1 when the surfaces face each other."""
        return float(self.n_U @ self.n_V)


def approach(U: ImplicitSurface, V: ImplicitSurface, touch: npt.ArrayLike, way: npt.ArrayLike, distance: float) -> Pair:
    """The pair of points when V is ``distance`` before contact with U.

    Args:
        U: surface at rest around the origin.
        V: surface that moves without turning.
        touch: (3,) the contact point is the point of U nearest to this one [m].
        way: (3,) direction of V's motion, which must lead into U at the contact point.
        distance: remaining distance along ``way`` [m].

    Raises:
        ValueError: ``way`` does not lead into U.
    """
    _, contact, normal = (rows[0] for rows in U.nearest(np.array([touch], dtype=float)))
    towards = np.asarray(way, dtype=float) / np.linalg.norm(np.asarray(way, dtype=float))
    if not float(towards @ normal) < 0.0:
        raise ValueError(f"way {towards.tolist()} does not lead into U, whose normal is {normal.tolist()} there")
    y_V = _facing(V, -normal)
    y = contact - distance * towards
    _, x, n_U = (rows[0] for rows in U.nearest(y[None]))
    n_V = V.gradient(y_V)
    return Pair(x, y, n_U, n_V / np.linalg.norm(n_V), y - y_V)


def _facing(V: ImplicitSurface, n: Array) -> Array:
    """Point of V whose outward normal is n: sum |x_i/h_i|^m_i = 1, by bisection on the length of the gradient."""
    half, m = V.core.half, np.asarray(V.exponents, dtype=float)

    def point(length: float) -> Array:
        return np.asarray(np.sign(n) * half * (length * half * np.abs(n) / m) ** (1.0 / (m - 1.0)))

    low, high = 0.0, 1.0
    while V.value(point(high)) < 0.0:
        high *= 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if V.value(point(middle)) < 0.0 else (low, middle)
    return point(low)
