"""Force of a sphere at large strain, against fine axisymmetric finite elements (`palpate_lab.verify.tissue`).

The reference shares no code with the core. Its own judges: the exact solution of a thin layer, Sneddon's solution of a
half-space, and differences of its energy (tests/verify/tissue).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from palpate_lab.verify.bench.tissue.bodies import POISSON, YOUNG, Lab
from palpate_lab.verify.bench.tissue.rows import Found, at_most
from palpate_lab.verify.tissue import reference_force

RADIUS, THICKNESS, HALF = 5e-3, 25e-3, 37.5e-3  # [m]
CELLS = (25e-3 / 3, 6.25e-3, 5e-3)  # [m]
DEPTHS = (0.1, 0.25, 0.5, 0.75, 1.0)  # [radius]
HIGHER = (0.1, 0.25, 0.5, 0.75)  # depths with stiffening [radius]


def errors(lab: Lab, cell: float, depths: tuple[float, ...], yeoh: float = 0.0) -> list[float]:
    """Relative error of the force at depths [radius], the larger one of two places on the mesh."""
    soft = lab.layer(THICKNESS, cell, HALF, yeoh=yeoh)
    out = []
    for depth in depths:
        d = depth * RADIUS
        truth = float(reference_force(RADIUS, d, YOUNG, POISSON, h=THICKNESS, yeoh=yeoh))
        places = ((0.0, 0.0), (0.5 * cell, 0.25 * cell))
        found = [lab.steady(soft, RADIUS, d, at) / truth - 1.0 for at in places]
        out.append(max(found, key=abs))
    return out


def measure(lab: Lab, short: bool = False) -> Found:
    """Errors on three meshes; the short version has the coarsest mesh and two depths."""
    cells, depths = (CELLS[:1], (0.25, 1.0)) if short else (CELLS, DEPTHS)
    table = np.array([errors(lab, cell, depths) for cell in cells])
    flat = np.array(depths) <= 0.5
    rows = [
        at_most("large strain: error up to R/2", 100.0 * np.abs(table[:, flat]).max(), 6.0),
        at_most("large strain: error up to R", 100.0 * np.abs(table).max(), 12.0),
    ]
    if not short:
        rows.append(at_most("large strain: between three meshes", 100.0 * np.ptp(table, axis=0).max(), 4.0))
    return Found(tuple(rows), {"large_strain": _table(cells, depths, table)})


def measure_stiffening(lab: Lab, short: bool = False) -> Found:
    """Errors with the stiffening coefficient c = 1."""
    cells, depths = (CELLS[:1], (0.5,)) if short else (CELLS[1:2], HIGHER)
    table = np.array([errors(lab, cell, depths, 1.0) for cell in cells])
    flat = np.array(depths) <= 0.5
    rows = [at_most("stiffening tissue: error up to R/2", 100.0 * np.abs(table[:, flat]).max(), 6.0)]
    if not short:
        rows.append(at_most("stiffening tissue: error up to .75 R", 100.0 * np.abs(table).max(), 12.0))
    return Found(tuple(rows), {"stiffening": _table(cells, depths, table)})


def _table(cells: tuple[float, ...], depths: tuple[float, ...], errors: Any) -> list[dict[str, Any]]:
    return [
        {"cell": cell, "depth_radii": list(depths), "error": [float(e) for e in row]}
        for cell, row in zip(cells, errors, strict=True)
    ]
