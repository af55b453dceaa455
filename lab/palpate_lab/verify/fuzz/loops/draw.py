"""Random scenes, and closed ways of the tool in them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate_lab.verify.fuzz.loops.bodies import Body
from palpate_lab.verify.fuzz.loops.ways import Way

FORCE = 20.0  # cap of the force with the passivity layer; a quarter of it is pressed [N]
_UNCAPPED = {"force_cap": 1e3, "moment_cap": 1e3, "rate_cap": 1e6, "moment_rate_cap": 1e6}
"""Caps that never act: without the layer, caps have a kind of their own."""
_CLEAR = 0.002  # distance from the surface at which a way starts [m]


def turned(rpy_deg: Any) -> Array:
    """Rotation (3, 3) of roll, pitch and yaw [deg]."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(np.radians(rpy_deg)), np.sin(np.radians(rpy_deg))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


@dataclass
class Site:
    """A body placed in the world, and the values of its scene so far."""

    rng: np.random.Generator
    body: Body
    R: Array  #: R_WO (3, 3)
    p: Array  #: p_WO (3,) [m]
    radius: float  #: of the tool's sphere [m]
    stiffness: float  #: [N/m]
    depth: float  #: largest depth of the ways [m]
    reach: float  #: largest distance of the ways along the surface [m]
    scene: Content = field(default_factory=dict)

    def spot(self, u: float = 0.0, v: float = 0.0) -> tuple[Array, Array]:
        """Point [m] and outward normal in W."""
        p, n = self.body.spot(u, v)
        return self.R @ p + self.p, self.R @ n

    def tool(self, u: float, v: float, depth: float) -> Array:
        """Centre (3,) of the tool's sphere in W at a depth below the surface [m]."""
        p, n = self.spot(u, v)
        return np.asarray(p + (self.radius - depth) * n)

    @property
    def object(self) -> Content:
        """The section of the object."""
        return self.scene["objects"][0]  # type: ignore[no-any-return]

    def beside(self, scale: float = 1.0) -> tuple[float, float]:
        """Random coordinates of a spot."""
        u, v = scale * self.reach * self.rng.uniform(-1, 1, 2)
        return float(u), float(v)


def number(x: float) -> float:
    """A number of four digits."""
    return float(f"{x:.4g}")


def vector(x: Any) -> list[float]:
    """A vector in steps of 10 um."""
    return [float(round(c, 5)) for c in x]


def site(rng: np.random.Generator, kinds: tuple[Callable[[np.random.Generator], Body], ...]) -> Site:
    """A random body, placed so that it is touched from above, with the rest of a scene."""
    body = kinds[rng.integers(len(kinds))](rng)
    n = body.spot(0.0, 0.0)[1]
    rpy = [0.0, 0.0, 0.0]
    for _ in range(1000):
        rpy = [float(round(a, 1)) for a in rng.uniform(-180, 180, 3)]
        if (turned(rpy) @ n)[2] > 0.8:
            break
    radius = number(rng.uniform(0.001, 0.006))
    stiffness = number(np.exp(rng.uniform(np.log(100.0), np.log(1500.0))))
    depth = min(rng.uniform(0.2, 1.5) * radius, 0.4 * body.size, 0.25 * FORCE / stiffness)
    reach = rng.uniform(0.3, 1.0) * min(0.008, 0.8 * body.curve or 0.008)
    at = vector(rng.uniform(-0.02, 0.02, 3))
    made = Site(rng, body, turned(rpy), np.array(at), radius, stiffness, float(depth), float(reach))
    scale = float(rng.choice([1.0, 1.0, number(np.exp(rng.uniform(np.log(0.1), np.log(3.0))))]))
    made.scene = {
        "objects": [{"name": "body", **body.section, "pose": {"xyz": at, "rpy_deg": rpy}, "stiffness": stiffness,
                     "damping": 0.0}],
        "contact": {"radius": radius},
        "mapping": {"scale": scale, "force_scale": float(rng.choice([1.0, 1.0, 0.5, 2.0]))},
        "arms": {"leader": {"base": {"xyz": [0.1, 0.0, 0.1], "rpy_deg": vector(rng.uniform(-180, 180, 3))}},
                 "follower": {"bandwidth": 0}},
        "operator": {"path": [{"t": 0, "xyz": vector(made.tool(0.0, 0.0, -_CLEAR))}]},
        "stability": {"passivity": "off", **_UNCAPPED},
        "rates": {"haptic": 100.0},
    }  # fmt: skip
    return made


def closed(s: Site, inner: list[tuple[float, float, float]], theta: list[Array] | None = None) -> Way:
    """The way from the start over `inner` (u, v, depth) [m] and back; theta: rotation vector at each [rad]."""
    start = np.array(s.scene["operator"]["path"][0]["xyz"])
    first, last = inner[0], inner[-1]
    points = [start, s.tool(*first[:2], -_CLEAR), *(s.tool(*one) for one in inner), s.tool(*last[:2], -_CLEAR), start]
    turns = theta if theta is not None else [np.zeros(3)] * len(inner)
    return Way(np.array(points), np.array([np.zeros(3), np.zeros(3), *turns, np.zeros(3), np.zeros(3)]))


def wander(s: Site, turning: float = 0.0) -> Way:
    """In beside the middle, along the surface at changing depths, and out elsewhere; turning: largest angle [rad]."""
    n = int(s.rng.integers(1, 5))
    inner = [(*s.beside(), s.depth * s.rng.uniform(0.2, 1.0)) for _ in range(n + 1)]
    theta = [turning * s.rng.normal(size=3) / 2 for _ in inner] if turning > 0.0 else None
    return closed(s, inner, theta)


def across(s: Site) -> Way:
    """In at one side, deep through the middle, out at the other side."""
    u, v = s.beside()
    return closed(s, [(-u, -v, s.depth), (u, v, s.depth)])


def stick(s: Site, friction: float, turns: int = 5) -> Way:
    """Deep out, shallow back, many times, within the cone of friction."""
    d1 = s.depth * s.rng.uniform(0.2, 0.7)
    a, away = s.rng.uniform(0, 2 * np.pi), 0.9 * friction * d1
    u0, v0 = s.beside(0.5)
    u1, v1 = u0 + away * np.cos(a), v0 + away * np.sin(a)
    ring = [(u0, v0, d1), (u0, v0, s.depth), (u1, v1, s.depth), (u1, v1, d1)]
    if s.rng.uniform() < 0.5:
        ring = [ring[0], ring[3], ring[2], ring[1]]
    return closed(s, [(u0, v0, d1), *(ring * turns), (u0, v0, d1)])
