"""`palpate bench guidance`: computing time of virtual fixtures.

The cases are a fixture on a mesh of a million triangles under a sliding tool, the middle line of a tube and the centre
of a ball, where (almost) all triangles are equally near, a quadratic program with a hundred constraints, and the whole
stage with a hundred hard fixtures that the hand pushes the tool against.
"""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np
from rich.table import Table

from palpate import _core, _guidance, _verify
from palpate.base.arrays import Array
from palpate.world.shapes.analytic import SHAPES
from palpate.world.shapes.paths import tool_path

TRIANGLES, CONSTRAINTS, TICKS = 1_000_000, 100, 20_000
RATE = 1000.0  # [Hz]
WARM_UP = 200  # first ticks that are not timed
BUDGET = {
    "fixture_added_p99_us": 10.0,
    "hard_fixture_added_p99_us": 10.0,
    "tube_hard_added_p99_us": 50.0,
    "ball_hard_added_p99_us": 50.0,
    "qp_p99_us": 200.0,
    "qp_contradictory_p99_us": 200.0,
}
"""Largest accepted times."""


def run(
    triangles: int = TRIANGLES, ticks: int = TICKS, on_progress: Callable[[str], None] = lambda _: None
) -> dict[str, float]:
    """Measure; the result has the keys of `palpate bench guidance` in docs/json.md."""
    shape = SHAPES["torus"]
    on_progress(f"a mesh of {triangles:,} triangles")
    mesh = _core.Mesh(*shape.mesh(triangles))
    geometry = _guidance.SurfaceGeometry(mesh)
    X_WT = _poses(tool_path(shape, -1e-3, 0.05, 2e-3).tips, ticks)
    out: dict[str, float] = {"triangles": mesh.triangle_count, "constraints": CONSTRAINTS, "ticks": ticks}
    out |= {"cores": os.cpu_count() or 1, "load": os.getloadavg()[0]}
    on_progress(f"{ticks:,} ticks over it")
    out |= _percentiles("query", _verify.time_query(geometry, X_WT))
    empty = _verify.time_guidance(_guidance.Fixtures([]), X_WT, 1.0 / RATE)
    out |= _percentiles("stage_empty", empty)
    for name, hard in (("fixture", False), ("hard_fixture", True)):
        policy = _core.Policy()
        policy.hard = hard
        fixtures = _guidance.Fixtures([_guidance.Fixture("mesh", geometry, "forbid", policy=policy)])
        took = _verify.time_guidance(fixtures, X_WT, 1.0 / RATE)
        out |= _percentiles(f"{name}_added", took - np.median(empty))
    out |= _medial(triangles, ticks, float(np.median(empty)), on_progress)
    on_progress(f"{CONSTRAINTS} constraints")
    out |= _percentiles("qp", _verify.time_qp(*_programs(ticks)))
    A, b, y0 = _programs(ticks)
    out |= _percentiles("qp_contradictory", _verify.time_qp(A, -b, y0))
    out |= _percentiles("hundred_hard", _verify.time_guidance(polytope(), around(ticks), 1.0 / RATE))
    return out | {"kept": all(out[key] <= most for key, most in BUDGET.items())}


def table(result: dict[str, float]) -> Table:
    """The result as a table for a terminal."""
    labels = {
        "query": f"nearest place of a mesh of {result['triangles']:,} triangles",
        "fixture_added": "a soft fixture on it adds to the stage",
        "hard_fixture_added": "a hard fixture on it adds to the stage",
        "tube_query": "exact nearest place from the middle line of a tube",
        "tube_hard_added": "a hard keep-in adds on the middle line of the tube",
        "ball_hard_added": "a hard keep-in adds at the centre of a ball",
        "qp": f"quadratic program, {result['constraints']} constraints, from scratch",
        "qp_contradictory": "the same, rows that contradict each other in every way",
        "hundred_hard": f"the whole stage with {result['constraints']} hard fixtures",
        "stage_empty": "the stage without a fixture",
    }
    out = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False)
    out.add_column("")
    for column in ("p50 us", "p99 us", "promised"):
        out.add_column(column, justify="right")
    for key, words in labels.items():
        most = BUDGET.get(f"{key}_p99_us")
        figures = (f"{result[f'{key}_{p}_us']:.2f}" for p in ("p50", "p99"))
        out.add_row(words, *figures, "" if most is None else f"{most:g}")
    out.caption = f"load of the machine {result['load']:.1f} on {result['cores']} cores"
    return out


