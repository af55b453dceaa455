"""A camera beside an arm from the tool tip that it sees."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays.rigid import displacement, exp, inverse, rigid, transform
from palpate.world.registration import camera
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_ellipsoid

COMMAND = "register camera"
FORMS = {
    RIGHT: "twenty poses, 0.5 mm on each axis",
    "shifted": "points of the next pose",
    "one wrong": "one point 10 mm off",
    "millimetres": "points in millimetres",
    "wanders": "the camera wanders by 0.8 mm a pose",
}


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One registration."""
    X_BC = rigid(exp(rng.normal(size=3)), rng.uniform(-0.1, 0.1, 3))
    R = exp(np.radians(50.0) * rng.uniform(-1.0, 1.0, (20, 3)))
    X_BT = rigid(R, rng.uniform(-0.06, 0.06, (20, 3)))
    seen = transform(inverse(X_BC), R @ [0.0, 0.004, 0.009] + X_BT[:, :3, 3]) + rng.normal(scale=5e-4, size=(20, 3))
    if form == "shifted":
        seen = np.roll(seen, 1, axis=0)
    if form == "one wrong":
        seen[3] += [0.0, 0.0, 0.01]
    if form == "wanders":
        seen += np.cumsum(rng.normal(scale=0.8e-3 / np.sqrt(3.0), size=(20, 3)), axis=0)
    found = camera(X_BT, seen * (1e3 if form == "millimetres" else 1.0))
    return of_ellipsoid(displacement(found.X, X_BC), found.covariance, bool(found.outliers or found.warnings))
