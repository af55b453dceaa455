"""Gravity calibration: read the poses at which an arm was held, fit a model, and score it on unseen poses."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm
from palpate.arm.gravity_model import GravityModel
from palpate.arm.identify import fit, forms, scores
from palpate.arm.identify.fit_gravity import Fitted, fit_poses
from palpate.arm.identify.identifiability import Identifiability, identifiability, next_poses
from palpate.arm.identify.pairs import Pairs, find_pairs
from palpate.arm.identify.recordings import Static, on_levels, read_static
from palpate.arm.identify.scores import Scores
from palpate.base.arrays import Array
from palpate.base.errors import RecordingError

_FEWEST = 12  # poses needed for ten base parameters, springs and friction
_SILENT = 2e-4  # standard deviation of the torque below which a joint counts as not measured [N m]
_ARMS = {"mtml": "left", "mtmr": "right"}


@dataclass(frozen=True)
class Calibration:
    """A gravity model with its scores. Values per joint are for the joints whose torque was measured."""

    fitted: Fitted
    poses: Static
    unseen: Static | None
    identifiability: Identifiability
    joints: tuple[int, ...]  # measured joints, from 0
    train: Scores
    test: Scores | None
    cross_validation: Scores
    pairs: Pairs | None  # poses reached from both sides; if present, the model is fitted to their means
    advice: tuple[tuple[Array, float], ...]  # pose (n,) [rad], information that it adds [nat]
    warnings: tuple[str, ...]
    seconds: float  # CPU time on one core [s]

    @property
    def model(self) -> GravityModel:
        """The gravity model."""
        return self.fitted.model


@fit.on_one_core
def gravity(
    train: str | Path | Sequence[str | Path],
    arm: Arm | str,
    *,
    model: str = forms.DEFAULT,
    test: str | Path | None = None,
) -> Calibration:
    """Identify the torques that hold an arm against gravity, springs and cables.

    Args:
        train: static recordings (CSV, see `read_static`), rows in the order of visits.
        arm: the arm, or "mtml" or "mtmr".
        model: one of `palpate.arm.identify.forms.FORMS`.
        test: a recording of other poses, used for scoring only.

    Raises:
        RecordingError: the recordings are not usable (see `read_static`), or hold too few or too similar poses. The
            message names the parameters that cannot be identified.
    """
    began = time.process_time()
    arm = named_arm(arm)
    if model not in forms.FORMS:
        raise RecordingError(f"there is no gravity model {model!r}", mend=f"choose one of {', '.join(forms.FORMS)}")
    poses = read_static(train, arm)
    unseen = read_static(test, arm) if test is not None else None
    joints = tuple(np.flatnonzero(measured := measured_joints(poses)).tolist())
    pairs = find_pairs(poses, joints)
    poses = on_levels(poses if pairs is None else pairs.means)
    found = identifiability(poses.q, measured, arm)
    _require_rich(poses, found)
    fitted = _with_friction_of(pairs, fit_poses(poses, arm, model, measured))
    test_scores = scores.score(fitted, unseen, joints, arm) if unseen is not None else None
    validated = scores.cross_validate(fitted, poses, joints, arm)
    judged, count = (validated, len(poses)) if unseen is None or test_scores is None else (test_scores, len(unseen))
    return Calibration(
        fitted=fitted,
        poses=poses,
        unseen=unseen,
        identifiability=found,
        joints=joints,
        train=scores.score(fitted, poses, joints, arm),
        test=test_scores,
        cross_validation=validated,
        pairs=pairs,
        advice=tuple(next_poses(fitted, measured, arm)),
        warnings=(*_warnings(fitted, poses, unseen, arm), *scores.remarks(judged, joints, count, unseen is not None)),
        seconds=time.process_time() - began,
    )


def _with_friction_of(pairs: Pairs | None, fitted: Fitted) -> Fitted:
    """The fitted model with the joint friction that the pairs show; unchanged without pairs."""
    if pairs is None:
        return fitted
    friction = np.median(pairs.half_difference, axis=0)[:, None]
    return replace(fitted, model=replace(fitted.model, friction=friction, motor_friction=False))


def measured_joints(poses: Static) -> NDArray[np.bool_]:
    """(n,) mask of joints whose torque varies and therefore was measured."""
    return np.asarray(poses.tau.std(axis=0) > _SILENT)


def named_arm(arm: Arm | str) -> Arm:
    """The arm that a name on the command line denotes.

    Raises:
        RecordingError: the name is unknown.
    """
    if isinstance(arm, Arm):
        return arm
    if arm not in _ARMS:
        raise RecordingError(f"there is no arm {arm!r}", mend=f"name {' or '.join(_ARMS)}, or pass an Arm")
    return Arm.mtm(_ARMS[arm])


def _require_rich(poses: Static, found: Identifiability) -> None:
    where = ", ".join(poses.files)
    if len(poses) < _FEWEST:
        repeats = f"; {poses.samples} rows repeat them" if poses.samples > len(poses) else ""
        lost = f"; these poses do not identify {', '.join(found.weak)}" if found.weak else ""
        raise RecordingError(
            f"{len(poses)} different poses",
            where=where,
            why=f"at least {_FEWEST} are needed to separate masses, springs and friction{repeats}{lost}",
            mend="record more poses, spread over the joint limits",
        )
    if found.rank < found.structural_rank:
        raise RecordingError(
            f"the poses are too much alike: they show {found.rank} of {found.structural_rank} base parameters",
            where=where,
            why=f"these poses do not identify {', '.join(found.weak)}",
            mend="record poses that differ in every joint and cover its range",
        )


def _warnings(fitted: Fitted, poses: Static, unseen: Static | None, arm: Arm) -> list[str]:
    warnings = []
    for stop in fitted.model.stops:
        end = "upper" if stop.side > 0 else "lower"
        warnings.append(
            f"joint {stop.joint + 1} leaned on its {end} stop beyond {stop.at:.3f} rad: kept out of the model"
        )
    if unseen is not None:
        outside = int(fitted.model.region.outside(unseen.q, arm, 6).sum())
        if outside:
            warnings.append(f"{outside} of {len(unseen)} test poses lie outside of the trained region")
        shared = sum((np.abs(poses.q - q).max(axis=1) < 1e-6).any() for q in unseen.q)
        if shared:
            warnings.append(f"{shared} of {len(unseen)} test poses were trained on: not unseen")
    if not poses.start.all() and poses.samples > len(poses):
        warnings.append(f"{poses.samples} rows are {len(poses)} poses: repeated ones were averaged")
    swapped = scores.actuator_side(poses, arm)
    if swapped is not None:
        warnings.append(swapped)
    return warnings
