"""The paper's section 3.2: two surfaces that come to touch have collinear normals where they touch (Eqs 14-17, Fig 6A).

U stays; V comes along a slanted way and touches U at one point. V's touching point y* and its normal psi(y*) go with V;
x* is the place of U nearest to y*. Delta(U, V) = |x* - y*|. Away from contact the normals are askew; as Delta -> 0

    |n_U x n_V| -> 0,    n_U . n_V -> -1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.arrays import Array
from palpate.surfaces import ImplicitSurface


@dataclass(frozen=True)
class Pair:
    """Both points and normals (3,), outward, in U's frame."""

    x: Array  #: on U [m]
    y: Array  #: on V [m]
    n_U: Array
    n_V: Array
    p_V: Array  #: where V's centre is [m]

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
    """V, ``distance`` before it touches U.

    Args:
        U: stays around the origin.
        V: keeps its orientation.
        touch: (3,) the place of U nearest to this point is where they will touch [m].
        way: (3,) direction in which V comes; it must lead into U there.
        distance: left on this way [m].

    Raises:
        ValueError: a way that does not lead into U.
    """
    _, place, normal = (rows[0] for rows in U.nearest(np.array([touch], dtype=float)))
    towards = np.asarray(way, dtype=float) / np.linalg.norm(np.asarray(way, dtype=float))
    if not float(towards @ normal) < 0.0:
        raise ValueError(f"way {towards.tolist()} does not lead into U, whose normal is {normal.tolist()} there")
    y_V = _facing(V, -normal)
    y = place - distance * towards
    _, x, n_U = (rows[0] for rows in U.nearest(y[None]))
    n_V = V.gradient(y_V)
    return Pair(x, y, n_U, n_V / np.linalg.norm(n_V), y - y_V)


def _facing(V: ImplicitSurface, n: Array) -> Array:
    """The place of V whose outward normal is n: sum |x_i/h_i|^m_i = 1 with grad along n, by bisection on its length."""
    half, m = V.core.half, np.asarray(V.exponents, dtype=float)

    def at(length: float) -> Array:
        return np.asarray(np.sign(n) * half * (length * half * np.abs(n) / m) ** (1.0 / (m - 1.0)))

    low, high = 0.0, 1.0
    while V.value(at(high)) < 0.0:
        high *= 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if V.value(at(middle)) < 0.0 else (low, middle)
    return at(low)
