"""How good a gravity model is: on what it was trained on, on unseen poses, and beside what friction allows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate import _core
from palpate.arm import Arm
from palpate.arm.coupling import coupling
from palpate.arm.gravity_model import GravityModel, friction_torque
from palpate.arrays import Array
from palpate.identify import fit
from palpate.identify.approach import directions, expected_directions
from palpate.identify.fit_gravity import Fitted, beyond_drives, predicted
from palpate.identify.recordings import Static

Mask = NDArray[np.bool_]

_FOLDS = 5
_DISBELIEF = 0.7  # masses explain torques so much better in the motors' coordinates that the file must be in them


@dataclass(frozen=True)
class Scores:
    """Per measured joint (j,). Undirected: nobody says from where the arm came to a pose; directed: row order does."""

    rms: Array  # [N m]
    r2: Array
    rms_directed: Array
    r2_directed: Array
    floor: Array  # what friction alone leaves when the approach is unknown [N m]
    std: Array  # of the holding torques, mean [N m]
    coverage: Array  # share of directed errors within 1.96 predicted standard deviations
    outside: int  # poses outside of the trained region

    def undirected(self) -> dict[str, list[float]]:
        """RMS and R2, approach unknown."""
        return {"rms_Nm": self.rms.tolist(), "r2": self.r2.tolist()}

    def directed(self) -> dict[str, list[float]]:
        """RMS and R2, approach known."""
        return {"rms_Nm": self.rms_directed.tolist(), "r2": self.r2_directed.tolist()}


def score(fitted: Fitted, poses: Static, joints: tuple[int, ...], arm: Arm) -> Scores:
    """Of all poses of a recording, outliers included, but for torques that no drive can give."""
    model, poses = fitted.model, poses.only(np.asarray(~beyond_drives(poses.tau, arm).any(axis=1)))
    expected = expected_directions(model.drives(poses.q, arm), model.drives(model.visited, arm))
    return _scores(
        fitted, poses, joints, arm, model.measured(poses.q, arm, expected), predicted(model, poses, arm), expected
    )


def _scores(fitted: Fitted, poses: Static, joints: tuple[int, ...], arm: Arm, blind: Array, seeing: Array,
            expected: Array) -> Scores:  # fmt: skip
    j = list(joints)
    rms, r2 = _rms_r2(poses.tau[:, j], blind[:, j])
    rms_directed, r2_directed = _rms_r2(poses.tau[:, j], seeing[:, j])
    std = fitted.std(poses.q, arm)[:, j]
    band = 1.96 * np.sqrt(std**2 + fitted.noise[j] ** 2)
    return Scores(
        rms=rms,
        r2=r2,
        rms_directed=rms_directed,
        r2_directed=r2_directed,
        floor=_floor(fitted.model, poses.q, expected, arm)[j],
        std=std.mean(axis=0),
        coverage=(np.abs(poses.tau - seeing)[:, j] < band).mean(axis=0),
        outside=int(fitted.model.region.outside(poses.q, arm, len(j)).sum()),
    )


def cross_validate(fitted: Fitted, poses: Static, joints: tuple[int, ...], arm: Arm) -> Scores:
    """Five folds of the poses, each predicted from the others; the shape of the fields stays. Without outliers."""
    rows: Mask = np.asarray(fitted.use.any(axis=1))
    poses, used = poses.only(rows), fitted.use[rows]
    direction = directions(poses, fitted.model.drives(poses.q, arm))
    C = fitted.columns(poses.q, direction, arm)
    fold = np.random.default_rng(0).permutation(len(poses)) % _FOLDS
    tau = np.empty_like(poses.tau)
    for k in range(_FOLDS):
        use = used & (fold != k)[:, None]
        solve = (
            fit.bayes(C, poses.tau, fitted.noise, use) if fitted.design.prior else fit.least_squares(C, poses.tau, use)
        )
        tau[fold == k] = C[fold == k] @ solve.x
    return _scores(fitted, poses, joints, arm, tau, tau, direction)


def _rms_r2(tau: Array, model: Array) -> tuple[Array, Array]:
    squares = ((tau - model) ** 2).sum(axis=0)
    total = ((tau - tau.mean(axis=0)) ** 2).sum(axis=0)
    return np.sqrt(squares / len(tau)), 1.0 - squares / np.maximum(total, 1e-18)


def _floor(model: GravityModel, q: Array, expected: Array, arm: Arm) -> Array:
    """(n,) rms of dry friction about its expectation."""
    variance = np.zeros(arm.n)
    for drive in range(arm.n):
        way = np.zeros_like(q)
        way[:, drive] = np.sqrt(1.0 - expected[:, drive] ** 2)
        variance += (friction_torque(model.friction, model.motor_friction, q, way, arm) ** 2).mean(axis=0)
    return np.asarray(np.sqrt(variance))


def actuator_side(poses: Static, arm: Arm) -> str | None:
    """Words of doubt when the torques make sense only if positions and torques are those of coupled motors."""
    A = coupling(arm)
    if np.allclose(A, np.eye(arm.n)):
        return None
    as_is = _left_by_masses(poses.q, poses.tau, arm)
    decoupled = _left_by_masses(poses.q @ A.T, poses.tau @ np.linalg.inv(A), arm)
    if decoupled > _DISBELIEF * as_is:
        return None
    return (
        f"read as motor coordinates the masses leave {decoupled:.3f} N m, as joint coordinates {as_is:.3f} N m: "
        "is the recording in actuator coordinates?"
    )


def _left_by_masses(q: Array, tau: Array, arm: Arm) -> float:
    """RMS [N m] that masses and a constant per joint leave."""
    rows = np.linspace(0, len(q) - 1, min(len(q), 200)).astype(int)
    C = arm.gravity_columns(_core.GravityTerms(degree=0), q[rows])[:, 1:6].reshape(5 * len(rows), -1)
    y = tau[rows][:, 1:6].ravel()
    x = np.linalg.lstsq(C, y, rcond=1e-9)[0]
    return float(np.sqrt(np.mean((y - C @ x) ** 2)))
