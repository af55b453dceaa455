"""Scores of a gravity model: on training poses, on unseen poses, and compared with the limit set by friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate import _core
from palpate.arm import Arm
from palpate.arm.coupling import coupling
from palpate.arm.gravity_model import GravityModel, friction_torque
from palpate.arm.identify import fit
from palpate.arm.identify.approach import directions, expected_directions
from palpate.arm.identify.fit_gravity import Fitted, beyond_drives, predicted
from palpate.arm.identify.recordings import Static
from palpate.base.arrays import Array
from palpate.base.arrays.intervals import proportion

Mask = NDArray[np.bool_]

_FOLDS = 5
_LIKELY = 3.84  # chi-square of one degree of freedom at 95 %
_REFUTED = 5.41  # the same at 98 %
_FACTORS = np.geomspace(1e-2, 1e2, 401)  # of the standard deviation that are tried
# Levels of the remarks, of which together one in twenty right models may get one: about 2 % for a deviation of another
# size, 1 % for patterns (measured: noise of the parameters adds to that of the poses), 1 % for bands.
_PATTERN = 1e-4  # probability of a pattern in noise alone
_SURE = 0.999  # confidence with which a band is called left, for each of six joints
_HELD = 0.93  # least share of torques within a band of 95 % that is no remark
_DISBELIEF = 0.7  # ratio of residuals (motor over joint coordinates) below which motor coordinates are assumed


@dataclass(frozen=True)
class Errors:
    """Errors per measured joint (j,), named as in docs/json.md."""

    rms_Nm: Array
    r2: Array


@dataclass(frozen=True)
class Scores:
    """Scores per measured joint (j,). Undirected: unknown approach directions; directed: known from the row order."""

    rms: Array  # [N m]
    r2: Array
    rms_directed: Array
    r2_directed: Array
    floor: Array  # RMS error that friction causes if the approach is unknown [N m]
    std: Array  # mean standard deviation of the holding torques [N m]
    coverage: Array  # fraction of directed errors within 1.96 predicted standard deviations
    deviation: tuple[float, float, float]  # factor of the true standard deviations over `std`: low, best, high
    refuted: float  # likelihood ratio of the best factor to 1, as a chi-square of one degree of freedom
    patterns: tuple[tuple[int, int], ...]  # joints (of the torque, along which its error is no noise; -1: in time)
    outside: int  # poses outside the trained region

    def undirected(self) -> Errors:
        """RMS and R2 with unknown approach directions."""
        return Errors(self.rms, self.r2)

    def directed(self) -> Errors:
        """RMS and R2 with known approach directions."""
        return Errors(self.rms_directed, self.r2_directed)


def score(fitted: Fitted, poses: Static, joints: tuple[int, ...], arm: Arm) -> Scores:
    """Scores on all poses of a recording, outliers included, except torques that no drive can apply."""
    model, poses = fitted.model, poses.only(np.asarray(~beyond_drives(poses.tau, arm).any(axis=1)))
    expected = expected_directions(model.drives(poses.q, arm), model.drives(model.visited, arm))
    return _scores(
        fitted, poses, joints, arm, model.measured(poses.q, arm, expected), predicted(model, poses, arm), expected
    )


def _scores(fitted: Fitted, poses: Static, joints: tuple[int, ...], arm: Arm, undirected: Array, directed: Array,
            expected: Array) -> Scores:  # fmt: skip
    j = list(joints)
    rms, r2 = _rms_r2(poses.tau[:, j], undirected[:, j])
    rms_directed, r2_directed = _rms_r2(poses.tau[:, j], directed[:, j])
    std = fitted.std(poses.q, arm)[:, j]
    band = 1.96 * np.sqrt(std**2 + fitted.noise[j] ** 2)
    deviation, refuted = _factor(fitted, poses, arm, j, poses.tau - directed)
    return Scores(
        rms=rms,
        r2=r2,
        rms_directed=rms_directed,
        r2_directed=r2_directed,
        floor=_floor(fitted.model, poses.q, expected, arm)[j],
        std=std.mean(axis=0),
        coverage=(np.abs(poses.tau - directed)[:, j] < band).mean(axis=0),
        patterns=_patterns(poses, joints, poses.tau - directed),
        deviation=deviation,
        refuted=refuted,
        outside=int(fitted.model.region.outside(poses.q, arm, len(j)).sum()),
    )


def cross_validate(fitted: Fitted, poses: Static, joints: tuple[int, ...], arm: Arm) -> Scores:
    """Five-fold cross-validation without outliers; the hyperparameters of the fields stay fixed."""
    rows: Mask = np.asarray(fitted.use.any(axis=1))
    poses, used = poses.only(rows), fitted.use[rows]
    direction = directions(poses, fitted.model.drives(poses.q, arm))
    C = fitted.columns(poses.q, direction, arm)
    fold = np.random.default_rng(0).permutation(len(poses)) % _FOLDS
    tau = np.empty_like(poses.tau)
    for k in range(_FOLDS):
        use = used & (fold != k)[:, None]
        solution = (
            fit.bayes(C, poses.tau, fitted.noise, use)
            if fitted.design.prior
            else fit.least_squares(C, poses.tau, use)[0]
        )
        tau[fold == k] = C[fold == k] @ solution.x
    return _scores(fitted, poses, joints, arm, tau, tau, direction)


def _factor(
    fitted: Fitted, poses: Static, arm: Arm, joints: list[int], error: Array
) -> tuple[tuple[float, float, float], float]:
    """`factor_of_deviation` for the errors (k, n) of the measured joints together, whose parameters are the same."""
    direction = directions(poses, fitted.model.drives(poses.q, arm))
    noise = fitted.noise[joints][:, None]
    C = (fitted.columns(poses.q, direction, arm)[:, joints] / noise).reshape(len(poses) * len(joints), -1)
    values, vectors = np.linalg.eigh(fitted.solution.covariance)
    modes = C @ (vectors * np.sqrt(np.maximum(values, 0.0)))
    return factor_of_deviation((error[:, joints] / noise.T).ravel(), modes)


def _patterns(poses: Static, joints: tuple[int, ...], error: Array) -> tuple[tuple[int, int], ...]:
    """Pairs of joints for which errors (k, n) at neighbouring angles agree, which noise does not; -1: in time.

    Von Neumann's ratio in its form as a correlation of neighbours, with Bonferroni's correction for all pairs.
    """
    from scipy.special import ndtri

    orders = {j: np.argsort(poses.q[:, j]) for j in joints} | {-1: np.arange(len(poses))}
    limit = -float(ndtri(_PATTERN / (len(joints) * len(orders)))) / np.sqrt(len(poses))
    found = []
    for i in joints:
        e = error[:, i] - error[:, i].mean()
        for j, order in orders.items():
            if float(e[order[1:]] @ e[order[:-1]]) > limit * max(float(e @ e), 1e-300):
                found.append((i, j))
    return tuple(found)


def factor_of_deviation(error: Array, modes: Array) -> tuple[tuple[float, float, float], float]:
    """Factor of a model's true standard deviation over the predicted one, and the evidence that it is not 1.

    The band of a single torque is nearly all noise, so its coverage says nothing about the model's share: with half or
    three times the model's deviation it is the same. But the model's errors are the same in many poses: their
    covariance is f^2 M M' beside the noise of each pose. f is that of the largest likelihood, with the size of the
    noise free; the interval is that of the likelihood ratio.

    Args:
        error: torques of unseen poses less predicted ones, over the noise of a single torque (k,).
        modes: M (k, p), a square root of the predicted covariance of the model's torques, over the same noise.

    Returns:
        (low, best, high) with the 95 % interval; low is 0 and high infinite where every smaller or larger factor is as
        probable. And twice the logarithm of the likelihood ratio of the best factor to 1.
    """
    U, s, _ = np.linalg.svd(modes, full_matrices=False)
    along = np.square(U.T @ error)
    rest = max(float(error @ error - along.sum()), 0.0)
    spread = 1.0 + np.square(_FACTORS)[:, None] * np.square(s)
    n = len(error)
    cost = n * np.log(np.maximum((along / spread).sum(axis=1) + rest, 1e-300)) + np.log(spread).sum(axis=1)
    inside = np.flatnonzero(cost < cost.min() + _LIKELY)
    low = 0.0 if inside[0] == 0 else float(_FACTORS[inside[0]])
    high = float("inf") if inside[-1] == len(_FACTORS) - 1 else float(_FACTORS[inside[-1]])
    one = int(np.argmin(np.abs(np.log(_FACTORS))))
    return (low, float(_FACTORS[np.argmin(cost)]), high), float(cost[one] - cost.min())


def remarks(scores: Scores, joints: tuple[int, ...], poses: int, unseen: bool) -> list[str]:
    """Sentences on bands and deviations that poses refute; only `unseen` poses can refute a deviation."""
    found = []
    for joint, held in zip(joints, scores.coverage, strict=True):
        if proportion(float(held), poses, _SURE)[1] < _HELD:
            found.append(
                f"joint {joint + 1}: the 95 % band holds {100 * held:.0f} % of {poses} torques: the arm has another "
                "form than this model, and its deviations do not cover that"
            )
    for joint in dict.fromkeys(joint for joint, _ in scores.patterns):
        along = [f"joint {j + 1}" if j >= 0 else "the order of the poses" for i, j in scores.patterns if i == joint]
        found.append(
            f"joint {joint + 1}: errors at neighbouring poses agree along {', '.join(along)}: a torque that this model "
            "does not have, which its deviations do not cover"
        )
    low, best, high = scores.deviation
    if unseen and best > 1.0 and scores.refuted > _REFUTED:
        found.append(f"std_Nm is too small: unseen torques show {best:.2g} times as much ({low:.2g} to {high:.2g})")
    if unseen and best < 1.0 and scores.refuted > _REFUTED:
        found.append(f"std_Nm is too large: unseen torques show at most {high:.2g} times as much")
    return found


def _rms_r2(tau: Array, model: Array) -> tuple[Array, Array]:
    squares = ((tau - model) ** 2).sum(axis=0)
    total = ((tau - tau.mean(axis=0)) ** 2).sum(axis=0)
    return np.sqrt(squares / len(tau)), 1.0 - squares / np.maximum(total, 1e-18)


def _floor(model: GravityModel, q: Array, expected: Array, arm: Arm) -> Array:
    """RMS (n,) of dry friction about its expected value [N m]."""
    variance = np.zeros(arm.n)
    for drive in range(arm.n):
        direction = np.zeros_like(q)
        direction[:, drive] = np.sqrt(1.0 - expected[:, drive] ** 2)
        variance += (friction_torque(model.friction, model.motor_friction, q, direction, arm) ** 2).mean(axis=0)
    return np.asarray(np.sqrt(variance))


def actuator_side(poses: Static, arm: Arm) -> str | None:
    """A warning if the recording seems to be in motor coordinates of coupled drives; None otherwise."""
    A = coupling(arm)
    if np.allclose(A, np.eye(arm.n)):
        return None
    as_is = _mass_residual(poses.q, poses.tau, arm)
    decoupled = _mass_residual(poses.q @ A.T, poses.tau @ np.linalg.inv(A), arm)
    if decoupled > _DISBELIEF * as_is:
        return None
    return (
        f"read as motor coordinates the masses leave {decoupled:.3f} N m, as joint coordinates {as_is:.3f} N m: "
        "is the recording in actuator coordinates?"
    )


def _mass_residual(q: Array, tau: Array, arm: Arm) -> float:
    """RMS residual of a fit of masses and a constant per joint [N m]."""
    rows = np.linspace(0, len(q) - 1, min(len(q), 200)).astype(int)
    C = arm.gravity_columns(_core.GravityTerms(degree=0), q[rows])[:, 1:6].reshape(5 * len(rows), -1)
    y = tau[rows][:, 1:6].ravel()
    x = np.linalg.lstsq(C, y, rcond=1e-9)[0]
    return float(np.sqrt(np.mean((y - C @ x) ** 2)))
