"""Modulus of tissue from a press to one depth or four, with two relaxation times anywhere between 0.1 and 5 s."""

from __future__ import annotations

import numpy as np

from palpate.arm.identify.press_recording import Press
from palpate.arm.identify.tissue import fit
from palpate.base.arrays import Array
from palpate.world.tissue import indentation, viscosity
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "identify tissue"
FORMS = {
    RIGHT: "sphere by Sneddon or by Hertz, one depth or four; noise of 0.5 %, a drift of 1 %",
    "cone": "a cone pressed instead of a sphere",
    "layers": "5 % waves of stiffness over the depth",
    "edge": "half of the sphere over an edge beyond half of the depth",
    "layer": "a layer of two radii on hard ground, thickness not stated",
}
_R, _E, _NU = 6e-3, 6e3, 0.45


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One press of 12 s."""
    t = np.arange(0.0, 12.0, 0.025)
    one, hertz = rng.choice([False, True], 2) if form == RIGHT else (False, False)
    times, levels = _stairs((0.3,) if one else (0.1, 0.2, 0.35, 0.5))
    d = np.interp(t, times, levels)
    deep = np.maximum(d, 0.0)
    elastic = indentation.sneddon(_R, deep, _E, _NU)
    if hertz:
        elastic = 4.0 / 3.0 * _E / (1.0 - _NU**2) * np.sqrt(_R) * deep**1.5
    if form == "cone":
        elastic = 2.0 / np.pi * _E / (1.0 - _NU**2) * deep**2 / np.tan(np.radians(30.0))
    if form == "layers":
        elastic = elastic * (1.0 + 0.05 * np.sin(deep / 1.5e-4))
    if form == "edge":
        elastic = elastic - 0.5 * indentation.sneddon(_R, np.maximum(deep - 1.5e-3, 0.0), _E, _NU)
    if form == "layer":
        elastic = indentation.layer(_R, deep, _E, _NU, 2.0 * _R)
    terms = list(zip(rng.uniform(0.1, 0.5, 2).tolist(), np.exp(rng.uniform(-2.3, 1.6, 2)).tolist(), strict=True))
    force = viscosity.hereditary_force(terms, t, elastic)
    noise = 0.005 * rng.normal(size=len(t)) + 0.01 * rng.choice([-1.0, 1.0]) * t / t[-1]
    found = fit(Press(t, d + 1e-3, force + force.max() * noise), _R)
    half = 0.5 * np.log(found.young_95[1] / found.young_95[0])
    told = any(text.startswith(("the form", "a layer")) for text in found.not_identifiable)
    return of_intervals(np.log([found.young]), np.log([_E]), np.array([half]), told)


def _stairs(levels: tuple[float, ...]) -> tuple[Array, Array]:
    """Times [s] and depths [m] of presses that are held; the sphere begins 1 mm above the tissue."""
    knots = [(0.0, -1e-3), (0.3, -1e-3), (0.5, 0.0)]
    for i, level in enumerate(levels):
        start = 0.5 + i * 11.5 / len(levels)
        knots += [(start + 1e-6, knots[-1][1]), (start + 0.1, level * _R)]
    times, depths = np.array([*knots, (12.0, levels[-1] * _R)]).T
    return times, depths
