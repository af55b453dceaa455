"""A simulated depth camera: rays of a pinhole camera that end on a surface, with noise along the ray."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.rigid import inverse

_FAR, _NEAR = 2.0, 5e-5  # range of the camera, distance from the surface at which a ray has arrived [m]
_STEPS = 200  # steps of a ray at most
_GRAZING = 0.2  # smallest cosine of the angle between ray and normal that returns a measurement


@dataclass(frozen=True)
class DepthCamera:
    """A depth camera with the optical frame of ROS: z forward, x right, y down.

    It returns points of the organ alone: the segmentation of the picture is taken as done.
    """

    columns: int = 96
    rows: int = 72
    width_deg: float = 50.0  #: horizontal angle of view
    noise: float = 1e-3  #: standard deviation along the ray [m]
    outliers: float = 0.02  #: share of points at a wrong range, within 50 mm

    def rays(self) -> Array:
        """Unit directions (rows * columns, 3) in the camera's frame."""
        focal = 0.5 * self.columns / np.tan(0.5 * np.radians(self.width_deg))
        u, v = np.meshgrid(np.arange(self.columns) + 0.5, np.arange(self.rows) + 0.5)
        d = np.stack([(u - 0.5 * self.columns) / focal, (v - 0.5 * self.rows) / focal, np.ones_like(u)], axis=-1)
        return np.asarray((d / np.linalg.norm(d, axis=-1, keepdims=True)).reshape(-1, 3))

    def look(self, surface: _core.Surface, X_CO: Array, rng: np.random.Generator) -> Array:
        """Points (N, 3) in the camera's frame C that it sees of a surface at X_CO (4, 4) [m]."""
        d = self.rays()
        X_OC = inverse(X_CO)
        t, normals = cast(surface, X_OC[:3, 3], d @ X_OC[:3, :3].T)
        hit = np.isfinite(t)
        hit[hit] &= -np.einsum("ni,ni->n", normals[hit], d[hit] @ X_OC[:3, :3].T) > _GRAZING
        t, d = t[hit], d[hit]
        t = t + self.noise * rng.normal(size=len(t))
        wrong = rng.random(len(t)) < self.outliers
        t[wrong] += rng.uniform(-0.05, 0.05, int(wrong.sum()))
        return np.asarray(t[:, None] * d)


def cast(surface: _core.Surface, start: Array, directions: Array) -> tuple[Array, Array]:
    """Lengths (N,) of rays from `start` (3,) along unit `directions` (N, 3) to a surface, infinite where they miss [m].

    Each ray advances by its distance from the surface, which cannot cross it (sphere tracing; Hart, The Visual Computer
    12, 1996). Also returns the surface's outward normals (N, 3) at the ends.
    """
    t, normals = np.zeros(len(directions)), np.zeros_like(directions)
    going, hit = np.arange(len(directions)), np.zeros(len(directions), dtype=bool)
    for _ in range(_STEPS):
        if not len(going):
            break
        p = start + t[going, None] * directions[going]
        distance, _, normal = surface.nearest(np.ascontiguousarray(p))
        distance = np.abs(distance)
        arrived = distance < _NEAR
        hit[going[arrived]], normals[going[arrived]] = True, normal[arrived]
        t[going] += np.where(arrived, 0.0, distance)
        going = going[~arrived & (t[going] < _FAR)]
    return np.where(hit, t, np.inf), normals