def tube(triangles: int, radius: float = 0.004, length: float = 0.1) -> tuple[Array, Array]:
    """A closed tube (lumen) along z around the origin: vertices (n, 3) [m] and triangles (m, 3), m near `triangles`."""
    around = max(8, round(np.sqrt(triangles)))
    rings = max(2, triangles // (2 * around))
    angle = 2.0 * np.pi * np.arange(around) / around
    z = length * (np.arange(rings + 1) / rings - 0.5)
    ring = radius * np.c_[np.cos(angle), np.sin(angle)]
    v = np.c_[np.tile(ring, (rings + 1, 1)), np.repeat(z, around)]
    a = np.add.outer(around * np.arange(rings), np.arange(around)).ravel()
    b = np.add.outer(around * np.arange(rings), (np.arange(around) + 1) % around).ravel()
    side = np.r_[np.c_[a, b, a + around], np.c_[b, b + around, a + around]]
    i, j, low, high = np.arange(around), (np.arange(around) + 1) % around, len(v), len(v) + 1
    caps = np.r_[
        np.c_[np.full(around, low), j, i], np.c_[np.full(around, high), rings * around + i, rings * around + j]
    ]
    return np.r_[v, [[0.0, 0.0, z[0]], [0.0, 0.0, z[-1]]]], np.r_[side, caps].astype(np.int32)


def _medial(triangles: int, ticks: int, empty_us: float, on_progress: Callable[[str], None]) -> dict[str, float]:
    """Times on the middle line of a tube, along which the tool moves at 50 mm/s, and around the centre of a ball."""
    out: dict[str, float] = {}
    z = 0.03 * np.sin(np.arange(ticks) / RATE / 0.6)
    paths = {"tube": np.c_[0.0 * z, 0.0 * z, z], "ball": 1e-3 * np.c_[z, 0.0 * z, 0.0 * z]}
    for name, made in (("tube", tube(triangles)), ("ball", SHAPES["sphere"].mesh(triangles))):
        on_progress(f"the middle of a {name} of as many triangles")
        geometry, X_WT = _guidance.SurfaceGeometry(_core.Mesh(*made)), _poses(paths[name], ticks)
        if name == "tube":
            out |= _percentiles("tube_query", _verify.time_query(geometry, X_WT))
        policy = _core.Policy()
        policy.hard = True
        fixtures = _guidance.Fixtures([_guidance.Fixture(name, geometry, "keep-in", policy=policy)])
        out |= _percentiles(f"{name}_hard_added", _verify.time_guidance(fixtures, X_WT, 1.0 / RATE) - empty_us)
    return out


def _percentiles(name: str, us: Array) -> dict[str, float]:
    p50, p99 = np.percentile(us[WARM_UP:], [50, 99])
    return {f"{name}_p50_us": float(p50), f"{name}_p99_us": float(p99)}


def _poses(p: Array, ticks: int) -> Array:
    X = np.tile(np.eye(4), (ticks, 1, 1))
    X[:, :3, 3] = np.resize(p, (ticks, 3))
    return X


def _programs(n: int) -> tuple[Array, Array, Array]:
    """Random half-spaces A (n, m, 6), b (n, m) that all contain the origin, and start points (n, 6) outside many."""
    rng = np.random.default_rng(1)
    A = rng.normal(size=(n, CONSTRAINTS, 6))
    A /= np.linalg.norm(A, axis=2, keepdims=True)
    return A, -rng.uniform(0.1, 1.0, (n, CONSTRAINTS)), 2.0 * rng.normal(size=(n, 6))


def polytope(count: int = CONSTRAINTS) -> _guidance.Fixtures:
    """`count` forbidden half-spaces around a ball of 3 cm radius, which confine the tool."""
    rng = np.random.default_rng(2)
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    policy = _core.Policy()
    policy.hard = True
    return _guidance.Fixtures(
        [_guidance.Fixture(f"wall {i}", _wall(n), "forbid", policy=policy) for i, n in enumerate(normals)]
    )


def _wall(n: Array) -> _guidance.Geometry:
    """The half-space beyond 3 cm along n (3,); the ball is outside this half-space."""
    from palpate.scene.guidance.curve import frames_along

    X = np.eye(4)
    X[:3, :3] = frames_along(np.zeros((1, 3)), -n[None])[0]
    X[:3, 3] = 0.03 * n
    return _guidance.PlacedGeometry(_guidance.SurfaceGeometry(_core.Plane()), X)


def around(ticks: int) -> Array:
    """Poses (ticks, 4, 4) that oscillate between the centre and 1 cm beyond the walls in changing directions."""
    t = np.arange(ticks) / RATE
    r = 0.04 * np.sin(0.5 * t)
    return _poses(r[:, None] * np.c_[np.cos(1.3 * t), np.sin(1.3 * t) * np.cos(0.7 * t), np.sin(0.7 * t)], ticks)
