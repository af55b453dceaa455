"""Forces of the axisymmetric reference, computed once: ``tools/tissue_reference.py`` writes ``reference.json``."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array

PATH = Path(__file__).with_name("reference.json")


def reference_force(
    R: float,
    d: npt.ArrayLike,
    E: float,
    nu: float,
    *,
    h: float = np.inf,
    yeoh: float = 0.0,
    lump: tuple[float, float, float] | None = None,
) -> Array:
    """Force [N] on a frictionless rigid sphere of radius `R` [m] at depths `d` [m], at large strain.

    Args:
        R: radius of the sphere [m].
        d: depths [m], up to the deepest one of the table.
        E: Young's modulus at small strain [Pa].
        nu: Poisson's ratio at small strain.
        h: thickness of the layer, bonded to a rigid ground [m]; infinity: a half-space.
        yeoh: coefficient c of the strain energy in `palpate_lab.verify.tissue.solid`.
        lump: a ball below the sphere: depth of its upper end [m], its radius [m], its modulus over `E`.

    Raises:
        ValueError: the table lacks the case or the depth.
    """
    depth = np.asarray(d, dtype=np.float64) / R
    ball = () if lump is None else (lump[0] / R, lump[1] / R, lump[2])
    rows = [case for case in cases() if np.allclose([case["nu"], case["yeoh"]], [nu, yeoh])]
    rows = [c for c in rows if len(c["lump"]) == len(ball) and np.allclose(c["lump"], ball)]
    case = next((c for c in rows if c["h"] == h / R or np.isclose(c["h"], h / R)), None)
    if case is None:
        known = [(c["nu"], c["yeoh"], c["h"], c["lump"]) for c in cases()]
        asked = f"no case nu {nu:g}, yeoh {yeoh:g}, h/R {h / R:g}, lump {ball}"
        raise ValueError(f"{asked}; known (nu, yeoh, h/R, lump over R): {known}")
    x, f = np.array([[0.0, *case["d"]], [0.0, *case["f"]]])
    if depth.size and float(depth.max()) > x[-1] * (1 + 1e-9):
        raise ValueError(f"depth {depth.max():g} R is beyond the deepest of the table, {x[-1]:g} R")
    from scipy.interpolate import PchipInterpolator

    ratio = np.divide(f, x**1.5, out=np.full_like(f, 4.0 / 3.0 / (1.0 - nu**2)), where=x > 0)  # Hertz at depth zero
    force: Array = E * R**2 * PchipInterpolator(np.sqrt(x), ratio)(np.sqrt(np.maximum(depth, 0.0)))
    return force * np.maximum(depth, 0.0) ** 1.5


@cache
def cases() -> tuple[dict, ...]:  # type: ignore[type-arg]
    """Cases of the table: Poisson's ratio, `yeoh`, `h` and `lump` over R, depths over R and forces over E R^2."""
    rows = json.loads(PATH.read_text(encoding="utf-8"))["cases"]
    return tuple({"lump": (), **row, "h": np.inf if row["h"] is None else row["h"]} for row in rows)
