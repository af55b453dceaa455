"""The four tasks of `palpate study guidance`: touched object, path, guidance and measures.

Lengths are in metres in W. The touched object exists in every condition; the guidance is a list as in a scene file. The
measures are computed in numpy from the true path and the true forbidden region, never from the guidance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate.base.arrays.polyline import distance, evenly
from palpate.base.arrays.so3 import unit
from palpate.simulators.operators import Errand
from palpate_lab.studies.guidance.result import Purpose

RADIUS = 0.002
"""Radius of the tool's sphere [m]."""
SCALE = 0.5
"""Tool motion per hand motion [-]."""
OFFSET_AXIS = np.array([0.0, 1.0, 0.0])
"""Direction (unit vector) in which misplaced guidance is displaced."""
KEPT = 0.001
"""Radius of the tube around the path that hard guidance keeps the tool in [m]."""


@dataclass(frozen=True)
class Task:
    """A task with its object, guidance and measures."""

    title: str
    errand: Errand
    touched: Content
    """The touched object in a scene; it is replaced by the mesh of `surface` if given."""
    guidance: Callable[[Array, bool], list[Content]]
    """Fixtures for a displacement (3,) [m] of the path, soft or hard; hard fixtures keep the tool in or out."""
    outside: Callable[[Array], Array]
    """Depth (n,) [m] of tool positions (n, 3) in the forbidden region, negative outside the region."""
    off: Callable[[Array], Array]
    """Path error (n,) [m] of tool positions (n, 3)."""
    surface: Callable[[], _core.Mesh] | None = None
    purpose: Purpose = "path_error_mm"
    """The measure at which the guidance aims."""

    @cached_property
    def start(self) -> Array:
        """Start position of the tool (3,) [m]."""
        lift = -0.001 * np.array(self.errand.into) if self.errand.press > 0.0 else 0.0
        return np.asarray(self.errand.path[0] + lift)

    def scene(self) -> Content:
        """Content of a scene file without guidance; the simulated hand rests at the start of the task."""
        return {
            "objects": [self.touched | {"damping": 1.0}],
            "mapping": {"scale": SCALE},
            "contact": {"radius": RADIUS},
            "rates": {"plant": 2000.0},
            "stability": {"force_cap": 6.0, "rate_cap": 50.0},
            "operator": {"path": [{"t": 0.0, "xyz": self.start.tolist()}]},
        }


