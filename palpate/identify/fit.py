"""Linear models with normal priors: solution, covariance, and the marginal likelihood of the hyperparameters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize
from threadpoolctl import threadpool_limits

from palpate.arrays import Array

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
    factor, v, _ = _normal(columns, tau, noise, use)
    inverse = linalg.solve_triangular(factor, np.eye(len(factor)), lower=True)
    return Solution(np.asarray(inverse.T @ v, dtype=float), np.asarray(inverse.T @ inverse, dtype=float))


def evidence(columns: Array, tau: Array, noise: Array, use: Mask) -> float:
    """Log marginal likelihood of the torques, up to a constant; arguments as in `bayes`."""
    factor, v, squares = _normal(columns, tau, noise, use)
    logs = np.log(np.diag(factor)).sum() + (use * np.log(noise)).sum()
    return float(0.5 * (v @ v - squares) - logs)


def _normal(columns: Array, tau: Array, noise: Array, use: Mask) -> tuple[Array, Array, float]:
    """L, L^-1 W^T y and y^T y, where L L^T = W^T W + 1; W: columns, y: torques, both divided by the noise."""
    weight = np.where(use, 1.0 / noise, 0.0)
    W = (columns * weight[:, :, None]).reshape(-1, columns.shape[2])
    y = (tau * weight).ravel()
    A = W.T @ W
    A[np.diag_indices_from(A)] += 1.0
    factor = linalg.cholesky(A, lower=True, overwrite_a=True, check_finite=False)
    return factor, linalg.solve_triangular(factor, W.T @ y, lower=True, check_finite=False), float(y @ y)


def least_squares(columns: Array, tau: Array, use: Mask) -> Solution:
    """Least-squares x of the smallest norm; its covariance follows from the residual of each joint."""
    C, y = columns[use], tau[use]
    x, _, rank, _ = np.linalg.lstsq(C, y, rcond=1e-9)
    residual = np.where(use, tau - columns @ x, 0.0)
    variance = (residual**2).sum(axis=0) / np.maximum(use.sum(axis=0) - rank / tau.shape[1], 1.0)
    spread = np.linalg.pinv(C, rcond=1e-9) * np.sqrt(np.broadcast_to(variance, tau.shape)[use])
    return Solution(np.asarray(x, dtype=float), np.asarray(spread @ spread.T, dtype=float))


def most_likely(objective: Callable[[Array], float], start: Array, least: Array, steps: int) -> Array:
    """Values >= `least` that maximise `objective`, with a log-normal prior (a factor e) around `start`."""
    centre = np.log(np.maximum(start, least))

    def cost(theta: Array) -> float:
        return 0.5 * float(((theta - centre) ** 2).sum()) - objective(np.exp(theta))

    bounds = [(float(np.log(low)), None) for low in least]
    options = {"maxiter": steps, "ftol": 1e-7}
    found = optimize.minimize(cost, centre, method="L-BFGS-B", bounds=bounds, options=options)
    return np.asarray(np.exp(found.x))
