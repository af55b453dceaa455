"""The tip of a pointer from poses while it rests in a divot."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays.rigid import exp, rigid
from palpate.world.registration import pivot
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_ellipsoid

COMMAND = "register pivot"
FORMS = {
    RIGHT: "twenty poses, 0.25 mm rms",
    "hidden": "a third of the poses is the identity",
    "waved": "the tool is waved about",
    "millimetres": "positions in millimetres",
    "wanders": "the tip wanders by 0.3 mm a pose",
}
_TIP = np.array([0.002, -0.0015, 0.152])


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One calibration."""
    R = exp(np.radians(40.0) * rng.uniform(-1.0, 1.0, (20, 3)))
    p = [0.1, 0.2, 0.9] - R @ _TIP + rng.normal(scale=0.25e-3 / np.sqrt(3.0), size=(20, 3))
    if form == "wanders":
        p = p + np.cumsum(rng.normal(scale=0.3e-3 / np.sqrt(3.0), size=(20, 3)), axis=0)
    X = rigid(R, rng.uniform(-0.1, 0.1, (20, 3)) if form == "waved" else p * (1e3 if form == "millimetres" else 1.0))
    if form == "hidden":
        X[rng.choice(20, 7, replace=False)] = np.eye(4)
    found = pivot(X)
    return of_ellipsoid(found.p_TQ - _TIP, found.covariance, bool(found.outliers or found.warnings))
