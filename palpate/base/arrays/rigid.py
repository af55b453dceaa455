"""Poses X_AB (4, 4), small displacements of poses, and the covariances of poses.

An uncertain pose is ``X_AB_true = displaced(X_AB, xi)`` with ``xi = [dp; dtheta]`` (6,) [m, rad], translation first and
both expressed in A: ``p_AB_true = p_AB + dp`` and ``R_AB_true = exp(dtheta) R_AB``. A pose covariance (6, 6) is that of
xi. The formulas of covariances are of first order in xi (Barfoot and Furgale, IEEE T-RO 30(3), 2014, for their scope).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.arrays.so3 import cross_matrix


class Fault(NamedTuple):
    """Why a matrix is not a pose, as parts of a message whose subject is the name of the matrix."""

    what: str
    why: str
    mend: str


def fault(X: Array, tolerance: float = 1e-3) -> Fault | None:
    """What is wrong with a matrix (4, 4) that should be a pose; None if it is rigid and right-handed.

    tolerance: largest element of ``R^T R - I`` that rounded digits explain [-].
    """
    if not np.isfinite(X).all():
        return Fault("holds numbers that are not finite", "", "remove this pose, or measure it again")
    if np.abs(X[3] - [0.0, 0.0, 0.0, 1.0]).max() > 1e-6:
        transposed = not X[:3, 3].any()
        mend = "write the translation into the last column" if transposed else "correct the last row"
        return Fault(f"is not rigid: its last row must be 0 0 0 1. Got: {X[3].tolist()}", "", mend)
    R = X[:3, :3]
    scales = np.linalg.svd(R, compute_uv=False)
    mean, off = float(scales.mean()), float(np.abs(R.T @ R - np.eye(3)).max())
    if np.ptp(scales) < tolerance * max(mean, 1e-12) and abs(mean - 1.0) > tolerance:
        mend = "divide the 3 x 3 block by its scale, or state the unit of the lengths"
        return Fault(f"is not rigid: its rotation is scaled by {mean:.4g}", "a pose does not scale", mend)
    if off > tolerance:
        why = "its axes are not orthogonal unit vectors: a sheared matrix, or rounded digits"
        mend = "register the frames again, and write six digits or more"
        return Fault(f"is not rigid: R^T R differs from the identity by {off:.2g}", why, mend)
    if np.linalg.det(R) < 0.0:
        mend = "negate one column or change the order of the axes, as your source's axes require"
        return Fault("is left-handed: the determinant of its rotation is -1", "an axis is mirrored", mend)
    return None


def exp(theta: npt.ArrayLike) -> Array:
    """Rotations (..., 3, 3) from rotation vectors (..., 3) [rad], by Rodrigues' formula. Scipy loads slowly."""
    v = np.asarray(theta, dtype=np.float64)
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    K = np.zeros((*v.shape, 3))
    K[..., 2, 1], K[..., 0, 2], K[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    K -= np.swapaxes(K, -1, -2)
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * K @ K)


def log(R: Array) -> Array:
    """Rotation vectors (..., 3) [rad] from rotations (..., 3, 3); their norm is at most pi."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(R.reshape(-1, 3, 3)).as_rotvec()).reshape(*R.shape[:-2], 3)


def rigid(R: npt.ArrayLike, p: npt.ArrayLike) -> Array:
    """Poses (..., 4, 4) from rotations (..., 3, 3) and positions (..., 3) [m]."""
    R, p = np.asarray(R, dtype=np.float64), np.asarray(p, dtype=np.float64)
    X = np.zeros((*np.broadcast_shapes(R.shape[:-2], p.shape[:-1]), 4, 4))
    X[..., :3, :3], X[..., :3, 3], X[..., 3, 3] = R, p, 1.0
    return X


def inverse(X_AB: Array) -> Array:
    """Poses X_BA (..., 4, 4)."""
    R_BA = np.swapaxes(X_AB[..., :3, :3], -1, -2)
    return rigid(R_BA, -(R_BA @ X_AB[..., :3, 3:])[..., 0])


def transform(X_AB: Array, p_BQ: Array) -> Array:
    """Points p_AQ (N, 3) from points p_BQ (N, 3) [m] by one pose (4, 4)."""
    return np.asarray(p_BQ @ X_AB[:3, :3].T + X_AB[:3, 3])


def displaced(X_AB: Array, xi: npt.ArrayLike) -> Array:
    """The pose (4, 4) displaced by ``xi = [dp; dtheta]`` (6,) in A [m, rad]."""
    xi = np.asarray(xi, dtype=np.float64)
    return rigid(exp(xi[3:]) @ X_AB[:3, :3], X_AB[:3, 3] + xi[:3])


def displacement(X_from: Array, X_to: Array) -> Array:
    """The ``xi`` (..., 6) [m, rad] with ``X_to = displaced(X_from, xi)``."""
    dR = X_to[..., :3, :3] @ np.swapaxes(X_from[..., :3, :3], -1, -2)
    return np.concatenate([X_to[..., :3, 3] - X_from[..., :3, 3], log(dR)], axis=-1)


def adjoint(X_AB: Array) -> Array:
    """Matrix (6, 6) that maps a twist in B to the same twist in A, both linear over angular, each at its own origin."""
    R, p = X_AB[:3, :3], X_AB[:3, 3]
    return np.block([[R, cross_matrix(p) @ R], [np.zeros((3, 3)), R]])


def point_jacobian(p_BQ_A: npt.ArrayLike) -> Array:
    """Derivative (3, 6) of a point Q fixed to B with respect to the ``xi`` of X_AB; p_BQ_A = R_AB p_BQ (3,) [m]."""
    return np.hstack([np.eye(3), -cross_matrix(p_BQ_A)])


def point_covariance(X_AB: Array, covariance: Array, p_BQ: npt.ArrayLike) -> Array:
    """Covariance (3, 3) in A [m^2] of a point p_BQ (3,) fixed to B, from the covariance (6, 6) of X_AB."""
    J = point_jacobian(X_AB[:3, :3] @ np.asarray(p_BQ))
    return np.asarray(J @ covariance @ J.T)


def inverse_covariance(X_AB: Array, covariance: Array) -> Array:
    """Covariance (6, 6) of X_BA from that of X_AB."""
    R_BA, p = X_AB[:3, :3].T, X_AB[:3, 3]
    J = -np.block([[R_BA, R_BA @ cross_matrix(p)], [np.zeros((3, 3)), R_BA]])
    return np.asarray(J @ covariance @ J.T)


def composed_covariance(X_AB: Array, covariance_AB: Array, X_BC: Array, covariance_BC: Array) -> Array:
    """Covariance (6, 6) of ``X_AC = X_AB X_BC`` from those of its factors, whose errors are independent."""
    R, zero = X_AB[:3, :3], np.zeros((3, 3))
    left = np.block([[np.eye(3), -cross_matrix(R @ X_BC[:3, 3])], [zero, np.eye(3)]])
    right = np.block([[R, zero], [zero, R]])
    return np.asarray(left @ covariance_AB @ left.T + right @ covariance_BC @ right.T)
