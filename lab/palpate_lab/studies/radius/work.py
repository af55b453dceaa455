"""The work of ``palpate study radius``."""

from __future__ import annotations

from functools import lru_cache
from typing import TypedDict, cast

import numpy as np
from rich.table import Table

from palpate import _core, _verify
from palpate.base.arrays import Array
from palpate.base.sweep import Axis, sweep
from palpate.base.sweep.grid import Point
from palpate.base.sweep.work import Values
from palpate.scene.contact import render
from palpate_lab.studies._command import Sweeper

RADII = (0.5e-3, 1e-3, 2e-3, 4e-3, 8e-3, 15e-3)  # [m]; the paper's figures show 15 mm
FEATURES = (2e-3, 4e-3, 8e-3, 16e-3)  # width of a ridge [m]
NOISES = (0.0, 0.02e-3, 0.05e-3, 0.1e-3, 0.2e-3, 0.5e-3)  # standard deviation along z [m]
RATE_CAPS = (5.0, 10.0, 20.0, 50.0)  # largest rates of the force filter [N/s]
GRID, SPEED, DEPTH, STIFFNESS, RATE = 0.5e-3, 0.05, 1e-3, 500.0, 1000.0  # [m], [m/s], [m], [N/m], [Hz]


class Errors(TypedDict):
    """Errors of the force by noise, relative to the force without noise. Percentiles are the 95th."""

    direction_deg: float  #: percentile of the direction error
    force_mN: float  #: percentile of the error of the magnitude
    bias_mN: float  #: mean error of the magnitude
    step_deg: float  #: percentile of the rotation within a millisecond
    step_mN: float  #: percentile of the change of the magnitude within a millisecond
    error_mN: float  #: percentile of the norm of the error vector
    filtered_mN: dict[str, float]  #: the same after a force filter, including its lag, by its rate cap [N/s]


class Measured(Errors):
    """Result of one point."""

    kept: float  #: rendered height of the relief over its true height, without noise [-]


class Row(Measured):
    """One radius on one relief with one noise. The keys are the documented contract of ``--json``."""

    radius_mm: float
    feature_mm: float  #: width of a ridge
    noise_mm: float  #: standard deviation


def run(
    radii: tuple[float, ...] = RADII,
    features: tuple[float, ...] = FEATURES,
    noises: tuple[float, ...] = NOISES,
    sweep: Sweeper = sweep,
) -> list[Row]:
    """Measure every radius on every relief with every noise."""
    grid = {
        "feature": Axis(features, "m", "width of a ridge"),
        "radius": Axis(radii, "m", "radius of the sphere"),
        "noise": Axis(noises, "m", "standard deviation of the vertices"),
    }
    return [_row_of(row) for row in sweep(measure, grid).rows()]


def _row_of(swept: Values) -> Row:
    lengths = {f"{name}_mm": 1e3 * swept.pop(name) for name in ("radius", "feature", "noise")}
    return cast(Row, lengths | swept)


def measure(point: Point, seed: int) -> Measured:
    """Measure one radius on one relief with one noise. The noise pattern does not depend on the seed."""
    feature, radius, noise = point["feature"], point["radius"], point["noise"]
    clean, height = _render(feature, 0.0, radius)
    force, _ = _render(feature, noise, radius)
    return {**_errors(clean, force), "kept": float(np.ptp(height) / (2 * amplitude(feature)))}


def amplitude(feature: float) -> float:
    """Amplitude of the relief whose ridges have the width ``feature`` [m]."""
    return feature / 5


def _relief(x: Array, feature: float) -> Array:
    return np.asarray(amplitude(feature) * np.cos(np.pi * x / feature))


def path(feature: float, radius: float) -> Array:
    """Positions of the tip (n, 3) over four ridges, ``DEPTH`` below a sphere that rolls over the true relief [m]."""
    length = 8 * feature
    x = np.arange(-length / 2, length / 2, SPEED / RATE)
    u = np.linspace(-1, 1, 801) * radius
    cap = np.sqrt(radius**2 - u**2)
    height = (_relief(x[:, None] + u, feature) + cap).max(axis=1)  # dilation of the relief by the sphere
    return np.stack([x, np.zeros_like(x), height - DEPTH], axis=1)


