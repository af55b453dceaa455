"""The simulated arms of ``palpate study drift``: identification from recordings, sampling and release."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from palpate import _core
from palpate.arm import Arm
from palpate.arm.coupling import drives
from palpate.arm.gravity_model import friction_torque
from palpate.arm.identify import fit
from palpate.arm.identify.approach import directions
from palpate.arm.identify.fit_gravity import Fitted, fit_poses, predicted
from palpate.arm.identify.gravity import measured_joints, named_arm
from palpate.arm.identify.pairs import find_pairs
from palpate.arm.identify.recordings import Static, on_levels, read_static
from palpate.base.arrays import Array

PLANTS = ("as identified", "rough")
TIME = 2.0  # [s]

_DT, _SUBSTEPS = 1e-3, 2  # period of the controller [s]; plant steps per period
_AT_REST = 30  # cycles without motion after which the arm counts as resting
_UNKNOWN = 0.5  # assumed systematic fraction of the fit's residual if no grids in both directions were recorded
_CENTRES = 100
#: Length scales [rad] of potentials of all six joints, which no controller's model contains, and their main joints.
_BEYOND = (
    ((0.6, 0.25, 0.3, 6.0, 6.0, 6.0), slice(0, 3)),
    ((3.0, 1.5, 1.5, 1.5, 2.0, 1.0), slice(3, 6)),
)


@dataclass(frozen=True)
class Plant:
    """A simulated arm with the holding torques of a recorded one."""

    arm: Arm
    coulomb: Array  # (n,) dry friction of the joints [N m]
    motors: Array  # (n, 1) friction of the motors in recordings [N m]
    noise: Array  # (n,) torque noise of recordings [N m]
    measured: NDArray[np.bool_]  # (n,) joints with a recorded torque
    poses: Array  # (k, n) recorded poses [rad]
    beyond: Array  # (n,) rms torque outside the controller's form of model [N m]


def make_plants(recordings: Sequence[Path], arm: str) -> dict[str, Plant]:
    """Identify plants by name from recordings of `arm`: a gravity model, and potentials for its residual.

    In the plant "as identified" the potentials are fitted to the recordings. In the plant "rough" they explain the
    whole residual of poses that were reached from both sides.
    """
    model = named_arm(arm)
    grids = [file for file in recordings if "uniform" in file.name]
    poses = read_static([file for file in recordings if file not in grids] or grids, model)
    measured = measured_joints(poses)
    fitted = fit_poses(poses, model, "potential", measured)
    pairs = find_pairs(read_static(grids, model), tuple(np.flatnonzero(measured))) if len(grids) > 1 else None
    friction, residual = np.abs(fitted.model.friction[:, 0]), _UNKNOWN * fitted.noise
    if pairs is not None:  # half differences give the friction, means give a residual that is free of friction
        friction = np.maximum(friction, np.median(pairs.half_difference, axis=0))
        residual = fit_poses(on_levels(pairs.means), model, "potential", measured).noise

    fields, columns, weights = _beyond(fitted, poses, model)
    terms = _core.GravityTerms(degree=1, fields=[*fitted.model.terms.fields, *fields])
    plants = {}
    for name in PLANTS:
        scaled = weights if name == "as identified" else _scaled_to(residual, columns, weights)
        beyond = _rms(columns @ np.concatenate(scaled))
        chance = np.sqrt(np.maximum(fitted.noise**2 - beyond**2, 0.0)) * measured
        held = named_arm(arm)
        held.set_gravity_model(terms, np.concatenate([fitted.model.theta, *scaled]))
        plants[name] = Plant(held, friction, fitted.model.friction, chance, measured, poses.q, beyond)
    return plants


def _beyond(fitted: Fitted, poses: Static, arm: Arm) -> tuple[list[_core.Field], Array, list[Array]]:
    """Potentials of all joints, their regressor columns (k, n, p) at the poses, and weights fitted to the residual."""
    residual = np.where(fitted.use, poses.tau - predicted(fitted.model, poses, arm), 0.0)
    centres = poses.q[np.random.default_rng(0).permutation(len(poses))[:_CENTRES], :6]
    fields = [_core.Field(list(range(6)), centres, length) for length, _ in _BEYOND]
    columns = arm.gravity_columns(_core.GravityTerms(masses=False, fields=fields), poses.q)
    scale = np.repeat([0.1 * min(length) for length, _ in _BEYOND], len(centres))  # prior: torques of about 0.01 N m
    x = fit.bayes(scale * columns, residual, np.maximum(fitted.noise, 1e-3), fitted.use).x
    return fields, columns, np.split(scale * x, len(_BEYOND))


def _scaled_to(residual: Array, columns: Array, weights: list[Array]) -> list[Array]:
    """Weights scaled so that each potential's rms torque at its main joints equals the residual [N m]."""
    parts = np.split(columns, len(weights), axis=2)
    torques = [_rms(part @ w)[j] for part, w, (_, j) in zip(parts, weights, _BEYOND, strict=True)]
    return [w * (residual[j] / tau).mean() for w, tau, (_, j) in zip(weights, torques, _BEYOND, strict=True)]


def _rms(tau: Array) -> Array:
    return np.asarray(np.sqrt((tau**2).mean(axis=0) + 1e-18))


def sampled(plant: Plant, count: int, seed: int, both_ways: bool = False) -> Static:
    """A simulated recording: ``count`` poses of the plant's region with motor friction and noise.

    both_ways: use the mean of two samples per pose, reached from below and from above, as the dVRK's calibration does.
    """
    q = unseen_poses(plant, count, seed)
    bare = Static(q, np.zeros_like(q), np.arange(count) == 0, ("simulated",), count)
    tau = np.array([plant.arm.holding(x) for x in q])
    if not both_ways:
        tau += friction_torque(plant.motors, True, q, directions(bare, drives(q, plant.arm)), plant.arm)
    noise = plant.noise * (0.5**0.5 if both_ways else 1.0) * np.random.default_rng(seed + 1).standard_normal(tau.shape)
    return replace(bare, start=bare.start | both_ways, tau=np.where(plant.measured, tau + noise, 0.0))


def unseen_poses(plant: Plant, count: int, seed: int) -> Array:
    """Random poses (count, n) within the joint limits, each an interpolation between two recorded poses [rad]."""
    rng = np.random.default_rng(seed)
    one, two = (plant.poses[rng.integers(0, len(plant.poses), count)] for _ in range(2))
    share = rng.uniform(0.0, 1.0, (count, 1))
    return np.clip(one + share * (two - one), plant.arm.q_min, plant.arm.q_max)


def release(plant: Plant, controller: Arm, q: Array) -> float:
    """Distance of the tip from its release point after `TIME`, with gravity compensation as the only control [m]."""
    options = plant.arm.leader_options()
    options.coulomb = plant.coulomb
    hand = _core.HandOptions()
    for name in ("mass", "damping", "stiffness", "inertia", "rotational_damping", "rotational_stiffness"):
        setattr(hand, name, 0.0)
    leader, none, still, nowhere = _core.Leader(plant.arm, options, hand), np.zeros(plant.arm.n), 0, np.eye(4)
    leader.reset(q)
    for _ in range(round(TIME / _DT)):
        leader.command(none, controller.holding(leader.q_measured), none)
        leader.step(_DT / _SUBSTEPS, nowhere, n=_SUBSTEPS)
        still = 0 if leader.v.any() else still + 1
        if still > _AT_REST:
            break
    return float(np.linalg.norm(plant.arm.fk(leader.q)[:3, 3] - plant.arm.fk(q)[:3, 3]))
