"""Force of a sphere on a bonded layer at small strain, against its exact solution, and its ripple over the mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

import numpy as np

from palpate.world.tissue import indentation
from palpate_lab.verify.bench.tissue.bodies import POISSON, YOUNG, Lab
from palpate_lab.verify.bench.tissue.rows import Found, at_most

LAYERS = ((2e-3, 5e-3, 1.25e-3), (5e-3, 10e-3, 2.5e-3), (10e-3, 10e-3, 2.5e-3), (10e-3, 10e-3, 2e-3))
"""Radius of the sphere, thickness of the layer, length of the cells [m]. A layer as thin as the sphere's radius shows
where the load of a contact is spread wider than its circle: on two meshes."""
DEPTHS = (0.1, 0.25, 0.5)  # [radius]
DEEPEST = 0.25  # [thickness]; deeper, small strain is no reference


class Case(TypedDict):
    """Force on a layer."""

    radius: float  #: [m]
    thickness: float  #: [m]
    cell: float  #: [m]
    depth: float  #: [m]
    force: float  #: [N]
    expected: float  #: exact force on a bonded layer at small strain [N]
    ripple: float  #: largest difference over places between two nodes, relative to the force [-]


def layer_cases(
    layers: Sequence[tuple[float, float, float]] = LAYERS,
    places: int = 3,
    depths: Sequence[float] = DEPTHS,
    lab: Lab | None = None,
) -> list[Case]:
    """Forces on layers at ``depths`` [radius]; the ripple is measured at ``places`` from a node to the middle of its
    cell."""
    lab, cases = lab or Lab(), list[Case]()
    for radius, thickness, cell in layers:
        soft = lab.layer(thickness, cell, max(2.0 * thickness, 2.5 * radius))
        for depth in (share * radius for share in depths if share * radius <= DEEPEST * thickness + 1e-12):
            at = [(cell * k / (2 * (places - 1)), 0.7 * cell * k / (2 * (places - 1))) for k in range(places)]
            forces = np.array([lab.steady(soft, radius, depth, p) for p in at])
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


def measure(lab: Lab, short: bool = False) -> Found:
    """All layers; the short version has one coarse layer."""
    cases = layer_cases([(5e-3, 0.02, 0.02 / 3)], 2, (0.25,), lab) if short else layer_cases(lab=lab)
    rows = []
    for radius, cell in sorted({(case["radius"], case["cell"]) for case in cases}, key=lambda one: (one[0], -one[1])):
        mine = [case for case in cases if (case["radius"], case["cell"]) == (radius, cell)]
        error = max(abs(case["force"] / case["expected"] - 1.0) for case in mine)
        thickness = 1e3 * mine[0]["thickness"]
        name = f"sphere of {1e3 * radius:g} mm, layer of {thickness:g} mm, cells of {1e3 * cell:.3g} mm"
        rows.append(at_most(f"{name}: error", 100.0 * error, 5.0))
        rows.append(at_most(f"{name}: ripple", 100.0 * max(case["ripple"] for case in mine), 1.0))
    details = {
        "layer_error": max(abs(case["force"] / case["expected"] - 1.0) for case in cases),
        "ripple": max(case["ripple"] for case in cases),
        "cases": cases,
    }
    return Found(tuple(rows), details)
