"""Pivot calibration: the tip of a tool that turns about a fixed point, `pivot`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.arrays import Array
from palpate.errors import RegistrationError
from palpate.registration import checks
from palpate.registration.deletion import Linearised, deletions
from palpate.registration.quaternion_order import require_order

_TURNED = 0.05  # smallest singular value per pose that determines the tip: about 6 deg of rms rotation


@dataclass(frozen=True)
class Pivot:
    """Result of `pivot`."""

    p_TQ: Array  #: tip Q (3,) in the tool frame T [m]
    p_WQ: Array  #: the pivot (3,) in the tracker's frame W [m]
    covariance: Array  #: (3, 3) of p_TQ [m^2]
    pivot_covariance: Array  #: (3, 3) of p_WQ [m^2]
    fre: float  #: rms distance of the tip from the pivot [m]
    fle: float  #: rms error of one measured tip position, estimated from the residuals [m]
    tre: float  #: predicted rms error of p_TQ [m]
    residuals: Array  #: (N,) distance of the tip from the pivot in each pose [m]
    outliers: tuple[int, ...]  #: poses excluded as wrong


def pivot(X_WT: npt.ArrayLike) -> Pivot:
    """The tip of a tool from its poses X_WT (N, 4, 4) while the tip rests at one point.

    Solves ``R_WT p_TQ + p_WT = p_WQ`` in all poses by linear least squares (the algebraic one-step method; Yaniv, SPIE
    Medical Imaging 9415, 2015).

    Raises:
        RegistrationError: fewer than three poses, matrices that are not rigid, or rotations about one axis only.
    """
    X = checks.poses("the recording", X_WT)
    _check_rotations(X)
    require_order("the poses", X, _misfit)
    wrong = deletions(len(X), 4, lambda rows: _linearised(X[rows]), known=False)
    kept = [k for k in range(len(X)) if k not in wrong]
    A, b = _equations(X[kept])
    solution = _solution(A, b)
    rest = b - A @ solution
    variance = float(np.square(rest).sum() / max(3 * len(kept) - 6, 1))
    C = variance * np.linalg.inv(np.einsum("nip,niq->pq", A, A))
    A_all, b_all = _equations(X)
    return Pivot(
        p_TQ=solution[:3],
        p_WQ=solution[3:],
        covariance=C[:3, :3],
        pivot_covariance=C[3:, 3:],
        fre=float(np.sqrt(np.square(rest).sum(axis=1).mean())),
        fle=float(np.sqrt(3.0 * variance)),
        tre=float(np.sqrt(np.trace(C[:3, :3]))),
        residuals=np.linalg.norm(b_all - A_all @ solution, axis=1),
        outliers=tuple(wrong),
    )


def _equations(X: Array) -> tuple[Array, Array]:
    """``A [p_TQ; p_WQ] = b`` with A (N, 3, 6) and b (N, 3)."""
    A = np.zeros((len(X), 3, 6))
    A[:, :, :3], A[:, :, 3:] = X[:, :3, :3], -np.eye(3)
    return A, -X[:, :3, 3]


def _solution(A: Array, b: Array) -> Array:
    return np.asarray(np.linalg.lstsq(A.reshape(-1, 6), b.ravel(), rcond=None)[0], dtype=np.float64)


def _misfit(X: Array) -> float:
    """Median distance of the tip from the pivot [m]."""
    A, b = _equations(X)
    return float(np.median(np.linalg.norm(b - A @ _solution(A, b), axis=1)))


def _linearised(X: Array) -> Linearised:
    A, b = _equations(X)
    solution = _solution(A, b)
    return Linearised(b - A @ solution, A)


def _check_rotations(X: Array) -> None:
    """Check that the rotations determine all three components of the tip."""
    A, _ = _equations(X)
    _, s, Vt = np.linalg.svd(A.reshape(-1, 6))
    if s[-1] < _TURNED * np.sqrt(len(X)):
        axis = Vt[-1, :3] / np.linalg.norm(Vt[-1, :3])
        words = ", ".join(f"{x:.2f}" for x in axis.round(2) + 0.0)  # no minus zeros
        raise RegistrationError(
            f"the {len(X)} poses do not determine the tip along ({words}) in the tool frame",
            why="the tool turned about one axis only, or hardly at all",
            mend="add poses tilted by 30 deg or more about an axis perpendicular to that direction, both ways",
        )