@lru_cache(16)
def _relief_mesh(feature: float, noise: float) -> _core.Mesh:
    half = (4 * feature + max(RADII) + 2e-3, max(RADII) + 2e-3)
    nx, ny = (int(2 * h / GRID) for h in half)
    x, y = (
        c.ravel()
        for c in np.meshgrid(*(np.linspace(-h, h, n) for h, n in zip(half, (nx, ny), strict=True)), indexing="ij")
    )
    z = _relief(x, feature) + noise * np.random.default_rng(1).normal(size=len(x))
    i, j = (c.ravel() for c in np.meshgrid(np.arange(nx - 1), np.arange(ny - 1), indexing="ij"))
    a, b, c, d = i * ny + j, (i + 1) * ny + j, (i + 1) * ny + j + 1, i * ny + j + 1
    triangles = np.stack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)], 1).reshape(-1, 3).astype(np.int32)
    return _core.Mesh(np.stack([x, y, z], axis=1), triangles)


@lru_cache(16)
def _render(feature: float, noise: float, radius: float) -> tuple[Array, Array]:
    """Force (n, 3) [N] and height of the proxy (n,) [m]; the tool first descends onto the start of the path."""
    tips = path(feature, radius)
    down = tips[0] + np.linspace(5e-3 + DEPTH, 0.0, 200)[:, None] * [0, 0, 1]
    mesh, approach = _relief_mesh(feature, noise), np.concatenate([down, tips])
    felt = render(mesh, approach, radius=radius, stiffness=STIFFNESS)
    return felt.force[len(down) :], felt.proxy[len(down) :, 2]


def _errors(clean: Array, force: Array) -> Errors:
    strength = np.linalg.norm(force, axis=1)
    more = strength - np.linalg.norm(clean, axis=1)
    return {
        "direction_deg": _p95(_angle_deg(force, clean)),
        "force_mN": _p95(1e3 * np.abs(more)),
        "bias_mN": float(1e3 * more.mean()),
        "step_deg": _p95(_angle_deg(force[1:], force[:-1])),
        "step_mN": _p95(1e3 * np.abs(np.diff(strength))),
        "error_mN": _off_mN(force, clean),
        "filtered_mN": {f"{cap:g}": _off_mN(rate_limited(force, cap), clean) for cap in RATE_CAPS},
    }


def rate_limited(force: Array, rate_cap: float) -> Array:
    """The force (n, 3) after the limiter of the loop with ``rate_cap`` [N/s], which starts settled."""
    options = _core.StabilityOptions()
    options.rate_cap, options.force_cap = rate_cap, 1e3
    limiter = _verify.Limiter(options, 1.0 / RATE)
    start = np.repeat(force[:1], int(np.linalg.norm(force[0]) / rate_cap * RATE) + 2, axis=0)
    limited = [limiter.step(F, i / RATE, i / RATE, i / RATE)[0] for i, F in enumerate(np.concatenate([start, force]))]
    return np.array(limited)[len(start) :]


def _off_mN(force: Array, clean: Array) -> float:
    return _p95(1e3 * np.linalg.norm(force - clean, axis=1))


def _p95(values: Array) -> float:
    return float(np.percentile(values, 95))


def _angle_deg(a: Array, b: Array) -> Array:
    return np.asarray(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))))


def table(rows: list[Row]) -> Table:
    """For each radius: rendered fraction of each feature, and force errors by each noise on the widest feature."""
    features = sorted({r["feature_mm"] for r in rows})
    noises = sorted({r["noise_mm"] for r in rows} - {0.0})
    out = Table(title="Radius, simulated: 50 mm/s, 1 mm deep, 500 N/m", box=None, padding=(0, 2, 0, 0), pad_edge=False)
    out.add_column("radius\nmm", justify="right")
    for f in features:
        out.add_column(f"kept of\n{f:g} mm", justify="right")
    for n in noises:
        out.add_column(f"noise {n:g} mm\ndeg / mN", justify="right")
    for radius in sorted({r["radius_mm"] for r in rows}):
        of = {(r["feature_mm"], r["noise_mm"]): r for r in rows if r["radius_mm"] == radius}
        kept = (f"{100 * next(r['kept'] for k, r in of.items() if k[0] == f):.0f} %" for f in features)
        left = (f"{of[features[-1], n]['direction_deg']:.1f} / {of[features[-1], n]['force_mN']:.0f}" for n in noises)
        out.add_row(f"{radius:g}", *kept, *left)
    return out