def sleeve(path: Array, inner: Array, thickness: float, sides: int = 24) -> _core.Mesh:
    """A closed tube mesh along a path (n, 3) with inner radii (n,) and a solid wall of ``thickness`` [m]."""
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    side = np.cross(along, [0.0, 0.0, 1.0]) if abs(along[0, 2]) < 0.9 else np.cross(along, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(side, along)
    turn = 2 * np.pi * np.arange(sides) / sides
    circle = np.cos(turn)[:, None] * side[:, None, :] + np.sin(turn)[:, None] * up[:, None, :]  # (n, sides, 3)
    rings = [path[:, None] + r[:, None, None] * circle for r in (inner, inner + thickness)]
    vertices = np.concatenate([ring.reshape(-1, 3) for ring in rings])
    n, k = len(path), np.arange(sides)
    nxt, quads = (k + 1) % sides, []
    for i in range(n - 1):
        for wall, flip in ((0, False), (n * sides, True)):
            a, b = wall + i * sides + k, wall + i * sides + nxt
            quads.append((a, b, b + sides, a + sides) if not flip else (a, a + sides, b + sides, b))
    for i, flip in ((0, True), (n - 1, False)):
        a, b, out = i * sides + k, i * sides + nxt, n * sides
        quads.append((a, b, b + out, a + out) if not flip else (a, a + out, b + out, b))
    corners = [np.stack([q[0], q[1], q[2]], 1) for q in quads] + [np.stack([q[0], q[2], q[3]], 1) for q in quads]
    triangles = np.concatenate(corners).astype(np.int32)
    return _core.Mesh(vertices, triangles)


def _waypoints(path: Array, offset: Array, every: int = 10) -> list[list[float]]:
    kept = np.concatenate([path[:-1:every], path[-1:]])
    return [[float(v) for v in point] for point in kept + offset]


def ring_on_wire() -> Task:
    """Move a ring of 6 mm inner diameter along a wire of 2 mm; its centre has 2 mm of clearance to every side."""
    u, clear = np.linspace(0.0, 1.0, 400), 0.002
    curve = [0.04 * (u - 0.5), 0.004 * np.sin(2 * np.pi * u), 0.03 + 0.005 * np.sin(np.pi * (u - 0.2))]
    wire = evenly(np.column_stack(curve))
    ends = 0.008 * unit(wire[1] - wire[0]), 0.008 * unit(wire[-1] - wire[-2])
    hose = evenly(np.concatenate([wire[:1] - ends[0], wire, wire[-1:] + ends[1]]), 0.0015)
    return Task(
        "ring on a wire",
        Errand(wire, np.full(len(wire), 2 * clear), 1500.0),
        {"box": {"size": [0.08, 0.03, 0.03]}, "stiffness": 1500.0, "pose": {"xyz": [0.0, 0.0, 0.012]}},
        lambda offset, hard: [_follow(wire, offset, hard)],
        lambda p: distance(p, wire)[0] - clear,
        lambda p: distance(p, wire)[0],
        lambda: sleeve(hose, np.full(len(hose), clear + RADIUS), 0.004),
    )


def tracing() -> Task:
    """Trace a curve on soft tissue with 0.5 N; everything more than 1.5 mm from the curve is forbidden."""
    u, press, K = np.linspace(0.0, 1.0, 400), 0.5, 400.0
    curve = [0.04 * (u - 0.5), 0.004 * np.sin(3 * np.pi * u), np.full(len(u), RADIUS - press / K)]
    line = evenly(np.column_stack(curve))
    return Task(
        "line on soft tissue",
        Errand(line, np.full(len(line), 0.003), K, press),
        {"plane": {"size": 0.1}, "stiffness": K},
        lambda offset, hard: [_follow(line, offset, hard)],
        lambda p: _flat(p, line) - 0.0015,
        lambda p: _flat(p, line),
    )


def palpation() -> Task:
    """Palpate with 1 N along a vessel on the tissue; everything nearer than 3 mm to its wall is forbidden."""
    press, K, vessel, margin = 1.0, 400.0, 0.002, 0.003
    near = -vessel - margin - 0.0004
    corners = np.array([[-0.016, -0.016], [near, -0.012], [near, 0.012], [-0.016, 0.016]])
    z = RADIUS - press / K
    line = evenly(np.column_stack([corners, np.full(len(corners), z)]))

    def guidance(offset: Array, hard: bool) -> list[Content]:
        return [
            {
                "name": "vessel",
                "role": {"name": "forbid", "margin": margin},
                "geometry": {"cylinder": {"radius": vessel, "length": 0.1}},
                "frame": {"pose": {"xyz": [-float(offset[1]), 0.0, 0.0], "rpy_deg": [90.0, 0.0, 0.0]}},
                "law": {"stiffness": 1000.0, "damping": 4.0},
                "hard": hard,
            }
        ]

    return Task(
        "palpation near a vessel",
        Errand(line, np.full(len(line), 0.003), K, press),
        {"plane": {"size": 0.1}, "stiffness": K},
        guidance,
        lambda p: vessel + margin - np.hypot(p[:, 0], p[:, 2]),
        lambda p: _flat(p, line),
        purpose="entries",
    )


def insertion() -> Task:
    """Insert along a narrowing passage: 7 mm of clearance to every side at the entry, 1.2 mm at the target."""
    entry, target = np.array([0.0, 0.0, 0.050]), np.array([0.012, 0.006, 0.010])
    axis, length = unit(target - entry), float(np.linalg.norm(target - entry))
    line, wide, narrow = evenly(np.array([entry, target])), 0.007, 0.0012

    def clear(p: Array) -> Array:
        return np.asarray(narrow + (wide - narrow) * np.clip(1.0 - (p - entry) @ axis / length, 0.0, 1.2))

    beyond = evenly(np.array([entry - 0.004 * axis, target + 0.006 * axis]), 0.002)

    return Task(
        "insertion to a target",
        Errand(line, 2 * clear(line), 800.0),
        {"box": {"size": [0.04, 0.04, 0.03]}, "stiffness": 800.0, "pose": {"xyz": [0.006, 0.003, 0.022]}},
        lambda offset, hard: [_follow(line, offset, hard)],
        lambda p: distance(p, line)[0] - clear(p),
        lambda p: distance(p, line)[0],
        lambda: sleeve(beyond, clear(beyond) + RADIUS, 0.006),
    )


def _follow(path: Array, offset: Array, hard: bool) -> Content:
    """Guidance for a path: an attracting fixture, or a hard tube around the path."""
    if hard:
        return {
            "name": "path",
            "role": "keep-in",
            "geometry": {"tube": {"waypoints": _waypoints(path, offset), "radius": KEPT}},
            "law": {"stiffness": 600.0, "damping": 4.0},
            "hard": True,
        }
    return {
        "name": "path",
        "role": "guide",
        "geometry": {"path": {"waypoints": _waypoints(path, offset)}},
        "law": {"stiffness": 600.0, "damping": 4.0},
    }


def _flat(p: Array, path: Array) -> Array:
    """Horizontal distance (n,) to the path, without the height [m]."""
    flat = np.array([1.0, 1.0, 0.0])
    return distance(p * flat, path * flat)[0]


#: Tasks by name.
TASKS: dict[str, Callable[[], Task]] = {
    "ring": ring_on_wire,
    "tracing": tracing,
    "palpation": palpation,
    "insertion": insertion,
}
