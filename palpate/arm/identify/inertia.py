"""Physically consistent links: pseudo-inertia, and least squares over positive definite pseudo-inertias.

The ten parameters of a link, pi = (m, m c (3), I_xx, I_xy, I_yy, I_xz, I_yz, I_zz) in Pinocchio's order, belong to a
body of positive density if and only if the 4x4 pseudo-inertia J(pi) = [tr(I)/2 1 - I, m c; (m c)^T, m] is positive
definite (Wensing, Kim and Slotine, RA-L 2018). J is linear in pi, so the estimate is the optimum of a convex problem.
The distance from a first guess J0 is |J0^-1/2 (J - J0) J0^-1/2|, a metric that does not depend on units (Lee, Wensing
and Park, TRO 2019).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from palpate.base.arrays import Array
from palpate.base.errors import MissingExtraError

_WIDTH = 0.02  # radius of gyration added to a first guess, so that no link is too thin [m]
_LEAST = 0.02  # lower bound of J, relative to J0: keeps the estimate away from a singular pseudo-inertia


def pseudo_inertia(pi: Array) -> Array:
    """Pseudo-inertia J (4, 4) of a link's ten parameters."""
    J = np.empty((4, 4))
    inertia = np.array([[pi[4], pi[5], pi[7]], [pi[5], pi[6], pi[8]], [pi[7], pi[8], pi[9]]])
    J[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    J[:3, 3] = J[3, :3] = pi[1:4]
    J[3, 3] = pi[0]
    return J


_UPPER = [(i, j) for j in range(4) for i in range(j + 1)]
_BASIS = [pseudo_inertia(e) for e in np.eye(10)]


def _svec(J: Array) -> Array:
    """Upper triangle of J, column by column, scaled so that its norm is the Frobenius norm of J."""
    return np.array([J[i, j] * (1.0 if i == j else np.sqrt(2.0)) for i, j in _UPPER])


_SVEC = np.column_stack([_svec(J) for J in _BASIS])


def guesses(pi: Array) -> list[Array]:
    """First guess J0 of every link of a model's parameters pi (10n,), widened by `_WIDTH`."""
    J0 = [pseudo_inertia(p) for p in pi.reshape(-1, 10)]
    for J in J0:
        J[:3, :3] += max(J[3, 3], 1e-3) * _WIDTH**2 * np.eye(3)
        J[3, 3] = max(J[3, 3], 1e-3)
    return J0


@dataclass(frozen=True)
class Problem:
    """|R x - y|^2 with a Gaussian prior on x = (pi of the links, other terms)."""

    R: Array  # (k, p), whitened
    y: Array  # (k,)
    pi0: Array  # (10n,) first guess
    spread: float  # prior standard deviation of a link from pi0, in the metric at J0
    deviation: Array  # (t,) prior standard deviation of the other terms, around zero
    positive: NDArray[np.bool_]  # (t,) terms that cannot be negative


def solve(problem: Problem) -> tuple[Array, Array, Array]:
    """Optimum x (p,) of the convex problem, and the deviations (p,) of x, which ignore the bounds.

    The second deviations are those with a prior twice as wide: twice as large where the data say nothing, alone or in
    combination with other parameters.

    Raises:
        MissingExtraError: the solver is not installed.
        ArithmeticError: the solver found no optimum.
    """
    try:
        import clarabel
    except ModuleNotFoundError as missing:
        raise MissingExtraError("identifying an arm's dynamics", "calibrate") from missing
    J0 = guesses(problem.pi0)
    n, t = len(J0), len(problem.deviation)
    size = 10 * n + t
    Q, x0, scale = np.zeros((size, size)), np.zeros(size), np.ones(size)
    rows = sparse.lil_matrix((10 * n + int(problem.positive.sum()), size))
    bound = np.zeros(rows.shape[0])
    for k, J in enumerate(J0):
        part = slice(10 * k, 10 * k + 10)
        L = np.linalg.inv(np.linalg.cholesky(J))
        metric = np.column_stack([_svec(L @ B @ L.T) for B in _BASIS])
        Q[part, part] = metric.T @ metric / problem.spread**2
        x0[part] = np.linalg.solve(_SVEC, _svec(J))
        lengths = np.sqrt(J.diagonal()[:3] * J[3, 3])
        scale[part] = np.concatenate([[J[3, 3]], lengths, np.full(6, np.trace(J[:3, :3]))])
        rows[part, part] = -_SVEC * scale[part] / J[3, 3]
        bound[part] = -_LEAST * _svec(J) / J[3, 3]
    Q[10 * n :, 10 * n :] = np.diag(problem.deviation**-2.0)
    scale[10 * n :] = problem.deviation
    for row, term in enumerate(np.flatnonzero(problem.positive), 10 * n):
        rows[row, 10 * n + term] = -1.0
    cones = [clarabel.PSDTriangleConeT(4) for _ in J0] + [clarabel.NonnegativeConeT(int(problem.positive.sum()))]
    H = problem.R.T @ problem.R + Q
    g = problem.R.T @ problem.y + Q @ x0
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    P = sparse.csc_matrix(np.triu(H * np.outer(scale, scale)))
    solution = clarabel.DefaultSolver(P, -g * scale, rows.tocsc(), bound, cones, settings).solve()
    if str(solution.status) not in ("Solved", "AlmostSolved"):
        raise ArithmeticError(f"the inertial parameters were not found: {solution.status}")
    x = np.asarray(solution.x) * scale
    data, prior = (M * np.outer(scale, scale) for M in (problem.R.T @ problem.R, Q))
    once, wider = (scale * np.sqrt(np.linalg.inv(data + share * prior).diagonal()) for share in (1.0, 0.25))
    return x, once, wider
