"""The operator's intended path of the tool: way points of the scene, or an automatic palpation of an object."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import SceneError
from palpate.scene import doubts
from palpate.scene.jaws import GripPoint
from palpate.scene.scene import Scene
from palpate.scene.surface import PlacedSurface

_DIRECTIONS = 6  # number of slide directions, 60 degrees apart
_SAMPLE = 0.01  # sample period of a slide [s]
_DEGREE = 6  # degree of the polynomial fitted to a slide over facets
_MAX_DURATION = 3600.0  # duration of an automatic path [s]
_MIN_PERIODS = 7  # periods of a shortened path: one for each direction, and one more


@dataclass(frozen=True)
class HandPlan:
    """Intended path of the tool, and its phases."""

    times: Array  # (k,) rising [s]
    positions_W: Array  # (k, 3) [m]
    period: float = 0.0  # period of the phases; 0: not periodic [s]
    phases: tuple[tuple[float, str], ...] = ()  # (start within the period [s], name)

    def core(self, grip: Sequence[GripPoint] | None = None) -> _core.HandPath:
        """The path of the core, with a program of pinch angles; None: half open."""
        angles, times = [p.angle for p in grip or ()], [p.t for p in grip or ()]
        return _core.HandPath(self.times.tolist(), self.positions_W, angles or None, times or None)

    def phase(self, t: float) -> str:
        """Phase at time ``t`` [s]: ``approach``, ``press``, ``slide`` or ``leave``; empty for a path of way points."""
        within = t % self.period if self.period else t
        return next((name for start, name in reversed(self.phases) if within >= start), "")


def plan(scene: Scene, surfaces: list[PlacedSurface], until: float | None = None) -> HandPlan:
    """The path of the scene's operator.

    Args:
        scene: scene with a path of the operator, or an object to palpate.
        surfaces: surfaces of the scene's objects.
        until: time up to which the automatic path is needed; a shorter path saves memory and is otherwise the same [s].

    Raises:
        SceneError: the intended force on the hand is not below the cap.
    """
    path = scene.operator.path
    if path is not None:
        return HandPlan(np.array([p.t for p in path]), np.array([p.xyz for p in path]))
    return _palpation(scene, surfaces, _MAX_DURATION if until is None else min(until, _MAX_DURATION))


def intended_depth(scene: Scene, index: int, normal: Array) -> float:
    """Depth of the intended path below the surface that results in the palpation force [m].

    The tool penetrates by F / K, or into tissue by the law of Hertz; the spring of the hand yields by
    scale * force_scale * F / K_hand.
    """
    F, mapping = scene.operator.palpate.force, scene.mapping
    depth = _indentation(scene, index, normal)
    return depth + mapping.scale * mapping.force_scale * F / scene.operator.stiffness


def _indentation(scene: Scene, index: int, normal: Array) -> float:
    """Depth at which the object returns the palpation force [m]."""
    F, obj = scene.operator.palpate.force, scene.objects[index]
    K = float(normal @ np.diag(obj.stiffness) @ normal)
    return F / max(K, 1e-9) if obj.tissue is None else obj.tissue.depth(F, scene.contact.radius)


def _palpation(scene: Scene, surfaces: list[PlacedSurface], until: float) -> HandPlan:
    o = scene.operator.palpate
    index = next((i for i, obj in enumerate(scene.objects) if obj.name == o.object), 0)
    surface = surfaces[index]
    felt = o.force * scene.mapping.force_scale
    if felt >= scene.stability.force_cap:
        raise SceneError(
            f"operator.palpate.force: {felt:g} N on the hand is not below stability.force_cap, "
            f"{scene.stability.force_cap:g} N",
            where=scene.where("operator", "palpate", "force"),
            mend=f"press with less than {scene.stability.force_cap / scene.mapping.force_scale:g} N, or raise the cap",
        )
    q0, n0 = (rows[0] for rows in surface.nearest(np.array([surface.top if o.at is None else o.at])))
    radius = scene.contact.radius
    depth = intended_depth(scene, index, n0)
    doubts.check_press(scene, index, _indentation(scene, index, n0), float(np.ptp(surface.bounds, axis=0).max()))
    hover, touch, inside = (q0 + n0 * (radius + h) for h in (o.hover, 0.0, -depth))

    along = np.array(o.direction) - n0 * (n0 @ o.direction)
    if np.linalg.norm(along) < 1e-6:
        along = np.cross(n0, np.eye(3)[int(np.argmin(np.abs(n0)))])
    along /= np.linalg.norm(along)
    across = np.cross(n0, along)
    count = max(2, round(o.slide / _SAMPLE))
    u = np.arange(1, count) / count
    travel = 0.5 * o.length * (1.0 - np.cos(2.0 * np.pi * u))  # there and back, with zero speed at both ends
    slides = []
    for k in range(_DIRECTIONS):
        angle = 2.0 * np.pi * k / _DIRECTIONS
        line = q0 + np.outer(travel, np.cos(angle) * along + np.sin(angle) * across)
        slide = _smooth(travel, *surface.nearest(line + 0.5 * o.hover * n0), radius - depth)
        slides.append(slide + np.outer(1.0 - travel / o.length, inside - slide[0]))  # starts where the press ends

    phases = np.cumsum([0.0, o.approach, o.press, o.slide, o.leave])
    period = float(phases[-1])
    turns = np.arange(max(1, min(int(_MAX_DURATION / period), max(_MIN_PERIODS, math.ceil(until / period) + 1))))
    start = period * turns[:, None]
    times = np.hstack([start, start + phases[1], start + phases[2], start + phases[2] + u * o.slide, start + phases[3]])
    strokes = np.stack([np.vstack([hover, touch, inside, slide, inside]) for slide in slides])
    positions = strokes[turns % _DIRECTIONS].reshape(-1, 3)
    names = tuple(zip(phases[:-1].tolist(), ("approach", "press", "slide", "leave"), strict=True))
    return HandPlan(np.append(times, times[-1, -1] + o.leave), np.vstack([positions, hover]), period, names)


def _smooth(travel: Array, q: Array, n: Array, offset: float) -> Array:
    """Fit a low-order polynomial in `travel` to the points q + offset n, (n, 3) [m].

    A hand does not follow facets, whose normals jump by degrees.
    """
    positions = q + offset * n
    fits = (np.polynomial.Chebyshev.fit(travel, positions[:, axis], _DEGREE) for axis in range(3))
    return np.stack([fit(travel) for fit in fits], axis=1)
