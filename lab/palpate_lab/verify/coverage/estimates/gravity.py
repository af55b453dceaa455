"""Holding torques of an arm with known masses, springs and friction, at 20 poses that were not recorded."""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate.arm import Arm
from palpate.arm.identify import scores
from palpate.arm.identify.fit_gravity import fit_poses
from palpate.arm.identify.recordings import Static
from palpate.base.arrays import Array
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "calibrate gravity"
FORMS = {
    RIGHT: "form gravity+springs, 80 poses; springs, noise of 1 to 10 mN m",
    "cable": "a cable of 80 mN m that is no spring at joint 4",
    "elsewhere": "that cable, recorded in a third of the joint's range",
    "drift": "torques that drift by 60 mN m over the recording",
}
_LOW, _HIGH = np.array([-0.35, -0.25, -0.3, -1.3, -1.4, -0.7, 0.0]), np.array([0.15, 0.16, 0.35, 3.2, 3.0, 0.7, 0.0])
_NOISE = np.array([0.006, 0.01, 0.01, 0.004, 0.002, 0.001, 0.0])  # N m
_OFFSET, _STIFF = np.array([0.05, -0.03, 0.02, 0.04, 0.01, -0.005, 0.0]), 0.03  # N m, N m/rad
_JOINTS = tuple(range(6))


@cache
def _arm() -> Arm:
    return Arm.mtm("right")


def _holding(q: Array, form: str) -> Array:
    """Torques (k, 7) that hold the arm: inverse dynamics at rest, springs and the cable [N m]."""
    zero = np.zeros(7)
    tau: Array = np.array([_arm().inverse_dynamics(row, zero, zero) for row in q]) + _OFFSET + _STIFF * q
    if form in ("cable", "elsewhere"):
        tau[:, 3] += 0.08 * np.sin(2.5 * q[:, 3])
    tau[:, 6] = 0.0
    return tau


def _recording(form: str, rng: np.random.Generator, poses: int, narrow: bool) -> Static:
    q = rng.uniform(_LOW, _HIGH, (poses, 7))
    if narrow:
        q[:, 3] = rng.uniform(0.3, 1.5, poses)
    tau = _holding(q, form) + _NOISE * rng.normal(size=q.shape)
    if form == "drift":
        tau[:, :6] += 0.06 * (np.arange(poses) / poses - 0.5)[:, None]
    return Static(q, tau, np.arange(poses) == 0, ("simulated",), poses)


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One calibration from 80 poses, judged by itself on 80 others."""
    arm, measured = _arm(), np.array([True] * 6 + [False])
    train, test = (_recording(form, rng, 80, form == "elsewhere" and first) for first in (True, False))
    fitted = fit_poses(train, arm, "gravity+springs", measured)
    unseen = rng.uniform(_LOW, _HIGH, (20, 7))
    predicted = fitted.model.measured(unseen, arm, np.zeros_like(unseen))
    found = scores.remarks(scores.score(fitted, test, _JOINTS, arm), _JOINTS, len(test), unseen=True)
    value, true, std = (x[:, :6].ravel() for x in (predicted, _holding(unseen, form), fitted.std(unseen, arm)))
    return of_intervals(value, true, 1.96 * std, bool(found))
