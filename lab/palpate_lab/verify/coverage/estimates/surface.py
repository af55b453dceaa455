"""A cloud on a surface with waves, from a start within 5 deg and 5 mm."""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displacement, exp, inverse, rigid, transform
from palpate.world.registration import surface
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_ellipsoid

COMMAND = "register surface"
FORMS = {
    RIGHT: "6000 points, 0.3 mm along the normal",
    "correlated": "noise of a stereo matcher, correlated over 6 mm",
    "other": "a cloud of another surface",
    "flat": "a cloud of a plane",
}


def _height(x: Array, y: Array) -> Array:
    return np.asarray(0.01 * np.sin(60.0 * x) * np.cos(45.0 * y) + 0.008 * np.sin(25.0 * x + 40.0 * y))


@cache
def _fixed() -> Array:
    x, y = np.random.default_rng(0).uniform(-0.06, 0.06, (2, 40_000))
    return np.column_stack([x, y, _height(x, y)])


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One registration."""
    x, y = rng.uniform(-0.045, 0.045, (2, 6000))
    other = 0.008 * np.sin(90.0 * x + 1.0) + 0.01 * np.cos(35.0 * x - 50.0 * y)
    z = {"other": other, "flat": 0.0 * x}.get(form, _height(x, y))
    noise = 0.3e-3 * rng.normal(size=len(x))
    if form == "correlated":
        cells = 0.5e-3 * rng.normal(size=(20, 20))
        noise += cells[((x + 0.05) / 0.006).astype(int), ((y + 0.05) / 0.006).astype(int)]
    X = rigid(exp(rng.normal(scale=0.3, size=3)), rng.uniform(-0.05, 0.05, 3))
    start = X @ rigid(exp(np.radians(5.0) * rng.uniform(-1.0, 1.0, 3)), rng.uniform(-5e-3, 5e-3, 3))
    cloud = transform(inverse(X), np.column_stack([x, y, z + noise]))
    found = surface(cloud, _fixed(), start)
    return of_ellipsoid(displacement(found.X, X), found.covariance, not found.trusted)
