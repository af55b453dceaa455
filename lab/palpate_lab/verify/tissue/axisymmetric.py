"""Indentation of a layer by a rigid, frictionless sphere, solved with finite elements at large strain.

The layer is bonded to a rigid ground. The sphere pushes on the surface's Gauss points by a penalty that is stiff
against the layer. The depth grows in steps, each solved by Newton's method.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.linalg import splu

from palpate.base.arrays import Array
from palpate_lab.verify.tissue.solid import GAUSS, Solid, lagrange

Index = npt.NDArray[np.signedinteger]

_PENALTY = 120.0  # stiffness of the contact, in units of E over the length of an element
_PRESSURE = 3.0  # bound of the pressure in the stiffness of the contact, in units of E
_STEP = 0.025  # largest step of depth, in units of R
_GROWTH = 1.3  # of elements away from the contact


@dataclass(frozen=True)
class Lump:
    """A ball of another modulus on the axis, bonded to the layer. Lengths are relative to the sphere's radius."""

    top: float  # depth of its upper end below the surface
    radius: float
    ratio: float = 10.0  # of its modulus to the layer's


@dataclass(frozen=True)
class Indentation:
    """One case. Lengths and forces are relative to the sphere: the radius is 1 m and Young's modulus 1 Pa."""

    poisson: float = 0.45
    thickness: float = 50.0  # of the layer; a half-space from about 50
    width: float = 50.0  # radius of the layer, free at its side
    yeoh: float = 0.0
    fine: int = 16  # elements for one radius, near the contact
    near: float = 1.4  # size of the zone with equal elements
    lump: Lump | None = None

    def solid(self) -> Solid:
        """The mesh: equal elements near the axis and the surface, then coarser and coarser ones."""
        r = _graded(self.near, self.width, self.fine)
        z = -_graded(self.near, self.thickness, self.fine)
        nodes = np.stack(np.meshgrid(r, z, indexing="ij"), axis=-1).reshape(-1, 2)
        i, j = np.meshgrid(np.arange(0, len(r) - 2, 2), np.arange(0, len(z) - 2, 2), indexing="ij")
        corner = (i * len(z) + j + 2).ravel()  # j grows downward: start at the lower corner
        inside = np.array([a * len(z) - b for a in range(3) for b in range(3)])
        elements = corner[:, None] + inside
        young = self._young(nodes[elements])
        bulk = young / (3.0 * (1.0 - 2.0 * self.poisson))
        return Solid(nodes, elements, young * 0.5 / (1.0 + self.poisson), bulk, self.yeoh)

    def _young(self, corners: Array) -> float | Array:
        """Young's modulus at the Gauss points (m, 9) of elements with nodes (m, 9, 2)."""
        if self.lump is None:
            return 1.0
        N, _ = lagrange(GAUSS[0])
        points = np.einsum("pi,qj,eijd->epqd", N, N, corners.reshape(-1, 3, 3, 2)).reshape(-1, 9, 2)
        centre = np.array([0.0, -self.lump.top - self.lump.radius])
        inside = np.linalg.norm(points - centre, axis=-1) < self.lump.radius
        return np.where(inside, self.lump.ratio, 1.0)

    def forces(self, depths: Array) -> Array:
        """Force (k,) on the sphere at increasing depths (k,), in units of E R^2; depths in units of R.

        Raises:
            RuntimeError: Newton's method does not converge; ask for smaller steps of depth.
        """
        solid = self.solid()
        top = np.flatnonzero(solid.nodes[:, 1] == 0.0)
        fixed = solid.nodes[:, 1] <= -self.thickness + 1e-9
        free = np.ones((len(solid.nodes), 2), dtype=bool)
        free[fixed] = False
        free[solid.nodes[:, 0] == 0.0, 0] = False
        dof = np.flatnonzero(free.ravel())
        u, change, result, reached = np.zeros_like(solid.nodes), np.zeros_like(solid.nodes), [], 0.0
        for depth in np.asarray(depths, dtype=np.float64):
            steps = int(np.ceil((depth - reached) / _STEP - 1e-9))
            for centre in 1.0 - np.linspace(reached, depth, steps + 1)[1:]:
                contact = _Contact(solid.nodes, top, _PENALTY * self.fine, float(centre))
                new = _solve(solid, contact, u + change, dof)
                u, change, reached = new, new - u, depth
            result.append(contact.assemble(u)[2])
        return np.array(result)


