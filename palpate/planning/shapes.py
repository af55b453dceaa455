"""Capsules that contain the parts of an instrument: boxes, cylinders, spheres and meshes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array

_Z = np.array([0.0, 0.0, 1.0])
_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
_SQUAT = 1.5  # half length per radius below which a cylinder gets a sphere
_SIDES = 48  # of the prism that contains a cylinder


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
    """The capsule around a box (x, y, z), a cylinder or capsule (radius, length along z) or a sphere (radius) at X [m].

    X: pose (4, 4).
    """
    if shape == "sphere":
        return Capsule(np.zeros(3), np.zeros(3), size[0]).moved(X)
    if shape == "cylinder":
        half = 0.5 * size[1]
        if half < _SQUAT * size[0]:  # a sphere reaches less far across than any capsule along a pin
            return Capsule(np.zeros(3), np.zeros(3), float(np.hypot(half, size[0]))).moved(X)
        return _least(half, size[0], _Z).moved(X)
    if shape == "capsule":
        return Capsule(-0.5 * size[1] * _Z, 0.5 * size[1] * _Z, size[0]).moved(X)
    sides = 0.5 * np.array(size)
    longest = int(np.argmax(sides))
    return _least(float(sides[longest]), float(np.linalg.norm(np.delete(sides, longest))), np.eye(3)[longest]).moved(X)


def _least(half: float, rim: float, axis: Array) -> Capsule:
    """The capsule of least volume along `axis` (3,) for corners at +-half and `rim` off the axis."""
    h = np.linspace(0.0, half, 400)
    radius = np.hypot(half - h, rim)
    best = int(np.argmin(2.0 * h * radius**2 + 4.0 / 3.0 * radius**3))
    return Capsule(-h[best] * axis, h[best] * axis, float(radius[best]) * (1.0 + 1e-12))


def outline(shape: str, size: tuple[float, ...], X: Array) -> Array:
    """Points (k, 3) whose convex hull contains a box, a cylinder, a capsule or a sphere at X (4, 4) [m]."""
    if shape == "capsule":
        shape, size = "cylinder", (size[0], size[1] + 2.0 * size[0])
    if shape == "box":
        points = 0.5 * np.array(size) * _CORNERS
    elif shape == "cylinder":
        angle = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
        rim = size[0] / np.cos(np.pi / _SIDES) * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        points = np.concatenate([np.c_[rim, np.full(_SIDES, z)] for z in (-0.5 * size[1], 0.5 * size[1])])
    else:
        points = size[0] * 3**0.5 * _CORNERS
    return np.asarray(points @ X[:3, :3].T + X[:3, 3])


def around(points: Array) -> Capsule:
    """A capsule around points (k, 3) [m]: the one of least volume along their principal axes and those of the frame."""
    _, _, principal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    found = [_along(points, axis) for axis in (*principal, *np.eye(3))]
    return min(found, key=lambda c: c.length * c.radius**2 + 4.0 / 3.0 * c.radius**3)


def _along(points: Array, axis: Array) -> Capsule:
    """The capsule along a unit axis (3,) through the middle of the points' extents across it."""
    side = np.linalg.svd(axis[None])[2][1:]  # (2, 3) across the axis
    across = points @ side.T
    middle = 0.5 * (across.min(axis=0) + across.max(axis=0))
    off = np.linalg.norm(across - middle, axis=1)
    radius = float(off.max()) * (1.0 + 1e-9) + 1e-9
    along = points @ axis
    inset = np.sqrt(np.maximum(radius**2 - off**2, 0.0))  # how far the round end reaches beyond the segment there
    low, high = float((along + inset).min()), float((along - inset).max())
    if low > high:
        low = high = 0.5 * (low + high)
    return Capsule(middle @ side + low * axis, middle @ side + high * axis, radius)


def merged(capsules: list[Capsule], slack: float) -> list[Capsule]:
    """Fewer capsules that contain all given ones.

    Two become one if it is thicker than either by no more than `slack` [m], or if it only makes the thicker one thicker
    and longer by so little: a thin tube is not made as thick as a short sleeve around it.
    """
    left = list(capsules)
    for i, one in enumerate(left):
        for j, two in enumerate(left):
            if i == j:
                continue
            both = _union(one, two)
            if both is None or both.radius > max(one.radius, two.radius) + slack:
                continue
            thick = one if one.radius >= two.radius else two
            if both.radius <= min(one.radius, two.radius) + slack or both.length <= thick.length + slack:
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
