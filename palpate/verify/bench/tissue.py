"""``palpate bench tissue``: time of soft bodies, and the force of a sphere on a layer against its closed form."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any, TypedDict

import numpy as np
from rich.table import Table

from palpate.arrays import Array
from palpate.contact import render
from palpate.tissue import Tissue, indentation
from palpate.tissue.blocks import block
from palpate.verify.bench import tissue_thread

YOUNG, POISSON = 5000.0, 0.45
TICK = 1e-3  # [s]
SIZES = {"1k": (7, 7, 4), "5k": (12, 12, 6), "7k": (14, 14, 6), "18k": (20, 20, 8)}
"""Cells of blocks with cells of 10 mm, six tetrahedra each."""
LAYERS = ((2e-3, 5e-3, 1.25e-3), (5e-3, 10e-3, 2.5e-3), (10e-3, 10e-3, 2.5e-3))
"""Radius of the sphere, thickness of the layer, length of the cells [m]."""
COARSE = (5e-3, 10e-3, 5e-3)
"""The same for MuJoCo, which does not solve finer layers."""
DEPTHS = (0.1, 0.25, 0.5)  # [radius]
DEEPEST = 0.25  # [thickness]; deeper, small strain is no reference
PRONY = ((0.3, 0.02), (0.2, 0.2), (0.1, 2.0))


class Times(TypedDict):
    """Times of a tick [ms]."""

    p50: float
    p99: float


class Case(TypedDict):
    """Force on a layer."""

    radius: float  #: [m]
    thickness: float  #: [m]
    cell: float  #: [m]
    depth: float  #: [m]
    force: float  #: [N]
    expected: float  #: exact force on a bonded layer at small strain [N]
    ripple: float  #: largest difference over places between two nodes, relative to the force [-]


class MuJoCo(TypedDict):
    """MuJoCo's flex on the same mesh."""

    tets: int
    tick_ms: Times
    layer_error: float  #: largest of two places, on a node and in the middle of a face, relative [-]


class Figures(TypedDict):
    """The keys are the documented contract of ``--json``."""

    tick_ms: dict[str, Times]  #: by the number of tetrahedra: contact, force and body with three Prony terms
    control_ms: Times  #: sorting 20,000 numbers, next to the measurements
    layer_error: float  #: largest error of the force on a layer, relative [-]
    ripple: float  #: largest ripple [-]
    cases: list[Case]
    threads: list[tissue_thread.Apart]  #: bodies on a thread beside the same in the cycle
    real_time: list[tissue_thread.RealTime]  #: missed ticks
    mujoco: MuJoCo | None  #: null where MuJoCo is not installed


def layer(thickness: float, cell: float, half: float, **material: Any) -> Tissue:
    """A layer between z = -thickness and 0, bonded to the ground and free at its sides [m]."""
    across, down = max(2, round(2 * half / cell)), max(2, round(thickness / cell))
    nodes, tets = block((across, across, down), (across * cell, across * cell, thickness))
    nodes = nodes - [across * cell / 2, across * cell / 2, thickness]
    material = {"young": YOUNG, "poisson": POISSON, **material}
    return Tissue((nodes, tets), fixed=nodes[:, 2] < -thickness + 1e-9, **material)


def pressed(radius: float, depth: float, at: Sequence[float], down: float = 0.3, hold: float = 0.2) -> Array:
    """Positions (n, 3) of a sphere's centre that is pressed into the plane z = 0 and rests there [m]."""
    s = np.linspace(0.0, 1.0, round(down / TICK))
    rise = np.concatenate([s * s * (3.0 - 2.0 * s), np.ones(round(hold / TICK))])
    z = radius + 0.5e-3 - (depth + 0.5e-3) * rise
    return np.stack([np.full_like(z, at[0]), np.full_like(z, at[1]), z], axis=1)


def steady(soft: Tissue, radius: float, depth: float, at: Sequence[float] = (0.0, 0.0)) -> float:
    """Force on a sphere at rest at ``depth`` [N]."""
    return float(render(soft, pressed(radius, depth, at), radius=radius).force[-20:, 2].mean())


def layer_cases(
    layers: Sequence[tuple[float, float, float]] = LAYERS, places: int = 3, depths: Sequence[float] = DEPTHS
) -> list[Case]:
    """Forces on layers at ``depths`` [radius]; the ripple is measured at ``places`` from a node to the middle of its
    cell."""
    cases: list[Case] = []
    for radius, thickness, cell in layers:
        soft = layer(thickness, cell, max(2.0 * thickness, 2.5 * radius))
        for depth in (share * radius for share in depths if share * radius <= DEEPEST * thickness + 1e-12):
            at = [(cell * k / (2 * (places - 1)), 0.7 * cell * k / (2 * (places - 1))) for k in range(places)]
            forces = np.array([steady(soft, radius, depth, p) for p in at])
            cases.append(
                {
                    "radius": radius,
                    "thickness": thickness,
                    "cell": cell,
                    "depth": depth,
                    "force": float(forces[0]),
                    "expected": float(indentation.layer(radius, depth, YOUNG, POISSON, thickness)),
                    "ripple": float(np.ptp(forces) / forces.mean()),
                }
            )
    return cases


