"""Predicted error of targets (TRE), and where one more point would lower it most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import point_covariance
from palpate.world.registration.fit import jacobians

_GRID = 5  # candidates along each edge of the box
_THINNEST = 0.3  # shortest edge of the box relative to its longest


@dataclass(frozen=True)
class Target:
    """Predicted registration error at one target, of first order in the localisation error."""

    p: Array  #: position (3,) in the moving frame [m]
    tre: float  #: rms error [m]
    covariance: Array  #: (3, 3) of the error in the fixed frame [m^2]
    direction: Array  #: (3,) unit vector of the largest error, in the fixed frame
    semi_axes: Array  #: (3,) standard deviations along the axes of the ellipsoid, the largest first [m]


@dataclass(frozen=True)
class Addition:
    """The place where one more fiducial lowers the largest error most."""

    p: Array  #: position (3,) in the moving frame [m]
    tre: Array  #: rms errors (K,) of the targets after the addition [m]


def target(X: Array, covariance: Array, p: Array) -> Target:
    """Error of one target p (3,) in the moving frame [m], from the covariance (6, 6) of X (4, 4)."""
    S = point_covariance(X, covariance, p)
    values, vectors = np.linalg.eigh(S)
    axis = vectors[:, -1] * (1.0 if vectors[np.abs(vectors[:, -1]).argmax(), -1] > 0 else -1.0)
    return Target(p, float(np.sqrt(np.trace(S))), S, axis, np.sqrt(np.maximum(values[::-1], 0.0)))


def within(covariance: Array, probability: float) -> float:
    """Length that the error with this covariance (3, 3) [m^2] does not exceed with a probability [m].

    The squared length is approximated by a multiple of a chi-squared variable with the same mean and variance
    (Satterthwaite, Biometrics Bulletin 2(6), 1946).
    """
    from scipy.special import gammaincinv

    mean, spread = float(np.trace(covariance)), float(np.trace(covariance @ covariance))
    if mean <= 0.0:
        return 0.0
    freedom = mean**2 / spread
    return float(np.sqrt(spread / mean * 2.0 * gammaincinv(0.5 * freedom, probability)))


def next_point(
    X: Array, covariance: Array, S: Array, moving: Array, targets: Array, candidates: Array | None = None
) -> Addition:
    """The candidate that minimises the largest target error when it is added to the fiducials.

    Args:
        X: pose (4, 4), with its `covariance` (6, 6).
        S: covariance (3, 3) of the residual of the new fiducial in the fixed frame [m^2].
        moving: present fiducials (N, 3) in the moving frame [m].
        targets: targets (K, 3) in the moving frame [m].
        candidates: possible places (C, 3) in the moving frame [m]; default: a grid over the box of fiducials and
            targets.
    """
    places = _grid(np.vstack([moving, targets])) if candidates is None else np.asarray(candidates, dtype=np.float64)
    J = jacobians(X, places)
    after = np.linalg.inv(np.linalg.inv(covariance) + np.swapaxes(J, 1, 2) @ np.linalg.inv(S) @ J)
    K = jacobians(X, targets)
    tre = np.sqrt(np.einsum("kij,cjl,kil->ck", K, after, K))
    best = int(np.argmin(tre.max(axis=1)))
    return Addition(places[best], tre[best])


def _grid(points: Array) -> Array:
    low, high = points.min(axis=0), points.max(axis=0)
    lacking = np.maximum(_THINNEST * (high - low).max() - (high - low), 0.0) / 2.0
    edges = np.linspace(low - lacking, high + lacking, _GRID)
    return np.stack(np.meshgrid(*edges.T, indexing="ij"), axis=-1).reshape(-1, 3)
