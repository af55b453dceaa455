"""Closed forms of indentation against the axisymmetric reference at large strain, and the polynomial of thin layers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.world.tissue.indentation import dimitriadis, hertz, layer, sneddon
from palpate_lab.verify.bench.tissue.bodies import Lab
from palpate_lab.verify.bench.tissue.rows import Found
from palpate_lab.verify.tissue import reference_force

DEPTHS = (0.1, 0.25, 0.5)  # [radius]
CASES = (  # Poisson's ratio, thickness over the radius (None: a half-space), theory
    (0.45, None, "Sneddon"),
    (0.45, None, "Hertz"),
    (0.40, None, "Sneddon"),
    (0.49, None, "Sneddon"),
    *((nu, h, theory) for nu, h in ((0.45, 2.0), (0.45, 1.0), (0.49, 1.0)) for theory in ("exact layer", "polynomial")),
)
_FORCES: dict[str, Callable[..., Array]] = {
    "Sneddon": sneddon,
    "Hertz": hertz,
    "exact layer": layer,
    "polynomial": dimitriadis,
}
_THIN, _RATIOS = 0.02, (0.3, 0.4, 0.45, 0.5)  # thickness of a thin layer over the radius; Poisson's ratios


def measure(lab: Lab, short: bool = False) -> Found:
    """Errors of the closed forms, and the polynomial over the exact force of thin layers; no limits."""
    del lab, short  # no tissue is simulated, and all cases take a second
    return Found((), {"theories": [_row(*case) for case in CASES], "polynomial": [_thin(chi) for chi in (0.5, 1.0)]})


def _row(nu: float, h: float | None, theory: str) -> dict[str, Any]:
    depths = np.array(DEPTHS)
    force = _FORCES[theory](1.0, depths, 1.0, nu, *(() if h is None else (h,)))
    ratios = force / reference_force(1.0, depths, 1.0, nu, h=np.inf if h is None else h)
    return {
        "theory": theory,
        "poisson": nu,
        "thickness_radii": h,
        "depth_radii": list(DEPTHS),
        "error": [float(one) for one in ratios - 1.0],
    }


def _thin(chi: float) -> dict[str, Any]:
    depth = (chi * _THIN) ** 2  # chi = sqrt(R d) / h, R = 1
    errors = [
        float(dimitriadis(1.0, depth, 1.0, nu, _THIN) / layer(1.0, depth, 1.0, nu, _THIN) - 1.0) for nu in _RATIOS
    ]
    return {"chi": chi, "poisson": list(_RATIOS), "error": errors}
