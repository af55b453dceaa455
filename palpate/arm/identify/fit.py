"""Linear models with normal priors: solution, covariance, and the marginal likelihood of the hyperparameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, wraps
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize
from threadpoolctl import threadpool_limits

from palpate.base.arrays import Array

Mask = NDArray[np.bool_]
P = ParamSpec("P")
R = TypeVar("R")


def on_one_core(work: Callable[P, R]) -> Callable[P, R]:
    """Decorator: BLAS uses one thread while `work` runs.

    With matrices this small, synchronising threads takes 20 times longer, and more if the cores are busy.
    """

    @wraps(work)
    def limited(*args: P.args, **options: P.kwargs) -> R:
        with threadpool_limits(1):
            return work(*args, **options)

    return limited


@dataclass(frozen=True)
class Solution:
    """Solution x of tau = C x + noise, with its covariance."""

    x: Array  # (p,)
    covariance: Array  # (p, p)


def bayes(columns: Array, tau: Array, noise: Array, use: Mask) -> Solution:
    """Posterior of x with a standard normal prior.

    Args:
        columns: (k, n, p) regressor.
        tau: (k, n) torques [N m].
        noise: (n,) standard deviation per joint [N m].
        use: (k, n) mask of the torques to fit.
    """
    factor, v, _ = _normal(*_divided(columns, tau, noise, use))
    inverse = linalg.solve_triangular(factor, np.eye(len(factor)), lower=True)
    return Solution(np.asarray(inverse.T @ v, dtype=float), np.asarray(inverse.T @ inverse, dtype=float))


class Evidence:
    """Log marginal likelihood of the torques, up to a constant, and its derivatives; arguments as in `bayes`."""

    def __init__(self, columns: Array, tau: Array, noise: Array, use: Mask) -> None:
        self._W, self._y = _divided(columns, tau, noise, use)
        self._L, self._v, squares = _normal(self._W, self._y)
        self._use = use
        logs = np.log(np.diag(self._L)).sum() + (use * np.log(noise)).sum()
        self.value = float(0.5 * (self._v @ self._v - squares) - logs)

    @cached_property
    def _x(self) -> Array:
        return np.asarray(linalg.solve_triangular(self._L, self._v, lower=True, trans="T", check_finite=False))

    @cached_property
    def _variances(self) -> Array:
        """Diagonal of (W^T W + 1)^-1."""
        inverse = linalg.solve_triangular(self._L, np.eye(len(self._L)), lower=True, check_finite=False)
        return np.asarray((inverse**2).sum(axis=0))

    def by_size(self, place: slice) -> float:
        """Derivative with respect to the logarithm of a factor of some columns."""
        return float((self._x[place] ** 2 - 1.0 + self._variances[place]).sum())

    def by_noise(self) -> Array:
        """Derivatives (n,) with respect to the logarithm of the noise of each joint."""
        spread = linalg.solve_triangular(self._L, self._W.T, lower=True, check_finite=False)
        squares = (self._y - self._W @ self._x) ** 2 + (spread**2).sum(axis=0)
        return np.asarray(squares.reshape(self._use.shape).sum(axis=0) - self._use.sum(axis=0))


def _divided(columns: Array, tau: Array, noise: Array, use: Mask) -> tuple[Array, Array]:
    """Columns W (k n, p) and torques y (k n,), both divided by the noise; zero where they are not used."""
    weight = np.where(use, 1.0 / noise, 0.0)
    return (columns * weight[:, :, None]).reshape(-1, columns.shape[2]), (tau * weight).ravel()


def _normal(W: Array, y: Array) -> tuple[Array, Array, float]:
    """L, L^-1 W^T y and y^T y, where L L^T = W^T W + 1."""
    A = W.T @ W
    A[np.diag_indices_from(A)] += 1.0
    factor = linalg.cholesky(A, lower=True, overwrite_a=True, check_finite=False)
    return factor, linalg.solve_triangular(factor, W.T @ y, lower=True, check_finite=False), float(y @ y)


def least_squares(columns: Array, tau: Array, use: Mask) -> tuple[Solution, Array]:
    """Least-squares x of the smallest norm, and the noise (n,) of each joint's torques [N m].

    A residual mixes the noise of all joints, by I - H with the projection H onto the columns. Its mean squares are
    linear in the variances; these are solved for, which makes them unbiased (MINQUE, Rao 1970). To share the degrees of
    freedom out equally would make them wrong where one joint determines more parameters than another.
    """
    C, y = columns[use], tau[use]
    U, s, Vt = np.linalg.svd(C, full_matrices=False)
    rank = int((s > 1e-9 * s[0]).sum()) if len(s) else 0
    U, inverse = U[:, :rank], Vt[:rank].T / s[:rank]
    x = inverse @ (U.T @ y)
    square, joint = np.square(y - C @ x), np.broadcast_to(np.arange(tau.shape[1]), tau.shape)[use]
    rows = [joint == j for j in range(tau.shape[1])]
    inside = [U[r].T @ U[r] for r in rows]  # share of each joint in the projection
    mixed = np.array([[float((G * K).sum()) for K in inside] for G in inside])
    mixed += np.diag([float(r.sum()) - 2.0 * float(np.trace(G)) for r, G in zip(rows, inside, strict=True)])
    sums = np.array([float(square[r].sum()) for r in rows])
    plain = sums / np.maximum([r.sum() for r in rows], 1)
    variance = np.maximum(np.linalg.lstsq(mixed, sums, rcond=1e-9)[0], 0.25 * plain)
    spread = inverse @ (U.T * np.sqrt(variance[joint]))
    return Solution(np.asarray(x, dtype=float), np.asarray(spread @ spread.T, dtype=float)), np.sqrt(variance)


def most_likely(objective: Callable[[Array], tuple[float, Array]], start: Array, least: Array, steps: int) -> Array:
    """Values >= `least` that maximise `objective`, with a log-normal prior (a factor e) around `start`.

    objective: gives a value, and its derivatives with respect to the logarithms of its arguments.
    """
    centre = np.log(np.maximum(start, least))

    def cost(theta: Array) -> tuple[float, Array]:
        value, slope = objective(np.exp(theta))
        return 0.5 * float(((theta - centre) ** 2).sum()) - value, theta - centre - slope

    bounds = [(float(np.log(low)), None) for low in least]
    options = {"maxiter": steps, "ftol": 1e-7}
    found = optimize.minimize(cost, centre, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return np.asarray(np.exp(found.x))
