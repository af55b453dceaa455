"""Force above a ball that is ten times as stiff as the tissue around it, against axisymmetric finite elements."""

from __future__ import annotations

from typing import Any

import numpy as np

from palpate.world.tissue import Tissue
from palpate_lab.verify.bench.tissue.bodies import POISSON, YOUNG, Lab, layer_mesh
from palpate_lab.verify.bench.tissue.rows import Found, at_most
from palpate_lab.verify.tissue import reference_force

RADIUS, THICKNESS, HALF = 5e-3, 30e-3, 40e-3  # [m]
BALL, RATIO = 6e-3, 10.0  # radius of the lump [m], its modulus over the tissue's
TOPS = (3e-3, 5e-3)  # depth of its upper end [m]
DEPTHS = (0.1, 0.25, 0.5)  # [radius]


def with_lump(lab: Lab, cell: float, top: float) -> Tissue:
    """A layer with a lump on the axis z, made of the tetrahedra whose centres lie in the ball."""
    nodes, tets = layer_mesh(THICKNESS, cell, HALF)
    middle = np.array([0.0, 0.0, -top - BALL])
    inside = np.linalg.norm(nodes[tets].mean(axis=1) - middle, axis=1) < BALL
    young = np.where(inside, RATIO * YOUNG, YOUNG)
    return lab.make((nodes, tets), young=young, poisson=POISSON, fixed=nodes[:, 2] < -THICKNESS + 1e-9)


def measure(lab: Lab, short: bool = False) -> Found:
    """Error for each depth of the lump, and how much of the added force is felt."""
    cells, tops, depths = ((10e-3,), TOPS[:1], (0.25,)) if short else ((7.5e-3, 5e-3), TOPS, DEPTHS)
    rows = []
    table: list[dict[str, Any]] = []
    for top in tops:
        truth, bare = (
            np.array(
                [float(reference_force(RADIUS, d * RADIUS, YOUNG, POISSON, h=THICKNESS, lump=lump)) for d in depths]
            )
            for lump in ((top, BALL, RATIO), None)
        )
        for cell in cells:
            soft = with_lump(lab, cell, top)
            force = np.array([lab.steady(soft, RADIUS, d * RADIUS) for d in depths])
            felt = (force - bare) / (truth - bare)
            table.append(
                {
                    "top": top,
                    "cell": cell,
                    "depth_radii": list(depths),
                    "error": [float(e) for e in force / truth - 1.0],
                    "felt": [float(f) for f in felt],
                }
            )
        mine = [row for row in table if row["top"] == top]
        error = max(abs(e) for row in mine for e in row["error"])
        rows.append(at_most(f"lump {1e3 * top:g} mm below the surface: error", 100.0 * error, 10.0))
    return Found(tuple(rows), {"lump": table})
