"""Pivot calibration: the tip of a tool that turns about a fixed point, `pivot`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import RegistrationError
from palpate.world.registration import checks, order
from palpate.world.registration.deletion import Linearised, deletions
from palpate.world.registration.noise import student_factor
from palpate.world.registration.quaternion_order import require_order

_LONGEST = 3.0  # longest pointer that is believed to be in metres [m]
_DRAWS, _DRAWN, _ENOUGH = 500, 3, 10  # subsets of poses that are tried, poses of a subset, poses from which on
_FAR = 10.0  # robust standard deviations beyond which a pose would hide other wrong ones
_MEDIAN = 1.538  # median length of three normal deviates
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
    warnings: tuple[str, ...]


def pivot(X_WT: npt.ArrayLike) -> Pivot:
    """The tip of a tool from its poses X_WT (N, 4, 4) while the tip rests at one point.

    Solves ``R_WT p_TQ + p_WT = p_WQ`` in all poses by linear least squares (the algebraic one-step method; Yaniv, SPIE
    Medical Imaging 9415, 2015).

    Raises:
        RegistrationError: fewer than three poses, matrices that are not rigid, rotations about one axis only, lengths
            in millimetres, or poses that no tip explains.
    """
    X = checks.poses("the recording", X_WT)
    spread = checks.extent(X[:, :3, 3])
    if spread > checks.LARGEST:
        raise _millimetres(f"the tool moves by {spread:.4g} m rms")
    _check_rotations(X)
    require_order("the poses", X, _misfit)
    likely = _likely(X)
    dropped = deletions(len(likely), 4, lambda rows: _linearised(X[likely][rows]), known=False)
    kept = [likely[k] for k in range(len(likely)) if k not in dropped]
    wrong = sorted(set(range(len(X))) - set(kept))
    A, b = _equations(X[kept])
    solution = _solution(A, b)
    rest = b - A @ solution
    freedom = max(3 * len(kept) - 6, 1)
    variance = float(np.square(rest).sum() / freedom)
    _require_tip(solution[:3], float(np.sqrt(3.0 * variance)), X[kept])
    C = student_factor(freedom) * variance * np.linalg.inv(np.einsum("nip,niq->pq", A, A))
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
        warnings=order.remarks(rest),
    )


def _likely(X: Array) -> list[int]:
    """Indices of the poses that agree with most others (least median of squares; Rousseeuw, JASA 79(388), 1984).

    Many wrong poses bias the fit to all of them, so that none stands out.
    """
    if len(X) < _ENOUGH:
        return list(range(len(X)))
    A, b = _equations(X)
    rng = np.random.default_rng(0)
    drawn = np.array([rng.choice(len(X), _DRAWN, replace=False) for _ in range(_DRAWS)])
    found = np.einsum("dpn,dn->dp", np.linalg.pinv(A[drawn].reshape(_DRAWS, -1, 6)), b[drawn].reshape(_DRAWS, -1))
    far = np.linalg.norm(b - np.einsum("nip,dp->dni", A, found), axis=2)
    near = far[int(np.argmin(np.median(far, axis=1)))]
    A_near, b_near = _equations(X[near <= np.median(near)])
    distance = np.linalg.norm(b - A @ _solution(A_near, b_near), axis=1)
    sigma = float(np.median(distance)) / _MEDIAN
    return [int(k) for k in np.flatnonzero(distance <= _FAR * max(sigma, 1e-9))]


def _require_tip(p_TQ: Array, fle: float, X: Array) -> None:
    """Check that a tip explains the poses, in metres."""
    if np.linalg.norm(p_TQ) > _LONGEST:
        raise _millimetres(f"the tip would be {np.linalg.norm(p_TQ):.4g} m from the tool frame")
    mend = "rest the tip in a divot and record again; leave out poses in which the marker was hidden"
    checks.require_fit("the poses", fle, checks.extent(X[:, :3, 3]), mend)


def _millimetres(what: str) -> RegistrationError:
    return RegistrationError(what, why="the positions look like millimetres", mend="divide by 1000 (--unit mm)")


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
