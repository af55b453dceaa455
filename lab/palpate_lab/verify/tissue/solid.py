"""A hyperelastic solid of revolution: quadratic quadrilaterals, with energy, forces and tangent in closed form.

Strain energy per reference volume, with I = J^(-2/3) tr(F'F) and J = det F:

    W = mu/2 [(I - 3) + c (I - 3)^2] + K/2 (J - 1)^2

a Neo-Hookean solid with Yeoh's second term. Nine-node elements with 3 x 3 Gauss points do not lock up to nu = .49.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse

from palpate.base.arrays import Array

_POINT = np.sqrt(0.6)
_COMPONENTS = np.array([0, 1, 3, 4, 8])  # of F as 9 numbers, axes r, z, angle: the others are zero
GAUSS = np.array([-_POINT, 0.0, _POINT]), np.array([5.0, 8.0, 5.0]) / 9.0  #: points and weights on [-1, 1]


@dataclass(frozen=True)
class Solid:
    """Elements of a half section: coordinates (r, z)."""

    nodes: Array  # (n, 2) [m]
    elements: npt.NDArray[np.int64]  # (m, 9), node (i, j) of the element at 3 i + j
    mu: float | Array  # shear modulus, one value or (m, 9), by element and Gauss point [Pa]
    bulk: float | Array  # bulk modulus, likewise [Pa]
    yeoh: float  # c [-]

    def assemble(self, u: Array) -> tuple[float, Array, sparse.csc_matrix]:
        """Energy [J], internal forces (2 n,) [N] and stiffness (2 n, 2 n) [N/m] at displacements (n, 2) [m].

        All three are of the whole ring: the integral over the angle, 2 pi, is included. The energy is infinite if an
        element is inverted.
        """
        shape, slope, weight = self._quadrature()
        where = self.elements
        r = np.einsum("qa,ea->eq", shape, self.nodes[where, 0])
        volume = 2.0 * np.pi * r * weight
        m, size = len(where), 2 * where.shape[1]
        B = _strain_displacement(slope, shape, r)  # (m, q, 5, 18): of the components of F, by displacement
        F = np.zeros((*r.shape, 9))
        F[..., _COMPONENTS] = np.array([1.0, 0, 0, 1, 1]) + (B @ u[where].reshape(m, 1, size, 1))[..., 0]
        W, P, A = energy(F.reshape(*F.shape[:2], 3, 3), self.mu, self.bulk, self.yeoh)
        P, A = P[..., _COMPONENTS], A[..., _COMPONENTS[:, None], _COMPONENTS]
        Bw = (volume[..., None, None] * B).reshape(m, -1, size).swapaxes(1, 2)
        force = Bw @ P.reshape(m, -1, 1)
        stiff = Bw @ (A @ B).reshape(m, -1, size)
        dof = (2 * where[:, :, None] + np.arange(2)).reshape(m, size)
        total = np.bincount(dof.ravel(), force.ravel(), 2 * len(self.nodes)).astype(np.float64)
        rows, columns = np.repeat(dof, size, axis=1).ravel(), np.tile(dof, (1, size)).ravel()
        n = 2 * len(self.nodes)
        return float(np.sum(volume * W)), total, sparse.csc_matrix((stiff.ravel(), (rows, columns)), shape=(n, n))

    def _quadrature(self) -> tuple[Array, Array, Array]:
        """Shape functions (q, 9), their slopes in (r, z) (m, q, 9, 2) [1/m], and weights (m, q) [m^2]."""
        x, w = GAUSS
        N, dN = lagrange(x)
        shape = np.einsum("pi,qj->pqij", N, N).reshape(9, 9)
        local = np.stack(
            [np.einsum("pi,qj->pqij", dN, N).reshape(9, 9), np.einsum("pi,qj->pqij", N, dN).reshape(9, 9)], axis=-1
        )
        jacobian = np.einsum("qad,eac->eqcd", local, self.nodes[self.elements])
        slope = np.einsum("qad,eqdc->eqac", local, np.linalg.inv(jacobian))
        return shape, slope, np.linalg.det(jacobian) * np.outer(w, w).ravel()


def lagrange(x: Array) -> tuple[Array, Array]:
    """Quadratic shape functions of nodes -1, 0, 1 at points (k,), and their slopes, both (k, 3)."""
    N = np.stack([0.5 * x * (x - 1.0), 1.0 - x**2, 0.5 * x * (x + 1.0)], axis=-1)
    dN = np.stack([x - 0.5, -2.0 * x, x + 0.5], axis=-1)
    return N, dN


def energy(F: Array, mu: float | Array, bulk: float | Array, c: float) -> tuple[Array, Array, Array]:
    """Energy density [Pa], first Piola-Kirchhoff stress (..., 9) [Pa] and its derivative in F (..., 9, 9) [Pa].

    The moduli [Pa] are numbers or have the shape (...) of the gradients F (..., 3, 3).
    """
    J = np.linalg.det(F)
    G = np.linalg.inv(F).swapaxes(-1, -2)
    I1 = np.einsum("...ij,...ij", F, F)
    scale = np.abs(J) ** (-2.0 / 3.0)
    x = scale * I1 - 3.0
    W = 0.5 * mu * (x + c * x**2) + 0.5 * bulk * (J - 1.0) ** 2
    first, second = 1.0 + 2.0 * c * x, 2.0 * c
    a, b = scale[..., None, None], I1[..., None, None]
    g = a * (2.0 * F - 2.0 / 3.0 * b * G)
    flat = (*F.shape[:-2], 9)
    f9, g9, G9 = F.reshape(flat), g.reshape(flat), G.reshape(flat)
    swap = np.einsum("...ad,...cb->...abcd", G, G).reshape(*flat, 9)  # dG = -swap dF
    H = -2.0 / 3.0 * _outer(g9, G9) + a * (2.0 * np.eye(9) - 4.0 / 3.0 * _outer(G9, f9) + 2.0 / 3.0 * b * swap)
    m = np.asarray(0.5 * mu)
    P = (m * first)[..., None] * g9 + (bulk * (J - 1.0) * J)[..., None] * G9
    A = m[..., None, None] * (second * _outer(g9, g9) + first[..., None, None] * H)
    A += (bulk * (2.0 * J - 1.0) * J)[..., None, None] * _outer(G9, G9)
    A -= (bulk * (J - 1.0) * J)[..., None, None] * swap
    return np.where(J > 0.0, W, np.inf), P, A


def _outer(a: Array, b: Array) -> Array:
    return a[..., :, None] * b[..., None, :]


def _strain_displacement(slope: Array, shape: Array, r: Array) -> Array:
    """Derivative of the five components of F (m, q, 5, 18) by the displacements of an element's nodes [1/m]."""
    B = np.zeros((*r.shape, 5, 9, 2))
    for d in range(2):
        B[..., 2 * d, :, d], B[..., 2 * d + 1, :, d] = slope[..., 0], slope[..., 1]
    B[..., 4, :, 0] = shape / r[..., None]
    return B.reshape(*r.shape, 5, 18)
