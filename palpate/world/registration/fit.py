"""The rigid motion that maps points onto points with known correspondence, and its covariance."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displaced, rigid, transform
from palpate.world.registration.noise import isotropic

Indices: TypeAlias = NDArray[np.intp]
"""Array of row numbers."""

_STEPS = 30
_SMALL = 1e-10  # step at which the iteration has converged [m, rad]


def closed_form(moving: Array, fixed: Array, weights: Array | None = None) -> Array:
    """The pose X (4, 4) that minimises ``sum w |fixed - X moving|^2`` over points (N, 3).

    Singular value decomposition of the cross-covariance (Arun et al., IEEE PAMI 9(5), 1987), with Umeyama's sign that
    excludes reflections (IEEE PAMI 13(4), 1991).
    """
    w = np.full(len(moving), 1.0 / len(moving)) if weights is None else weights / weights.sum()
    m, f = w @ moving, w @ fixed
    U, _, Vt = np.linalg.svd((fixed - f).T @ (w[:, None] * (moving - m)))
    R = U @ np.diag([1.0, 1.0, np.linalg.det(U) * np.linalg.det(Vt)]) @ Vt
    return rigid(R, f - R @ m)


def jacobians(X: Array, moving: Array) -> Array:
    """Derivatives (N, 3, 6) of the points ``X moving`` with respect to the displacement xi of X."""
    J = np.zeros((len(moving), 3, 6))
    J[:, :, :3] = np.eye(3)
    x, y, z = (moving @ X[:3, :3].T).T
    J[:, 0, 4], J[:, 0, 5], J[:, 1, 5] = z, -y, x  # minus the cross-product matrix of each arm
    J[:, 1, 3], J[:, 2, 3], J[:, 2, 4] = -z, y, -x
    return J


def solve(moving: Array, fixed: Array, S_moving: Array, S_fixed: Array) -> Array:
    """Maximum likelihood pose (4, 4): the closed form for equal isotropic errors, otherwise `weighted`."""
    X = closed_form(moving, fixed)
    if isotropic(S_moving) and isotropic(S_fixed):
        return X
    return weighted(X, moving, fixed, S_moving, S_fixed)


def weighted(X: Array, moving: Array, fixed: Array, S_moving: Array, S_fixed: Array) -> Array:
    """Maximum likelihood pose for anisotropic errors, by Gauss-Newton from a nearby pose X (4, 4).

    Args:
        X: start, e.g. of `closed_form`.
        moving: points (N, 3) [m], with covariances `S_moving` (N, 3, 3) in the moving frame.
        fixed: points (N, 3) [m], with covariances `S_fixed` (N, 3, 3) in the fixed frame.
    """
    for _ in range(_STEPS):
        W = np.linalg.inv(residual_covariances(X, S_moving, S_fixed))
        J = jacobians(X, moving)
        JW = np.swapaxes(J, 1, 2) @ W
        residuals = (fixed - transform(X, moving))[..., None]
        xi = np.linalg.solve((JW @ J).sum(axis=0), (JW @ residuals).sum(axis=0)[:, 0])
        X = displaced(X, xi)
        if np.abs(xi).max() < _SMALL:
            break
    return X


def residual_covariances(X: Array, S_moving: Array, S_fixed: Array) -> Array:
    """Covariances (N, 3, 3) of ``fixed - X moving`` in the fixed frame, for independent errors of both."""
    R = X[:3, :3]
    return np.asarray(S_fixed + R @ S_moving @ R.T)


def information(X: Array, moving: Array, S: Array) -> Array:
    """Information matrix (6, 6) of the displacement of X, from residual covariances S (N, 3, 3).

    Its inverse is the first-order covariance of the maximum likelihood pose. For equal isotropic errors the target
    error that follows from it is that of Fitzpatrick, West and Maurer (IEEE TMI 17(5), 1998).
    """
    J = jacobians(X, moving)
    return np.asarray((np.swapaxes(J, 1, 2) @ np.linalg.inv(S) @ J).sum(axis=0))


def chi_square(X: Array, moving: Array, fixed: Array, S: Array) -> float:
    """Sum of the squared residuals, each weighted by its covariance S (N, 3, 3)."""
    r = fixed - transform(X, moving)
    return float(np.einsum("ni,nij,nj->", r, np.linalg.inv(S), r))