def tick_times(cells: tuple[int, int, int], ticks: int = 1500) -> tuple[int, Times]:
    """Number of tetrahedra of a block, and times of a tick with a sphere that presses and slides."""
    size = np.array(cells) * 0.01
    nodes, tets = block(cells, size)
    soft = Tissue(
        (nodes, tets), young=YOUNG, poisson=POISSON, prony=PRONY, yeoh=0.5, fixed=nodes[:, 2] == 0.0, thread="cycle"
    )
    tips = pressed(5e-3, 5e-3, (0.5 * size[0], 0.5 * size[1]), 0.3, ticks * TICK - 0.3)
    tips[:, 2] += size[2]
    tips[:, 0] += 0.02 * np.sin(np.arange(len(tips)) * TICK * 2.0 * np.pi)
    latency = render(soft, tips, radius=5e-3).latency[100:]
    return len(tets), _times(latency)


def control(rounds: int = 400) -> Times:
    """Times of a computation that is not Palpate's: sorting 20,000 numbers."""
    values = np.random.default_rng(0).normal(size=20_000)
    spent = []
    for _ in range(rounds):
        begin = time.perf_counter()
        np.sort(values)
        spent.append(time.perf_counter() - begin)
    return _times(np.array(spent))


def mujoco_figures() -> MuJoCo | None:
    """MuJoCo on a coarse layer; None where it is not installed."""
    try:
        from palpate.verify.bench import tissue_mujoco as other

        radius, thickness, cell = COARSE
        soft = layer(thickness, cell, 2.5 * thickness)
        fixed = soft.nodes[:, 2] < -thickness + 1e-9
        start = np.array([0.0, 0.0, radius + 1e-3])
        built = other.model(soft, fixed, YOUNG, POISSON, radius, start)
    except ImportError:
        return None
    expected = float(indentation.layer(radius, 0.25 * radius, YOUNG, POISSON, thickness))
    found = [other.press(built, radius, 0.25 * radius, at) for at in ((0.0, 0.0), (0.5 * cell, 0.25 * cell))]
    errors = [force / expected - 1.0 for force, _ in found]
    times = np.concatenate([spent for _, spent in found])
    return {"tets": len(soft.tets), "tick_ms": _times(times), "layer_error": max(errors, key=abs)}


def run(sizes: Sequence[str] = tuple(SIZES)) -> Figures:
    """Measure everything."""
    ticks = dict(tick_times(SIZES[size]) for size in sizes)
    cases = layer_cases()
    return {
        "tick_ms": {str(tets): times for tets, times in ticks.items()},
        "control_ms": control(),
        "layer_error": max(abs(c["force"] / c["expected"] - 1.0) for c in cases),
        "ripple": max(c["ripple"] for c in cases),
        "cases": cases,
        "threads": [tissue_thread.apart(young) for young in tissue_thread.YOUNG],
        "real_time": [tissue_thread.real_time(SIZES[n], t) for n, t in (("7k", "cycle"), ("18k", "own"))],
        "mujoco": mujoco_figures(),
    }


def table(figures: Figures) -> Table:
    """The figures as a table."""
    out = Table("measured", "value", box=None)
    for tets, times in figures["tick_ms"].items():
        out.add_row(f"tick of {int(tets):,} tetrahedra, p50 / p99", f"{times['p50']:.3f} / {times['p99']:.3f} ms")
    control_ms = figures["control_ms"]
    out.add_row("control: 20,000 numbers sorted", f"{control_ms['p50']:.3f} / {control_ms['p99']:.3f} ms")
    for case in figures["cases"]:
        lengths = (1e3 * case[k] for k in ("radius", "thickness", "depth"))
        error = case["force"] / case["expected"] - 1.0
        name = "R {:g}, layer {:g}, depth {:g} mm: error, ripple".format(*lengths)
        out.add_row(name, f"{100 * error:+.1f} %, {100 * case['ripple']:.2f} %")
    tissue_thread.add_rows(out, figures["threads"], figures["real_time"])
    if (other := figures["mujoco"]) is not None:
        times = other["tick_ms"]
        out.add_row(f"MuJoCo, {other['tets']:,} tetrahedra, p50 / p99", f"{times['p50']:.1f} / {times['p99']:.1f} ms")
        out.add_row("MuJoCo: error on a coarse layer", f"{100 * other['layer_error']:+.0f} %")
    return out


def _times(seconds: Array) -> Times:
    p50, p99 = np.percentile(1e3 * seconds, [50, 99])
    return {"p50": float(p50), "p99": float(p99)}
