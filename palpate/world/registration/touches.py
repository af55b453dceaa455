"""Registration of a surface from touches of a tool's tip, refining a first pose: `touches`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displaced, displacement, inverse, transform
from palpate.world.registration import predict

_STEPS, _SMALL = 20, 1e-9  # Gauss-Newton: largest number of steps, step that ends it [m, rad]


@dataclass(frozen=True)
class Touched:
    """Poses of a tool while the sphere on its tip touches a surface."""

    p_WT: Array  #: (N, 3) centre of the sphere [m]
    R_WT: Array  #: (N, 3, 3) orientation of the tool
    radius: float  #: of the sphere [m]
    sigma: float  #: standard deviation of a touch along any direction, independent from touch to touch [m]
    tip: float  #: standard deviation on each axis of the tip's calibrated offset in the tool, common to all touches [m]

    def __len__(self) -> int:
        return len(self.p_WT)

    def __getitem__(self, rows: slice | list[int]) -> Touched:
        return replace(self, p_WT=self.p_WT[rows], R_WT=self.R_WT[rows])


@dataclass(frozen=True)
class Guess:
    """A pose X_WA (4, 4) of the surface's frame A in W, with the covariance (6, 6) of its displacement."""

    X: Array
    covariance: Array


@dataclass(frozen=True)
class TouchRegistration(Guess):
    """Result of `touches`: the refined pose with its covariance, and what the touches say."""

    offset: Array  #: estimated error (3,) of the tip's offset, in the tool's frame [m]
    residuals: Array  #: (N,) signed distance of each touching sphere from the registered surface [m]
    chi_square: float  #: squared residuals and departures from the first pose and offset, each over its variance
    probability: float  #: of a larger chi-square if all stated errors are right

    def target(self, p: Array) -> predict.Target:
        """Predicted error of a target p (3,) in A [m]."""
        return predict.target(self.X, self.covariance, p)


def touches(model: _core.Surface, first: Guess, touched: Touched) -> TouchRegistration:
    """The pose that is most likely given a first pose, and a sphere that touches the surface in each row.

    Minimises over X_WA and the tip's error b the squares of ``distance(X_AW (p_WT + R_WT b)) - radius``, of the
    displacement from the first pose and of b, each weighted by its covariance, by Gauss-Newton.

    Args:
        model: the surface, in its frame A.
        first: pose known before, for example from a camera's view of the surface.
        touched: the touches.
    """
    from scipy.special import chdtrc

    prior = np.zeros((9, 9))
    prior[:6, :6], prior[6:, 6:] = np.linalg.inv(first.covariance), np.eye(3) / max(touched.tip, 1e-9) ** 2
    X, b = first.X, np.zeros(3)
    for _ in range(_STEPS):
        e, J = linearised(model, X, b, touched)
        departure = np.concatenate([displacement(first.X, X), b])
        H = prior + J.T @ J / touched.sigma**2
        step = -np.linalg.solve(H, prior @ departure + J.T @ e / touched.sigma**2)
        X, b = displaced(X, step[:6]), b + step[6:]
        if np.abs(step).max() < _SMALL:
            break
    e, J = linearised(model, X, b, touched)
    departure = np.concatenate([displacement(first.X, X), b])
    q = float(departure @ prior @ departure + np.square(e).sum() / touched.sigma**2)
    covariance = np.asarray(np.linalg.inv(prior + J.T @ J / touched.sigma**2)[:6, :6], dtype=np.float64)
    return TouchRegistration(X, covariance, b, e, q, float(chdtrc(max(len(touched), 1), q)))


def touched_by(X_WT: list[Array], radius: float, sigma: float, tip: float) -> Touched:
    """Touches of these poses (4, 4)."""
    X = np.array(X_WT).reshape(-1, 4, 4)
    return Touched(X[:, :3, 3], X[:, :3, :3], radius, sigma, tip)


def linearised(model: _core.Surface, X: Array, b: Array, touched: Touched) -> tuple[Array, Array]:
    """Residuals (N,) [m] and their derivatives (N, 9) by the displacement of X and by b."""
    p_W = touched.p_WT + touched.R_WT @ b
    distance, q_A, n_A = model.nearest(np.ascontiguousarray(transform(inverse(X), p_W)))
    R = X[:3, :3]
    n, arm = n_A @ R.T, q_A @ R.T
    J = np.hstack([-n, -np.cross(arm, n), np.einsum("ni,nij->nj", n, touched.R_WT)])
    return distance - touched.radius, J


def distance_covariance(J: Array, pose: Array, touched: Touched) -> Array:
    """Covariance (N, N) [m^2] of the residuals of `linearised`, by the touches, the tip's offset and a pose (6, 6)."""
    shared = np.zeros((9, 9))
    shared[:6, :6], shared[6:, 6:] = pose, touched.tip**2 * np.eye(3)
    return np.asarray(touched.sigma**2 * np.eye(len(J)) + J @ shared @ J.T)


def next_touch(found: Guess, targets: Array, places: Array, normals: Array, sigma: float) -> tuple[int, Array]:
    """The place whose touch lowers the largest target error most, and the errors (K,) after it [m].

    Args:
        found: present pose.
        targets: (K, 3) in A [m].
        places: possible places (C, 3) on the surface in A [m], with outward `normals` (C, 3).
        sigma: standard deviation of a touch along the normal [m].
    """
    from palpate.world.registration.fit import jacobians

    J = np.einsum("ci,cij->cj", normals @ found.X[:3, :3].T, jacobians(found.X, places))
    C, K = found.covariance, jacobians(found.X, targets)
    CJ = J @ C  # (C, 6)
    gain = 1.0 / (sigma**2 + np.einsum("ci,ci->c", J, CJ))  # rank-one update of the covariance
    fall = np.square(np.einsum("kij,cj->cki", K, CJ)).sum(axis=2) * gain[:, None]
    now = np.einsum("kij,jl,kil->k", K, C, K)
    after = np.sqrt(np.maximum(now[None] - fall, 0.0))
    best = int(np.argmin(after.max(axis=1)))
    return best, after[best]
