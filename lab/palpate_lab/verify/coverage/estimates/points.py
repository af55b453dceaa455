"""Fiducials whose localisation error is estimated, judged at a target 100 mm from their middle."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays.rigid import exp, rigid, transform
from palpate.world.registration import points
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_ellipsoid

COMMAND = "register points"
FORMS = {
    RIGHT: "eight markers in 100 mm, 0.25 mm rms",
    "scale": "fixed set 1 % larger",
    "slab": "markers within 0.3 mm of a plane, mirrored",
    "swapped": "two markers exchanged",
    "wanders": "twenty markers in a row; the tracker wanders by 0.3 mm a marker",
}
_FLE = 0.25e-3


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One registration."""
    m = rng.uniform(-0.05, 0.05, (20 if form == "wanders" else 8, 3)) * ([1.0, 1.0, 0.003] if form == "slab" else 1.0)
    X = rigid(exp(rng.normal(size=3)), rng.uniform(-0.05, 0.05, 3))
    true = transform(X, m * (1.01 if form == "scale" else 1.0))
    if form == "slab":
        true = transform(X, m * [1.0, -1.0, 1.0])
    if form == "swapped":
        true[[0, 1]] = true[[1, 0]]
    goal = np.array([[0.1, 0.0, 0.0]])
    if form == "wanders":
        true = true + np.cumsum(rng.normal(scale=0.3e-3 / np.sqrt(3.0), size=m.shape), axis=0)
    found = points(m, true + rng.normal(scale=_FLE / np.sqrt(3.0), size=m.shape), goal)
    error = transform(X, goal)[0] - transform(found.X, goal)[0]
    return of_ellipsoid(error, found.targets[0].covariance, bool(found.warnings or found.outliers))
