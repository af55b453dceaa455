"""Conversions between rotation matrices, poses, quaternions (w, x, y, z) and axis-angle rotations."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array


def unit(v: Array) -> Array:
    """Unit vector (n,) along a non-zero vector (n,)."""
    return np.asarray(v / np.linalg.norm(v))


def cross_matrix(v: npt.ArrayLike) -> Array:
    """Matrix (3, 3) of the cross product: ``cross_matrix(v) @ x = cross(v, x)``."""
    x, y, z = np.asarray(v)
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def about(axis: npt.ArrayLike, angle: npt.ArrayLike) -> Array:
    """Rotation (..., 3, 3) by each of the angles (...) [rad] about a unit axis (3,), by Rodrigues' formula."""
    K, angle = cross_matrix(axis), np.asarray(angle)[..., None, None]
    return np.asarray(np.eye(3) + (np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K)))


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
    q = np.asarray(wxyz, dtype=np.float64)
    length = np.linalg.norm(q, axis=-1, keepdims=True)
    w, x, y, z = np.moveaxis(np.where(length > 1e-9, q / np.maximum(length, 1e-9), [1.0, 0.0, 0.0, 0.0]), -1, 0)
    R = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(R), (0, 1), (-2, -1))


def quaternions(R: Array, canonical: bool = False) -> Array:
    """Unit quaternions (..., 4) from rotations (..., 3, 3), with w >= 0 if `canonical`.

    The matrix 4 q q^T is linear in R; its row with the largest diagonal element gives q without loss of precision
    (Shepperd 1978). In numpy, because importing scipy's rotations takes longer than all else that writes a record.
    """
    r = np.asarray(R, dtype=np.float64)
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = (np.moveaxis(row, -1, 0) for row in np.moveaxis(r, -2, 0))
    qq = [
        [1 + xx + yy + zz, zy - yz, xz - zx, yx - xy],
        [zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx],
        [xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy],
        [yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz],
    ]
    rows = np.moveaxis(np.array(qq), (0, 1), (-2, -1))
    largest = np.argmax(np.diagonal(rows, axis1=-2, axis2=-1), axis=-1)[..., None, None]
    q = np.take_along_axis(rows, largest, axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.asarray(np.where(q[..., :1] < 0.0, -q, q) if canonical else q)


def quaternion(R: Array) -> tuple[float, float, float, float]:
    """The unit quaternion of one rotation (3, 3) with w >= 0, in plain numbers: for loops in Python, where it takes a
    tenth of the time of `quaternions`.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = R.tolist()
    rows = (
        (1 + xx + yy + zz, zy - yz, xz - zx, yx - xy), (zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx),
        (xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy), (yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz),
    )  # fmt: skip
    w, x, y, z = max(enumerate(rows), key=lambda one: one[1][one[0]])[1]
    size = math.copysign(math.sqrt(w * w + x * x + y * y + z * z), w if w else 1.0)
    return w / size, x / size, y / size, z / size


def pose(p: npt.ArrayLike, wxyz: npt.ArrayLike) -> Array:
    """Pose (..., 4, 4) from a position (..., 3) [m] and a quaternion (..., 4); a zero one gives no rotation."""
    R = matrices(wxyz)
    X = np.zeros((*R.shape[:-2], 4, 4))
    X[..., :3, :3], X[..., :3, 3], X[..., 3, 3] = R, p, 1.0
    return X
