"""The organ as a noisy cloud against the organ as a mesh: the forces on the same slide."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.scene import contact
from palpate.world import surfaces
from palpate.world.clouds import PointCloud
from palpate.world.mesh import Mesh
from palpate.world.registration.clouds import sampled
from palpate.world.shapes.organs import organ

_STIFFNESS, _RADIUS, _DEPTH = 1000.0, 0.004, 0.002  # [N/m], [m], of the tip's lowest point below the surface [m]


def difference(spacing: float = 1e-3, noise: float = 1e-3) -> tuple[float, float]:
    """Rms difference of the force of the cloud to that of the mesh, relative to its rms [-], and its angle [deg].

    Args:
        spacing: mean distance between the points of the cloud [m].
        noise: standard deviation of each coordinate [m].
    """
    vertices, triangles = organ(20_000)
    corners = vertices[triangles]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    points = sampled(vertices, triangles, int(area / spacing**2), 0)
    points = points + noise * np.random.default_rng(0).normal(size=points.shape)
    mesh, cloud = Mesh(vertices, triangles), surfaces.PointSurface(PointCloud(points))
    tips = _slide(mesh)
    exact, felt = (
        contact.render(body, tips, radius=_RADIUS, stiffness=_STIFFNESS).force[20:] for body in (mesh, cloud)
    )
    rms = float(np.sqrt(np.mean(((felt - exact) ** 2).sum(axis=1)) / np.mean((exact**2).sum(axis=1))))
    sizes = np.linalg.norm(felt, axis=1) * np.linalg.norm(exact, axis=1)
    cosine = np.einsum("ni,ni->n", felt, exact) / np.maximum(sizes, 1e-12)
    return rms, float(np.degrees(np.sqrt(np.mean(np.arccos(np.clip(cosine, -1.0, 1.0)) ** 2))))


def _slide(mesh: Mesh) -> Array:
    """Centres of the tip (n, 3) that slide over the organ's upper side, below its surface by a constant depth [m]."""
    top = mesh.vertices[mesh.vertices[:, 2].argmax()]
    x = np.linspace(-0.03, 0.03, 400)
    above = np.stack([top[0] + x, np.full_like(x, top[1]), np.full_like(x, top[2] + 0.02)], axis=1)
    for _ in range(30):  # down until the centre has the wanted distance
        distance = mesh.core.nearest(above)[0]
        above[:, 2] -= 0.7 * (distance - (_RADIUS - _DEPTH))
    return above
