"""Figures of a gravity calibration: the documented contract of ``palpate calibrate gravity --json`` (docs/json.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from palpate.arm.identify.gravity import Calibration
from palpate.arm.identify.pairs import PairFigures
from palpate.arm.identify.scores import Errors
from palpate.base.arrays import Array


@dataclass(frozen=True)
class OutlierFigures:
    """A torque that is excluded from the fit."""

    pose: int  # row of the recordings, from 0
    joint: int  # from 1
    tau: float  # [N m]
    why: str


@dataclass(frozen=True)
class StopFigures:
    """Stop of a joint, see `palpate.arm.gravity_model.Stop`."""

    joint: int  # from 1
    side: int
    at: float
    stiffness: float
    width: float


@dataclass(frozen=True)
class Advice:
    """A pose to record next."""

    q_rad: Array
    information_nat: float


@dataclass(frozen=True)
class Figures:
    """The figures, in the order in which they are written. Arrays have one value per measured joint."""

    model: str
    arm: str
    poses: int
    train: Errors
    test: Errors | None
    train_directed: Errors
    test_directed: Errors | None
    cross_validation_directed: Errors
    friction_floor_Nm: Array
    friction_Nm: Array
    friction_of: Literal["motors", "joints"]
    pairs: PairFigures | None
    std_Nm: Array
    coverage_95: Array
    std_factor_95: tuple[float, float, float] | None
    rank: int
    structural_rank: int
    condition: float
    base_parameters: tuple[str, ...]
    not_identifiable: tuple[str, ...]
    weak_parameters: tuple[str, ...]
    outliers: list[OutlierFigures]
    stops: list[StopFigures]
    outside: int
    advice: list[Advice]
    warnings: tuple[str, ...]
    seconds: float


def figures(c: Calibration) -> Figures:
    """The figures of a calibration."""
    model, found, judged = c.model, c.identifiability, c.test or c.train
    return Figures(
        model=model.form,
        arm=model.arm,
        poses=len(c.poses),
        train=c.train.undirected(),
        test=c.test.undirected() if c.test else None,
        train_directed=c.train.directed(),
        test_directed=c.test.directed() if c.test else None,
        cross_validation_directed=c.cross_validation.directed(),
        friction_floor_Nm=judged.floor,
        friction_Nm=np.round(np.abs(model.friction).max(axis=1), 6)[list(c.joints)],
        friction_of="motors" if model.motor_friction else "joints",
        pairs=c.pairs.figures(c.joints) if c.pairs else None,
        std_Nm=judged.std,
        coverage_95=judged.coverage,
        std_factor_95=c.test.deviation if c.test else None,
        rank=found.rank,
        structural_rank=found.structural_rank,
        condition=found.condition,
        base_parameters=found.base,
        not_identifiable=found.never,
        weak_parameters=found.weak,
        outliers=[OutlierFigures(o.pose, o.joint + 1, o.tau, o.why) for o in c.fitted.outliers],
        stops=[StopFigures(s.joint + 1, s.side, s.at, s.stiffness, s.width) for s in model.stops],
        outside=c.test.outside if c.test else 0,
        advice=[Advice(np.round(q, 4), gain) for q, gain in c.advice],
        warnings=c.warnings,
        seconds=c.seconds,
    )
