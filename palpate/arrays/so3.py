"""Conversions between rotation matrices, poses, quaternions (w, x, y, z) and axis-angle rotations."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from palpate.arrays import Array


def unit(v: Array) -> Array:
    """Unit vector (n,) along a non-zero vector (n,)."""
    return np.asarray(v / np.linalg.norm(v))


def cross_matrix(v: npt.ArrayLike) -> Array:
    """Matrix (3, 3) of the cross product: ``cross_matrix(v) @ x = cross(v, x)``."""
    x, y, z = np.asarray(v)
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def about(axis: npt.ArrayLike, angle: float) -> Array:
    """Rotation (3, 3) by `angle` [rad] about a unit axis (3,), by Rodrigues' formula."""
    K = cross_matrix(axis)
    return np.asarray(np.eye(3) + (math.sin(angle) * K + (1 - math.cos(angle)) * (K @ K)))


def onto(axis: Array) -> Array:
    """Smallest rotation (3, 3) that maps the z axis onto a unit axis (3,)."""
    z = np.array([0.0, 0.0, 1.0])
    v, c = np.cross(z, axis), float(z @ axis)
    if c < -1.0 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    K = cross_matrix(v)
    return np.asarray(np.eye(3) + K + K @ K / (1.0 + c))


def matrices(wxyz: npt.ArrayLike) -> Array:
    """Rotations (..., 3, 3) from quaternions (..., 4) of any norm; a zero quaternion gives the identity."""
    from scipy.spatial.transform import Rotation

    q = np.asarray(wxyz, dtype=np.float64)
    q = np.where(np.linalg.norm(q, axis=-1, keepdims=True) > 1e-9, q, [1.0, 0.0, 0.0, 0.0])
    R = Rotation.from_quat(np.roll(q, -1, axis=-1).reshape(-1, 4)).as_matrix()
    return np.asarray(R).reshape(*q.shape[:-1], 3, 3)


def quaternions(R: Array, canonical: bool = False) -> Array:
    """Unit quaternions (..., 4) from rotations (..., 3, 3), with w >= 0 if `canonical`."""
    from scipy.spatial.transform import Rotation

    found = np.asarray(Rotation.from_matrix(R.reshape(-1, 3, 3)).as_quat(canonical=canonical))
    return np.roll(found, 1, axis=-1).reshape(*R.shape[:-2], 4)


def pose(p: npt.ArrayLike, wxyz: npt.ArrayLike) -> Array:
    """Pose (4, 4) from a position (3,) [m] and a quaternion (4,); a zero quaternion gives no rotation."""
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = matrices(wxyz), p
    return X
