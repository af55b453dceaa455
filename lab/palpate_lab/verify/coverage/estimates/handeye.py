"""A camera on an arm from views of a board; errors of the views and of the arm."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displaced, displacement, exp, inverse, rigid
from palpate.world.registration import handeye
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_ellipsoid

COMMAND = "register handeye"
FORMS = {
    RIGHT: "eight views, 0.3 mm and 0.15 deg; arm 0.2 mm and 0.1 deg",
    "shifted": "views of the next pose",
    "board": "a board 5 % larger than stated",
    "one wrong": "one view 10 mm off",
    "wanders": "twenty views; the board wanders by 0.6 mm a view",
}


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One calibration."""
    camera, board = (rigid(exp(rng.normal(size=3)), rng.uniform(-reach, reach, 3)) for reach in (0.05, 0.2))
    n = 20 if form == "wanders" else 8
    R = exp(np.radians(40.0) * rng.uniform(-1.0, 1.0, (n, 3))) @ exp(rng.normal(size=3))
    X_BE = rigid(R, rng.uniform(-0.08, 0.08, (n, 3)))
    if form == "wanders":
        board = np.tile(board, (n, 1, 1))
        board[:, :3, 3] += np.cumsum(rng.normal(scale=0.6e-3 / np.sqrt(3.0), size=(n, 3)), axis=0)
    X_CK = inverse(camera) @ inverse(X_BE) @ board
    X_CK = _disturbed(rng, X_CK, 0.3e-3, 0.15)
    if form == "shifted":
        X_CK = np.roll(X_CK, 1, axis=0)
    if form == "board":
        X_CK[:, :3, 3] *= 1.05
    if form == "one wrong":
        X_CK[2, :3, 3] += [0.0, 0.01, 0.0]
    found = handeye(_disturbed(rng, X_BE, 0.2e-3, 0.1), X_CK, "arm")
    return of_ellipsoid(
        displacement(found.X, camera),
        found.covariance,
        bool(found.outliers) or any("size" in text or "alike" in text for text in found.warnings),
    )


def _disturbed(rng: np.random.Generator, X: Array, position: float, turn: float) -> Array:
    """Poses (N, 4, 4) with rms errors [m], [deg]."""
    sigma = np.repeat([position, np.radians(turn)], 3) / np.sqrt(3.0)
    return np.stack([displaced(one, sigma * rng.normal(size=6)) for one in X])
