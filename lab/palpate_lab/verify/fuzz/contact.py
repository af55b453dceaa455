"""Random triangle soups and tool paths: every contact method must return a finite, bounded force."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from palpate import _core, _verify
from palpate.base.arrays import Array
from palpate.scene.contact import render
from palpate.scene.contact_method import METHODS
from palpate.world.shapes.analytic import SHAPES
from palpate_lab.verify.fuzz import FaultError

Soup = tuple[Array, NDArray[np.int32]]

RATE = 1000.0  # [Hz]


def case(seed: int) -> dict[str, int]:
    """Check one mesh, one path and one method, all derived from the seed.

    Raises:
        FaultError: a force is not finite, is larger than the deflection allows, or exceeds the cap after the limiter.
    """
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-6, 6)  # [m]
    vertices, triangles = _mesh(rng)
    kind = "sound"
    try:
        mesh = _core.Mesh(size * vertices, triangles)
    except ValueError:
        return {"refused": 1}
    if not mesh.report.closed:
        kind = "open"
    extent = float(np.linalg.norm(mesh.report.highest - mesh.report.lowest))
    radius = extent * 10.0 ** rng.uniform(-4, 0)
    tips = _path(rng, np.array(mesh.vertices), extent)
    stiffness = 10.0 ** rng.uniform(0, 4)
    method = METHODS[rng.integers(len(METHODS))] if rng.uniform() < 0.3 else "proxy"
    friction = float(rng.choice([0.0, rng.uniform(0, 2)]))
    felt = render(mesh, tips, radius=radius, stiffness=stiffness, friction=friction, method=method)
    for name in ("force", "normal", "depth", "proxy"):
        if not np.isfinite(getattr(felt, name)).all():
            row = int(np.argmin(np.isfinite(getattr(felt, name)).reshape(len(tips), -1).all(axis=1)))
            raise FaultError(f"{method}: {name} is not finite at tip {row}")
    # The proxy starts at the tool or at the nearest surface point and only follows, so its distance is bounded.
    reach = (extent + 2 * radius + float(np.linalg.norm(np.ptp(tips, axis=0)))) * (1 + friction)
    strength = np.linalg.norm(felt.force, axis=1)
    if strength.max() > stiffness * reach:
        raise FaultError(f"{method}: {strength.max():g} N, the deflection allows at most {stiffness * reach:g} N")
    if method == "proxy":
        _in_cone(felt.force, felt.normal, stiffness * felt.depth, friction, stiffness * reach)
    _limited(felt.force)
    return {kind: 1, method: 1, "touched": int(strength.any()), "ticks": len(tips)}


def _in_cone(force: Array, normal: Array, along: Array, friction: float, size: float) -> None:
    """The force (n, 3) is `along` (n,) on the normal and within the friction cone [N]; size: of rounding errors [N]."""
    sideways = np.linalg.norm(force - (force * normal).sum(axis=1)[:, None] * normal, axis=1)
    over = sideways - friction * along
    if over.max() > 1e-9 * size:
        k = int(over.argmax())
        raise FaultError(f"proxy: {sideways[k]:g} N sideways at tip {k}, friction allows {friction * along[k]:g} N")


def _limited(force: Array) -> None:
    """The limited force respects the force cap and the rate cap."""
    options = _core.StabilityOptions()
    limiter, before = _verify.Limiter(options, 1.0 / RATE), np.zeros(3)
    for i in range(0, len(force), 7):
        t = i / RATE
        F = np.asarray(limiter.step(force[i], t, t, t)[0])
        if not np.isfinite(F).all() or np.linalg.norm(F) > options.force_cap * (1 + 1e-9):
            raise FaultError(f"limiter: {F} N at tick {i} is above the cap of {options.force_cap} N")
        if np.linalg.norm(F - before) > options.rate_cap / RATE * (1 + 1e-9):
            raise FaultError(f"limiter: {np.linalg.norm(F - before):g} N in a tick, more than the rate cap allows")
        before = F


def _mesh(rng: np.random.Generator) -> Soup:
    """A mesh of about unit size: soup, slivers, fan, lattice or distorted solid, with duplicated triangles."""
    n = int(rng.integers(1, 120))
    kind = rng.integers(0, 8)
    if kind > 4:  # a distorted solid with some triangles flipped or missing
        shape = SHAPES[sorted(SHAPES)[rng.integers(len(SHAPES))]]
        v, t = shape.mesh(int(rng.integers(12, 400)))
        v = v / np.abs(v).max() + 10.0 ** rng.uniform(-9, -0.5) * rng.normal(size=v.shape)
        t = t[rng.uniform(size=len(t)) >= rng.choice([0.0, 0.2])]
        return v, np.where(rng.uniform(size=(len(t), 1)) < rng.choice([0.0, 0.3]), t[:, ::-1], t)
    if kind == 0:  # a lattice: repeated vertices, coplanar and degenerate triangles, non-manifold edges
        v = rng.integers(-2, 3, (n + 2, 3)) / 2.0
        return v, rng.integers(0, n + 2, (n, 3)).astype(np.int32)
    v = rng.normal(size=(3 * n, 3)) / 2
    t = np.arange(3 * n, dtype=np.int32).reshape(-1, 3)
    if kind == 1:  # needles and caps
        thin = 10.0 ** rng.uniform(-17, -3)
        v[1::3] = v[0::3] + rng.uniform(size=(n, 1)) * (v[2::3] - v[0::3]) + thin * rng.normal(size=(n, 3))
    elif kind == 2:  # a fan around one edge
        t[:, :2] = t[0, :2]
    elif kind == 3:  # triangle sizes from 1 to 1e-6
        v = v[t[:, :1].repeat(3)] + np.repeat(10.0 ** rng.uniform(-6, 0, (n, 1)), 3, axis=0) * v
    extra = t[rng.integers(0, n, n // 3)]
    return v, np.concatenate([t, extra, extra[:, ::-1]]).astype(np.int32)


def _path(rng: np.random.Generator, vertices: Array, extent: float) -> Array:
    """A tool path (n, 3): jumps, a straight line, jumps between vertices, or a random walk."""
    n, kind = int(rng.integers(2, 150)), rng.integers(0, 4)
    middle = vertices.mean(axis=0)
    if kind == 0:  # jumps
        return np.asarray(middle + extent * rng.normal(size=(n, 3)))
    if kind == 1:  # straight through
        a, b = middle + extent * rng.normal(size=(2, 3))
        return np.asarray(a + np.linspace(0, 1, n)[:, None] * (b - a))
    if kind == 2:  # from vertex to vertex, exactly
        return np.asarray(vertices[rng.integers(0, len(vertices), n)])
    step = extent * 10.0 ** rng.uniform(-4, -1)
    return np.asarray(vertices[rng.integers(len(vertices))] + np.cumsum(step * rng.normal(size=(n, 3)), axis=0))
