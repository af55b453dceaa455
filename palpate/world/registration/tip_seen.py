"""A camera beside an arm from the tool tip seen in its cloud: `camera`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displaced, transform
from palpate.base.errors import RegistrationError
from palpate.world.registration import checks, order, predict
from palpate.world.registration.deletion import Linearised, deletions
from palpate.world.registration.fit import closed_form, jacobians
from palpate.world.registration.noise import student_factor
from palpate.world.registration.quaternion_order import require_order

_STEPS, _SMALL = 60, 1e-10  # Gauss-Newton: largest number of steps, step that ends it [m, rad]
_TURNED = 0.05  # smallest singular value per pose that determines the tip's offset


@dataclass(frozen=True)
class CameraRegistration:
    """Result of `camera`."""

    X: Array  #: X_BC (4, 4), the camera in the arm's base
    p_TQ: Array  #: the seen point Q of the tool (3,) in the tool frame T [m]
    covariance: Array  #: (6, 6) of the displacement of X (NOTATION.md)
    p_TQ_covariance: Array  #: (3, 3) [m^2]
    fre: float  #: rms residual of the points used [m]
    fle: float  #: rms error of one seen point, estimated from the residuals [m]
    tre: Array  #: (K,) predicted rms error at each target [m]
    targets: tuple[predict.Target, ...]
    residuals: Array  #: (N,) [m]
    outliers: tuple[int, ...]  #: points excluded as wrong
    warnings: tuple[str, ...]


def camera(arm: npt.ArrayLike, seen: npt.ArrayLike, targets: npt.ArrayLike | None = None) -> CameraRegistration:
    """The camera's pose in the base of an arm, and the offset of the seen point from the tool frame.

    Minimises ``X_BC p_CQ - X_BT p_TQ`` over X_BC and p_TQ.

    Args:
        arm: X_BT (N, 4, 4), tool frame T in the base B.
        seen: p_CQ (N, 3), the same point Q of the tool in the camera C, at the same instants [m].
        targets: points (K, 3) in the camera's frame where the error is predicted [m].

    Raises:
        RegistrationError: fewer than four poses, points on a line, rotations that do not determine the offset, or
            points that do not belong to the poses.
    """
    X_BT, p_CQ = checks.poses("arm", arm, least=4), checks.cloud("seen", seen, least=4)
    if len(X_BT) != len(p_CQ):
        raise RegistrationError(f"{len(X_BT)} poses and {len(p_CQ)} seen points", mend="give one point per pose")
    checks.units(p_CQ, X_BT[:, :3, 3])
    checks.layout("seen", p_CQ, [str(i) for i in range(len(p_CQ))])
    goals = np.zeros((0, 3)) if targets is None else checks.cloud("targets", targets, least=1)
    _check_rotations(X_BT)
    require_order("the poses of the arm", X_BT, lambda X: _misfit(X, p_CQ))
    wrong = deletions(len(X_BT), 5, lambda rows: _linearised(X_BT[rows], p_CQ[rows]), known=False)
    kept = [k for k in range(len(X_BT)) if k not in wrong]
    X, t = _solved(X_BT[kept], p_CQ[kept])
    fit = Linearised(_residuals(X, t, X_BT[kept], p_CQ[kept]), _derivatives(X, X_BT[kept], p_CQ[kept]))
    freedom = max(3 * len(kept) - 9, 1)
    variance = float(np.square(fit.residuals).sum() / freedom)
    mend = "check that pose i and point i are of the same instant, and that the seen point is the tool's"
    checks.require_fit("poses and points", float(np.sqrt(3.0 * variance)), checks.extent(p_CQ), mend)
    C = np.asarray(
        student_factor(freedom) * variance * np.linalg.inv(np.einsum("nip,niq->pq", fit.J, fit.J)), dtype=np.float64
    )
    found = tuple(predict.target(X, C[:6, :6], p) for p in goals)
    residuals = np.linalg.norm(_residuals(X, t, X_BT, p_CQ), axis=1)
    return CameraRegistration(
        X=X, p_TQ=t, covariance=C[:6, :6], p_TQ_covariance=C[6:, 6:],
        fre=float(np.sqrt(np.square(residuals[kept]).mean())), fle=float(np.sqrt(3.0 * variance)),
        tre=np.array([one.tre for one in found]), targets=found, residuals=residuals, outliers=tuple(wrong),
        warnings=order.remarks(fit.residuals),
    )  # fmt: skip


def _residuals(X: Array, t: Array, X_BT: Array, p_CQ: Array) -> Array:
    """``X_BT p_TQ - X_BC p_CQ`` (N, 3) [m]."""
    return np.asarray(X_BT[:, :3, :3] @ t + X_BT[:, :3, 3] - transform(X, p_CQ))


def _derivatives(X: Array, X_BT: Array, p_CQ: Array) -> Array:
    """Minus the derivatives (N, 3, 9) of the residuals by the xi of X and by p_TQ."""
    return np.concatenate([jacobians(X, p_CQ), -X_BT[:, :3, :3]], axis=2)


def _solved(X_BT: Array, p_CQ: Array) -> tuple[Array, Array]:
    """X_BC and p_TQ by Gauss-Newton from the closed form with the offset zero."""
    X, t = closed_form(p_CQ, X_BT[:, :3, 3]), np.zeros(3)
    for _ in range(_STEPS):
        J = _derivatives(X, X_BT, p_CQ).reshape(-1, 9)
        step = np.linalg.lstsq(J, _residuals(X, t, X_BT, p_CQ).ravel(), rcond=None)[0]
        X, t = displaced(X, step[:6]), t + step[6:]
        if np.abs(step).max() < _SMALL:
            break
    return X, t


def _misfit(X_BT: Array, p_CQ: Array) -> float:
    """Median residual [m]."""
    X, t = _solved(X_BT, p_CQ)
    return float(np.median(np.linalg.norm(_residuals(X, t, X_BT, p_CQ), axis=1)))


def _linearised(X_BT: Array, p_CQ: Array) -> Linearised:
    X, t = _solved(X_BT, p_CQ)
    return Linearised(_residuals(X, t, X_BT, p_CQ), _derivatives(X, X_BT, p_CQ))


def _check_rotations(X_BT: Array) -> None:
    """Check that the tool turned enough to tell its offset from a shift of the camera."""
    R = X_BT[:, :3, :3]
    _, s, Vt = np.linalg.svd((R - R.mean(axis=0)).reshape(-1, 3))
    if s[-1] < _TURNED * np.sqrt(len(R)):
        words = ", ".join(f"{x:.2f}" for x in Vt[-1])
        raise RegistrationError(
            f"the {len(R)} poses do not determine the seen point's offset along ({words}) of the tool frame",
            why="the tool turned about one axis only, or hardly at all",
            mend="add poses tilted by 30 deg or more about an axis perpendicular to it",
        )
