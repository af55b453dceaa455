"""Hand-eye calibrations of the study."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays.rigid import displaced, displacement, exp, inverse, rigid
from palpate.base.sweep.grid import Point
from palpate.world.registration import handeye
from palpate.world.registration.hand_eye import Mount

VIEWS, POSITION, ROTATION = 15, 0.3e-3, np.radians(0.2)  # number; rms errors of a view [m], [rad]
_TURN, _REACH = np.radians(40.0), 0.08  # largest rotation about and position along each axis [rad], [m]
MOUNTS: tuple[Mount, ...] = ("arm", "beside")


def judged(point: Point, seed: int) -> dict[str, float]:
    """Errors of one calibration."""
    rng = np.random.default_rng(seed)
    mount = MOUNTS[point["mount"]]
    camera = rigid(exp(rng.normal(size=3)), rng.uniform(-0.05, 0.05, 3))
    board = rigid(exp(rng.normal(size=3)), rng.uniform(-0.2, 0.2, 3))
    X_BE = rigid(exp(_TURN * rng.uniform(-1, 1, (VIEWS, 3))), rng.uniform(-_REACH, _REACH, (VIEWS, 3)))
    exact = inverse(camera) @ (inverse(X_BE) if mount == "arm" else X_BE) @ board
    sigma = np.repeat([POSITION, ROTATION], 3) / np.sqrt(3.0)
    X_CK = np.stack([displaced(X, sigma * rng.normal(size=6)) for X in exact])
    found = handeye(X_BE, X_CK, mount)
    xi = displacement(found.X, camera)
    return {
        "position_m": float(np.linalg.norm(xi[:3])), "rotation_rad": float(np.linalg.norm(xi[3:])),
        "nees": float(xi @ np.linalg.solve(found.covariance, xi)),
    }  # fmt: skip
