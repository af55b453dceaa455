"""Checks of poses and covariances that come from files, trackers and users."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array, rigid
from palpate.base.errors import FrameError

FARTHEST = 10.0
"""Largest distance between two frames [m]: a larger number was most likely given in millimetres."""
_NOT_RIGID = 2e-3  # largest |R^T R - I| that rounding to three decimals explains [-]


def pose(name: str, X: npt.ArrayLike) -> Array:
    """The pose (4, 4) [m] if it is rigid and right-handed, with its rotation made exactly orthogonal.

    Args:
        name: name of the pose in messages, such as ``X_world_camera``.
        X: homogeneous matrix (4, 4); files round it, which is accepted up to 2e-3 of R^T R - I.

    Raises:
        FrameError: the matrix has another shape, is not finite, is scaled, mirrored or not rigid, or its translation
            exceeds `FARTHEST`.
    """
    try:
        M = np.array(X, dtype=np.float64)
    except (TypeError, ValueError):
        raise FrameError(f"{name} is not a matrix of numbers", mend="give four rows of four numbers") from None
    if M.shape != (4, 4):
        raise FrameError(f"{name} must be a 4 x 4 matrix. Got: shape {M.shape}", mend="give four rows of four numbers")
    wrong = rigid.fault(M, _NOT_RIGID)
    if wrong is not None:
        raise FrameError(f"{name} {wrong.what}", why=wrong.why, mend=wrong.mend)
    U, _, Vt = np.linalg.svd(M[:3, :3])
    M[:3, :3] = U @ Vt
    far = float(np.linalg.norm(M[:3, 3]))
    if far > FARTHEST:
        what = f"{name} has a translation of {far:.4g} m, which exceeds {FARTHEST:g} m"
        raise FrameError(what, why="it is most likely in millimetres", mend="give unit: mm")
    return M


def quaternion(name: str, q: npt.ArrayLike) -> Array:
    """The unit quaternion (4,) along `q`, in its order.

    Raises:
        FrameError: its norm differs from 1 by more than 1e-2.
    """
    v = np.array(q, dtype=np.float64)
    norm = float(np.linalg.norm(v))
    if not abs(norm - 1.0) < 1e-2:
        what = f"{name} has the norm {norm:.4g} instead of 1"
        raise FrameError(what, why="it is not a rotation", mend="give all four numbers of a unit quaternion")
    return np.asarray(v / norm)


def covariance(name: str, C: npt.ArrayLike) -> Array:
    """The covariance (6, 6) of a pose [m, rad] if it is symmetric and not negative.

    Raises:
        FrameError: it has another shape, is not finite or not symmetric, or has a negative eigenvalue.
    """
    M = np.array(C, dtype=np.float64)
    if M.shape != (6, 6):
        raise FrameError(f"{name} must be a 6 x 6 matrix. Got: shape {M.shape}", mend="order: dx dy dz rx ry rz")
    if not np.isfinite(M).all():
        raise FrameError(f"{name} holds numbers that are not finite", mend="give sigma_mm and sigma_deg instead")
    size = float(np.abs(M).max())
    if np.abs(M - M.T).max() > 1e-6 * size:
        raise FrameError(f"{name} is not symmetric", mend="a covariance equals its transpose")
    M = 0.5 * (M + M.T)
    scale = np.sqrt(np.where(np.diag(M) > 0.0, np.diag(M), 1.0))
    least = float(np.linalg.eigvalsh(M / np.outer(scale, scale)).min())
    if least < -1e-6:
        what = f"{name} is not a covariance: an eigenvalue of its correlations is {least:.3g}"
        raise FrameError(what, mend="a covariance has no negative eigenvalue")
    return M
