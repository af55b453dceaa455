"""Rest and smoothness of contacts that are large beside the elements, and deep.

A sphere is pressed, held, and led round a circle with friction. It spans .15 to 4 elements, in the cycle and on a
thread of its own, alone and beside a second sphere. At rest the force must be constant but for a drift. A jump is the
second difference of the force: what a smooth motion does not explain.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypedDict

import numpy as np

from palpate.base.arrays import Array
from palpate.world.tissue import PRESETS, Tissue
from palpate_lab.verify.bench.tissue.bodies import RESTLESS, Lab, chatter, layer_mesh
from palpate_lab.verify.bench.tissue.rows import Found, at_most

RADIUS = 6e-3  # [m]
RATIOS = (0.15, 0.3, 0.67, 1.0, 1.5, 2.0, 3.0, 4.0)
"""Radius of the sphere over the length of the cells."""
DEPTHS = (0.5, 1.0, 2.5)  # [radius]
FINE, SHALLOW = 2.0, 1.0
"""Beyond this ratio, only up to this depth [radius]: deeper bodies of so fine cells are too large for the cycle."""
PERIODS = (4e-3, 20e-3)  # of threads [s]
JUMP = 0.05  # [N] largest jump of the force
MU, MU_STATIC = 0.2, 0.6
DOWN, HOLD, LED = 400, 700, 1000  # ticks of the press, the rest and the circle

MATERIALS: Mapping[str, Mapping[str, Any]] = {
    "1 kPa": {"young": 1e3, "poisson": 0.45},
    "liver": {key: getattr(PRESETS["liver"], key) for key in ("young", "poisson", "density", "yeoh", "prony")},
    "20 kPa": {"young": 20e3, "poisson": 0.45, "prony": ((0.03, 0.05),)},
    "100 kPa": {"young": 100e3, "poisson": 0.45},
}


class Case(TypedDict):
    """One contact."""

    material: str
    ratio: float  #: radius of the sphere over the length of the cells
    depth: float  #: [radius]
    period: float  #: of the thread; 0: in the cycle [s]
    spheres: int
    force: float  #: mean at rest [N]
    rest: float  #: peak to peak at rest, without drift [N]
    jump: float  #: largest second difference, also while the tool moves [N]


def body(lab: Lab, ratio: float, depth: float, period: float, material: Mapping[str, Any]) -> Tissue:
    """A bonded layer that is thicker and wider than the dent."""
    cell = RADIUS / ratio
    thickness = max(3, round(max(3.2, 1.4 * depth) * ratio)) * cell
    half = min(max(2, round((2.2 + depth) * ratio)), 10) * cell
    nodes, tets = layer_mesh(thickness, cell, half)
    how = {"thread": "own", "period": period} if period else {"thread": "cycle"}
    return lab.make((nodes, tets), fixed=nodes[:, 2] < -thickness + 1e-9, **material, **how)


def path(ratio: float, depth: float) -> Array:
    """A press, a rest and a circle of .6 radii: positions (n, 3) of the sphere [m]."""

    def ease(n: int) -> Array:
        s = np.linspace(0.0, 1.0, n)
        return s * s * (3.0 - 2.0 * s)

    into = np.concatenate([ease(DOWN), np.ones(HOLD + LED)])
    angle = np.concatenate([np.zeros(DOWN + HOLD), 2.0 * np.pi * ease(LED)])
    cell, round_ = RADIUS / ratio, 0.6 * RADIUS
    x = 0.31 * cell + round_ * np.sin(angle)
    y = 0.17 * cell + round_ * (1.0 - np.cos(angle))
    return np.stack([x, y, RADIUS + 5e-4 - (depth * RADIUS + 5e-4) * into], axis=1)


def judge(lab: Lab, name: str, ratio: float, depth: float, period: float = 0.0, spheres: int = 1) -> Case:
    """Touch one body. A second sphere stands 1.2 radii beside the first."""
    soft = body(lab, ratio, depth, period, MATERIALS[name])
    more = [((1.2 * RADIUS, 0.0, 0.0), RADIUS)] * (spheres - 1)
    felt = lab.touch(soft, path(ratio, depth), radius=RADIUS, friction=MU, static_friction=MU_STATIC, spheres=more)
    rest = felt.force[DOWN + HOLD - 300 : DOWN + HOLD]
    return {
        "material": name,
        "ratio": ratio,
        "depth": depth,
        "period": period,
        "spheres": spheres,
        "force": float(np.linalg.norm(rest.mean(axis=0))),
        "rest": chatter(rest),
        "jump": float(np.linalg.norm(np.diff(felt.force, n=2, axis=0), axis=1).max()),
    }


def cases(short: bool) -> Iterator[tuple[str, float, float, float, int]]:
    """Arguments of `judge`."""
    if short:
        yield from (("liver", 1.5, 1.0, 0.0, 1), ("20 kPa", 1.0, 1.0, 4e-3, 1))
        return
    for name in MATERIALS:
        for ratio in RATIOS:
            yield from ((name, ratio, depth, 0.0, 1) for depth in DEPTHS if ratio <= FINE or depth <= SHALLOW)
    for name in ("liver", "20 kPa"):
        yield from ((name, ratio, depth, 0.0, 2) for ratio in (0.67, 1.5) for depth in DEPTHS)
        for period in PERIODS:
            yield from ((name, ratio, depth, period, 1) for ratio in (0.67, 1.5) for depth in DEPTHS)


def measure(lab: Lab, short: bool = False) -> Found:
    """All contacts, in the cycle and on threads."""
    table = [judge(lab, *case) for case in cases(short)]
    rows = []
    for where, mine in (
        ("in the cycle", [c for c in table if not c["period"]]),
        ("on a thread", [c for c in table if c["period"]]),
    ):
        rows.append(
            at_most(f"{where}, R / cell .15 to 4: peak to peak at rest", max(c["rest"] for c in mine), RESTLESS, "N")
        )
        rows.append(at_most(f"{where}, R / cell .15 to 4: jump in a tick", max(c["jump"] for c in mine), JUMP, "N"))
    return Found(tuple(rows), {"stillness": table})