@dataclass(frozen=True)
class _Contact:
    """Penalty between the surface and a unit sphere whose centre is at height `centre` on the axis."""

    nodes: Array  # (n, 2)
    top: Index  # nodes of the surface, from the axis outward: two for each element, and one more
    penalty: float  # [Pa/m]
    centre: float

    def assemble(self, u: Array) -> tuple[float, Array, float, sparse.csc_matrix]:
        """Energy, forces (2 n,) on the solid's nodes (negative gradient excluded), force on the sphere, stiffness."""
        edges = np.stack([self.top[:-2:2], self.top[1:-1:2], self.top[2::2]], axis=1)  # (m, 3)
        N, dN = lagrange(GAUSS[0])
        r = self.nodes[edges, 0] @ N.T
        weight = self.penalty * 2.0 * np.pi * r * (self.nodes[edges, 0] @ dN.T) * GAUSS[1]
        away = np.einsum("qa,ead->eqd", N, (self.nodes + u)[edges]) - np.array([0.0, self.centre])
        distance = np.linalg.norm(away, axis=-1)
        gap = np.minimum(distance - 1.0, 0.0)
        n = away / distance[..., None]
        force = np.einsum("eq,eqd,qa->ead", weight * gap, n, N)
        bounded = np.maximum(gap, -_PRESSURE / self.penalty)  # while the sphere has moved and the surface has not yet
        ratio = (bounded / distance)[..., None, None]
        block = np.where(gap < 0.0, weight, 0.0)[..., None, None] * (
            n[..., :, None] * n[..., None, :] * (1.0 - ratio) + ratio * np.eye(2)
        )
        stiff = np.einsum("eqcd,qa,qb->eacbd", block, N, N).reshape(len(edges), 6, 6)
        dof = (2 * edges[:, :, None] + np.arange(2)).reshape(-1, 6)
        size = self.nodes.size
        rows, columns = np.repeat(dof, 6, axis=1).ravel(), np.tile(dof, (1, 6)).ravel()
        matrix = sparse.csc_matrix((stiff.ravel(), (rows, columns)), shape=(size, size))
        total = np.bincount(dof.ravel(), force.ravel(), size).astype(np.float64)
        on_sphere = -float(np.sum(weight * gap * n[..., 1] * -1.0))
        return float(0.5 * np.sum(weight * gap**2)), total, on_sphere, matrix


def _solve(solid: Solid, contact: _Contact, start: Array, free: Index) -> Array:
    """Displacements (n, 2) in equilibrium, by Newton's method with steps halved until the energy falls.

    Rounding of the energy hides changes below 1e-9 E R^3, and Newton's steps are then taken whole.
    """
    u = start.copy()
    energy, gradient, matrix = _total(solid, contact, u)
    for _ in range(40):
        change = np.zeros(u.size)
        change[free] = -splu(matrix[free][:, free]).solve(gradient[free])
        slope, step = float(gradient @ change), 1.0
        if abs(slope) < 1e-15:
            return u
        while True:
            trial = u + step * change.reshape(u.shape)
            new = _total(solid, contact, trial)
            if new[0] <= energy + 1e-3 * step * slope + 1e-9 or step < 1e-3:
                break
            step *= 0.5
        u, (energy, gradient, matrix) = trial, new
    raise RuntimeError("no equilibrium within 40 iterations")


def _total(solid: Solid, contact: _Contact, u: Array) -> tuple[float, Array, sparse.csc_matrix]:
    W, f, K = solid.assemble(u)
    Wc, fc, _, Kc = contact.assemble(u)
    return W + Wc, f + fc, K + Kc


def _graded(near: float, end: float, per_radius: int) -> Array:
    """Coordinates of element corners and midpoints from 0 to `end`: equal up to `near`, then growing."""
    if end <= near:
        corners = np.linspace(0.0, end, max(4, round(end * per_radius)) + 1)
    else:
        steps = [1.0 / per_radius * _GROWTH**k for k in range(1, 200)]
        outer = near + np.cumsum(steps)
        count = int(np.searchsorted(outer, end)) + 1
        outer = near + (outer[:count] - near) * (end - near) / (outer[count - 1] - near)
        corners = np.concatenate([np.linspace(0.0, near, round(near * per_radius) + 1), outer])
    middles = 0.5 * (corners[1:] + corners[:-1])
    return np.sort(np.concatenate([corners, middles]))
