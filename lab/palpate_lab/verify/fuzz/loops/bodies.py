"""Bodies with points and normals in closed form: where the ways of random loops touch."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate_lab.verify.fuzz.loops import files

Spot = Callable[[float, float], tuple[Array, Array]]
"""Point (3,) [m] and outward normal (3,), in the body's frame, for two coordinates of about metres."""


@dataclass(frozen=True)
class Body:
    """A body of a scene."""

    section: Content  #: its geometry in the scene's list `objects`
    spot: Spot
    size: float  #: smallest length across which a tool may press [m]
    sharp: bool = False  #: it has edges, or facets
    curve: float = 0.0  #: radius of curvature; 0: flat [m]


def _round(x: float) -> float:
    return float(f"{x:.4g}")


def plane(rng: np.random.Generator) -> Body:
    """A half-space."""
    return Body({"plane": {"size": 0.2}}, lambda u, v: (np.array([u, v, 0.0]), np.array([0.0, 0.0, 1.0])), 0.05)


def sphere(rng: np.random.Generator) -> Body:
    """A ball of 4 to 40 mm."""
    R = _round(float(np.exp(rng.uniform(np.log(0.004), np.log(0.04)))))
    return Body({"sphere": {"radius": R}}, _on_ball(R), R, curve=R)


def _on_ball(R: float) -> Spot:
    def spot(u: float, v: float) -> tuple[Array, Array]:
        a, b = u / R, np.clip(v / R, -1.4, 1.4)
        n = np.array([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)])
        return R * n, n

    return spot


def capsule(rng: np.random.Generator) -> Body:
    """A capsule; its ends are round."""
    R, length = _round(rng.uniform(0.004, 0.015)), _round(rng.uniform(0.01, 0.06))
    around = _on_tube(R)

    def spot(u: float, v: float) -> tuple[Array, Array]:
        if abs(v) <= 0.5 * length:
            return around(u, v)
        b = min((abs(v) - 0.5 * length) / R, 1.4) * np.sign(v)
        n = np.array([np.cos(b) * np.cos(u / R), np.cos(b) * np.sin(u / R), np.sin(b)])
        return R * n + np.array([0.0, 0.0, 0.5 * length * np.sign(v)]), n

    return Body({"capsule": {"radius": R, "length": length}}, spot, R, curve=R)


def _on_tube(R: float) -> Spot:
    def spot(u: float, v: float) -> tuple[Array, Array]:
        n = np.array([np.cos(u / R), np.sin(u / R), 0.0])
        return R * n + np.array([0.0, 0.0, v]), n

    return spot


def cylinder(rng: np.random.Generator) -> Body:
    """A cylinder; beyond its rim the points lie on the flat end."""
    R, length = _round(rng.uniform(0.005, 0.02)), _round(rng.uniform(0.02, 0.06))
    around, top = _on_tube(R), 0.5 * length

    def spot(u: float, v: float) -> tuple[Array, Array]:
        v += 0.7 * top  # near one end
        if v <= top:
            return around(u, v)
        at, _ = around(u, 0.0)
        return at * max(1.0 - (v - top) / R, 0.1) + np.array([0.0, 0.0, top]), np.array([0.0, 0.0, 1.0])

    return Body({"cylinder": {"radius": R, "length": length}}, spot, R, sharp=True, curve=R)


def box(rng: np.random.Generator) -> Body:
    """A box; the points lie around one of its edges."""
    size = [_round(x) for x in rng.uniform(0.012, 0.05, 3)]
    half = 0.5 * np.array(size)
    inset = rng.uniform(0.0, 1.0) * half[0]

    def spot(u: float, v: float) -> tuple[Array, Array]:
        along = np.clip(v, -half[1], half[1])
        x = half[0] - inset + u
        if x <= half[0]:
            return np.array([x, along, half[2]]), np.array([0.0, 0.0, 1.0])
        return np.array([half[0], along, half[2] - (x - half[0])]), np.array([1.0, 0.0, 0.0])

    return Body({"box": {"size": size}}, spot, 0.7 * float(half.min()), sharp=True)


