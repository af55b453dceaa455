"""Strain of a deformed surface, for its colours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array


class SurfaceStrain:
    """Largest principal Green-Lagrange strain in the plane of each triangle of a surface.

    With D the edges of a triangle at rest in its own plane (2x2) and d the edges now (3x2), F = d D^-1 and
    E = (F^T F - 1) / 2 (Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, section 4.5).

    Args:
        rest: vertices (n, 3) at rest [m].
        triangles: (m, 3).
    """

    def __init__(self, rest: Array, triangles: NDArray[np.int32]) -> None:
        self._triangles = triangles
        a, b, c = (rest[triangles[:, k]] for k in range(3))
        x = (b - a) / np.maximum(np.linalg.norm(b - a, axis=1), 1e-12)[:, None]
        normal = np.cross(b - a, c - a)
        y = np.cross(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-18)[:, None], x)
        D = np.stack([np.stack([(e * x).sum(1), (e * y).sum(1)], axis=1) for e in (b - a, c - a)], axis=2)
        self._D_inverse = np.linalg.pinv(D)  # a triangle without area has no strain

    def of(self, vertices: Array) -> Array:
        """Strain (m,) of each triangle [-]: the eigenvalue of E with the largest magnitude, as a magnitude."""
        a, b, c = (vertices[self._triangles[:, k]] for k in range(3))
        F = np.stack([b - a, c - a], axis=2) @ self._D_inverse
        C = np.swapaxes(F, 1, 2) @ F
        middle = 0.5 * (C[:, 0, 0] + C[:, 1, 1])
        spread = np.hypot(0.5 * (C[:, 0, 0] - C[:, 1, 1]), C[:, 0, 1])
        return np.asarray(0.5 * np.maximum(np.abs(middle + spread - 1.0), np.abs(middle - spread - 1.0)))
