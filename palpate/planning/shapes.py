"""Capsules that contain the parts of an instrument: boxes, cylinders, spheres and meshes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.arrays import Array

_Z = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Capsule:
    """All points within `radius` [m] of the segment from `a` to `b` (3,) [m]; a sphere if both are equal."""

    a: Array
    b: Array
    radius: float

    @property
    def length(self) -> float:
        """Length of the segment [m]."""
        return float(np.linalg.norm(self.b - self.a))

    def moved(self, X: Array) -> Capsule:
        """The capsule at the pose X (4, 4)."""
        return Capsule(X[:3, :3] @ self.a + X[:3, 3], X[:3, :3] @ self.b + X[:3, 3], self.radius)

    def distances(self, points: Array) -> Array:
        """Signed distances (k,) of points (k, 3) from the capsule [m]."""
        d, along = self.b - self.a, points - self.a
        t = np.clip(along @ d / max(float(d @ d), 1e-30), 0.0, 1.0)
        return np.asarray(np.linalg.norm(along - t[:, None] * d, axis=1) - self.radius)

    def pose(self) -> Array:
        """Pose (4, 4) of the middle, with z along the segment."""
        X = np.eye(4)
        X[:3, 3] = 0.5 * (self.a + self.b)
        if self.length > 1e-12:
            z = (self.b - self.a) / self.length
            x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
            x /= np.linalg.norm(x)
            X[:3, 0], X[:3, 1], X[:3, 2] = x, np.cross(z, x), z
        return X


def of_primitive(shape: str, size: tuple[float, ...], X: Array) -> Capsule:
    """The capsule around a box (x, y, z), a cylinder (radius, length along z) or a sphere (radius) at X (4, 4) [m]."""
    if shape == "sphere":
        return Capsule(np.zeros(3), np.zeros(3), size[0]).moved(X)
    if shape == "cylinder":
        half = 0.5 * size[1] * _Z
        return Capsule(-half, half, size[0]).moved(X)
    sides = 0.5 * np.array(size)
    longest = int(np.argmax(sides))
    half = sides[longest] * np.eye(3)[longest]
    return Capsule(-half, half, float(np.linalg.norm(np.delete(sides, longest)))).moved(X)


def around(points: Array) -> Capsule:
    """A capsule around points (k, 3) [m]: along their principal axis, as thick as the farthest of them asks for."""
    centre = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - centre, full_matrices=False)
    along = (points - centre) @ axes[0]
    off = np.linalg.norm(points - centre - np.outer(along, axes[0]), axis=1)
    radius = float(off.max()) * (1.0 + 1e-9) + 1e-9
    inset = np.sqrt(np.maximum(radius**2 - off**2, 0.0))  # how far the round end reaches beyond the segment there
    low, high = float((along + inset).min()), float((along - inset).max())
    if low > high:
        low = high = 0.5 * (low + high)
    return Capsule(centre + low * axes[0], centre + high * axes[0], radius)


def merged(capsules: list[Capsule], slack: float) -> list[Capsule]:
    """Fewer capsules that contain all given ones: two become one if it is thicker by no more than `slack` [m]."""
    left = list(capsules)
    for i, one in enumerate(left):
        for j, two in enumerate(left):
            if i == j:
                continue
            both = _union(one, two)
            if both is not None and both.radius <= max(one.radius, two.radius) + slack:
                rest = [c for k, c in enumerate(left) if k not in (i, j)]
                return merged([*rest, both], slack)
    return left


def _union(one: Capsule, two: Capsule) -> Capsule | None:
    """A capsule around two, along the longer of both; None if neither has a direction."""
    main, other = (one, two) if one.length >= two.length else (two, one)
    if main.length < 1e-9:
        return None
    u = (main.b - main.a) / main.length
    ends = np.stack([other.a, other.b])
    t = (ends - main.a) @ u
    off = np.linalg.norm(ends - main.a - np.outer(t, u), axis=1)
    radius = max(main.radius, float(off.max()) + other.radius)
    low, high = min(0.0, float(t.min())), max(main.length, float(t.max()))
    return Capsule(main.a + low * u, main.a + high * u, radius)