def slab(rng: np.random.Generator) -> Body:
    """A flat box, touched on its upper side."""
    size = [0.04, 0.04, float(rng.choice([0.012, 0.016, 0.02]))]  # few, as filling them takes seconds
    return Body({"box": {"size": size}}, lambda u, v: (np.array([u, v, 0.5 * size[2]]), np.array([0, 0, 1.0])), 0.05)


def implicit(rng: np.random.Generator) -> Body:
    """An ellipsoid or a pillow."""
    half, e = [_round(x) for x in rng.uniform(0.008, 0.03, 3)], int(rng.choice([2, 2, 4]))
    a = np.array(half)

    def spot(u: float, v: float) -> tuple[Array, Array]:
        d = _on_ball(float(a.mean()))(u, v)[1]
        p = d * (np.abs(d / a) ** e).sum() ** (-1.0 / e)
        n = np.sign(p) * np.abs(p) ** (e - 1) / a**e
        return p, n / np.linalg.norm(n)

    section = {"implicit": {"half": half, "exponents": [e, e, e]}}
    return Body(section, spot, float(a.min()), curve=float(a.min()))


def ball_mesh(rng: np.random.Generator) -> Body:
    """A ball of triangles."""
    R, n = _round(rng.uniform(0.005, 0.03)), int(rng.choice([1, 2, 3]))
    return Body({"mesh": files.ball(R, n), "unit": "m"}, _on_ball(R), 0.8 * R, sharp=True, curve=R)


def relief(rng: np.random.Generator) -> Body:
    """A closed mesh whose upper side is hilly; some valleys are narrower than the sphere of the tool."""
    A, L = _round(rng.uniform(0.0005, 0.004)), _round(rng.uniform(0.006, 0.03))
    crossing = bool(rng.uniform() < 0.5)
    z = _wave(A, L, crossing)
    return Body(
        {"mesh": files.relief(z, f"hills-{A:g}-{L:g}-{crossing:d}"), "unit": "m"},
        _on_height(z),
        0.01,
        sharp=True,
        curve=L / 6,
    )


def valley(rng: np.random.Generator) -> Body:
    """A mesh of two slopes that meet in a valley."""
    slope = _round(rng.uniform(0.2, 1.5))

    def z(x: float, y: float) -> float:
        return slope * abs(x)

    return Body({"mesh": files.relief(z, f"valley-{slope:g}"), "unit": "m"}, _on_height(z), 0.008, sharp=True)


def grid(rng: np.random.Generator) -> Body:
    """A ball as a signed distance grid."""
    R = _round(rng.uniform(0.008, 0.02))
    return Body({"sdf": files.ball_grid(R)}, _on_ball(R), 0.8 * R, sharp=True, curve=R)


def cloud(rng: np.random.Generator) -> Body:
    """A ball of points."""
    R = _round(rng.uniform(0.01, 0.02))
    return Body({"cloud": {"file": files.ball_cloud(R)}, "unit": "m"}, _on_ball(R), 0.6 * R, sharp=True, curve=R)


SMOOTH = (plane, sphere, capsule, cylinder, box, implicit)
MADE = (ball_mesh, grid, cloud)
CURVED = (sphere, capsule, cylinder, implicit, ball_mesh)


def _wave(A: float, L: float, crossing: bool) -> Callable[[float, float], float]:
    k = 2 * np.pi / L
    return lambda x, y: float(A * np.sin(k * x) * (np.cos(k * y) if crossing else 1.0))


def _on_height(z: Callable[[float, float], float]) -> Spot:
    def spot(u: float, v: float) -> tuple[Array, Array]:
        u, v, h = float(np.clip(u, -0.017, 0.017)), float(np.clip(v, -0.017, 0.017)), 1e-6
        n = np.array([-(z(u + h, v) - z(u - h, v)) / (2 * h), -(z(u, v + h) - z(u, v - h)) / (2 * h), 1.0])
        return np.array([u, v, z(u, v)]), n / np.linalg.norm(n)

    return spot
