"""The dVRK's own gravity compensation: its ten parameters; reading and writing its JSON file.

tau_j = g Y10(q) p + sum_k a_jk q_j^k, one set (p, a) for each direction of motion; joints 2 and 3 are serial angles.
Source: sawIntuitiveResearchKit robGravityCompensationMTM; Lin et al., IROS 2019.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from palpate import _core
from palpate.arm.arm import Arm
from palpate.arm.coupling import coupling
from palpate.arm.gravity_model import GravityModel, TrainingRegion
from palpate.base import limits
from palpate.base.arrays import Array
from palpate.base.errors import OutputError, RecordingError, refuse_to_overwrite

PARAMETERS = 10
_JOINTS, _POWERS = 6, 5
_G = 9.81
_BLENDING: dict[str, list[float]] = {  # friction compensation by velocity: the controller's defaults
    "db_vel_vec": [0.02, 0.02, 0.02, 0.01, 0.008, 0.008, 0.01],
    "sat_vec_vec": [0.4, 0.2, 0.2, 0.4, 0.4, 0.2, 0.4],
    "fric_comp_ratio_vec": [0.7, 0.01, 0.5, 0.4, 0.2, 0.2, 1.0],
    "GC_init_pos": [0, 0, 0, 0, 90, 0, 0],
}


def regressor(q: Array) -> Array:
    """The dVRK's regressor Y10 (k, 7, 10) at q (k, 7), multiplied by g = 9.81 m/s^2."""
    s2, c2 = np.sin(q[:, 1]), np.cos(q[:, 1])
    s, c = np.sin(q[:, 1] + q[:, 2]), np.cos(q[:, 1] + q[:, 2])
    s4, c4, s5, c5 = np.sin(q[:, 3]), np.cos(q[:, 3]), np.sin(q[:, 4]), np.cos(q[:, 4])
    s6, c6 = np.sin(q[:, 5]), np.cos(q[:, 5])
    o = np.zeros(len(q))
    forearm = [c, -s, c * c4, -c * s4, -s * c5 - c * c4 * s5, c * c4 * c5 - s * s5,
               c * s4 * s6 + s * c6 * s5 - c * c4 * c5 * c6, c * c6 * s4 - s * s5 * s6 + c * c4 * c5 * s6]  # fmt: skip
    rows = [
        [o] * 10,
        [s2, c2, *forearm],
        [o, o, *forearm],
        [o, o, o, o, -s * s4, -s * c4, s * s4 * s5, -s * c5 * s4, s * (c4 * s6 + c5 * c6 * s4),
         s * (c4 * c6 - c5 * s4 * s6)],
        [o, o, o, o, o, o, -(c * s5 + s * c4 * c5), c * c5 - s * c4 * s5, -c * c5 * c6 + s * c4 * c6 * s5,
         c * c5 * s6 - s * c4 * s5 * s6],
        [o] * 8 + [s * c6 * s4 + c * s5 * s6 + s * c4 * c5 * s6, c * c6 * s5 - s * s4 * s6 + s * c4 * c5 * c6],
        [o] * 10,
    ]  # fmt: skip
    return _G * np.stack([np.stack(row, axis=1) for row in rows], axis=1)


def moments_of_parameters(arm: Arm) -> Array:
    """T (28, 10) of Pi = T p: masses and moments with Y Pi = Y10 p at every pose; zero for the last (roll) link."""
    q = np.random.default_rng(0).uniform(arm.q_min, arm.q_max, (60, arm.n))
    Y = arm.gravity_columns(_core.GravityTerms(), q).reshape(-1, 4 * arm.n)[:, : 4 * _JOINTS]
    T = np.zeros((4 * arm.n, PARAMETERS))
    T[: 4 * _JOINTS] = np.linalg.lstsq(Y, regressor(q).reshape(-1, PARAMETERS), rcond=1e-10)[0]
    return T


def load(path: str | Path) -> GravityModel:
    """Read a gravity model from the dVRK's JSON (``gc-MTMR-xxxxx.json``).

    The holding torque is the mean of both directions; half of their difference becomes dry friction.

    Raises:
        RecordingError: the file cannot be read or lacks a value; the message names it.
    """
    path = Path(path)
    try:
        data = limits.load_json(limits.read_text(path))
        sides = {"MTML": "left", "MTMR": "right"}
        arm = Arm.mtm(sides[str(data["ARM_NAME"])])
        controller = data["GC_controller"]
        up, down = (np.array(controller[f"gc_dynamic_params_{sign}"], dtype=float) for sign in ("pos", "neg"))
        ends = [np.radians(controller[f"joint_position_{end}_limit"]) for end in ("lower", "upper")]
        if not up.shape == down.shape == (PARAMETERS + _POWERS * _JOINTS,) or len(ends[0]) != arm.n:
            raise ValueError(f"{len(up)} and {len(down)} parameters where 40 are needed")
        if not np.isfinite(np.concatenate([up, down, *ends])).all():
            raise ValueError("a parameter is not a finite number")
        if (ends[0] > ends[1]).any():
            raise ValueError("a lower joint limit is above the upper one")
    except (OSError, UnicodeDecodeError, KeyError, TypeError, ValueError) as error:
        missing = f"{error} is missing or unknown" if isinstance(error, KeyError) else str(error)
        raise RecordingError(
            "this is no gravity compensation of the dVRK", where=str(path), why=missing,
            mend="name a gc-MTML-xxxxx.json or gc-MTMR-xxxxx.json",
        ) from None  # fmt: skip
    mean, half = 0.5 * (up + down), 0.5 * (up - down)
    friction = np.zeros((arm.n, _POWERS))
    friction[:_JOINTS] = half[PARAMETERS:].reshape(_JOINTS, _POWERS)
    polynomials = np.zeros((arm.n, _POWERS))
    polynomials[:_JOINTS] = mean[PARAMETERS:].reshape(_JOINTS, _POWERS)
    q = np.random.default_rng(0).uniform(ends[0], ends[1], (200, arm.n))
    return GravityModel(
        arm=arm.name,
        form="dvrk",
        terms=_core.GravityTerms(degree=_POWERS - 1),
        theta=np.concatenate([moments_of_parameters(arm) @ mean[:PARAMETERS], polynomials.ravel()]),
        friction=friction,
        motor_friction=False,
        region=TrainingRegion.of(np.concatenate([q, np.array(ends)]), arm),
        visited=q,
        notes={"imported": path.name, "serial": str(data.get("SN", ""))},
    )


def save(model: GravityModel, path: str | Path, serial: str = "", force: bool = False) -> Array:
    """Write a model as the dVRK's JSON; return the RMS error (6,) of the conversion over the training poses [N m].

    A model of the form ``dvrk`` is converted exactly; other forms are sampled and fitted. Friction becomes a constant
    or a polynomial per joint and direction.

    Raises:
        OutputError: the file exists, or cannot be written.
    """
    path = Path(path)
    refuse_to_overwrite(path, force)
    arm = Arm.mtm("left" if model.arm == "mtm_left" else "right")
    q = model.visited
    p, a = _parameters(model, arm, q)
    friction = _joint_friction(model, arm)
    holding = model.holding(q, arm)
    powers = np.stack([q[:, :_JOINTS] ** k for k in range(_POWERS)], axis=2)
    written = (regressor(q) @ p)[:, :_JOINTS] + np.einsum("kjp,jp->kj", powers, a)
    margin = np.abs(friction[:, 0])
    data = {
        "ARM_NAME": "MTML" if model.arm == "mtm_left" else "MTMR",
        "SN": serial or str(model.notes.get("serial", "")),
        "version": "2.0",
        "lse": {"g_constant": _G},
        "GC_controller": {
            "safe_upper_torque_limit": [*(holding.max(axis=0)[:_JOINTS] + margin).tolist(), 0.0],
            "safe_lower_torque_limit": [*(holding.min(axis=0)[:_JOINTS] - margin).tolist(), 0.0],
            **_BLENDING,
            "gc_dynamic_params_pos": [*p.tolist(), *(a + friction).ravel().tolist()],
            "gc_dynamic_params_neg": [*p.tolist(), *(a - friction).ravel().tolist()],
            "joint_position_upper_limit": np.degrees(model.region.q_max).round(6).tolist(),
            "joint_position_lower_limit": np.degrees(model.region.q_min).round(6).tolist(),
        },
    }
    try:
        path.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        why = error.strerror or str(error)
        raise OutputError("the file cannot be written", where=str(path), why=why, mend="use --out") from None
    return np.asarray(np.sqrt(((written - holding[:, :_JOINTS]) ** 2).mean(axis=0)))


def _parameters(model: GravityModel, arm: Arm, q: Array) -> tuple[Array, Array]:
    """Parameters p (10,) and polynomial coefficients (6, 5)."""
    terms = model.terms
    if terms.degree == _POWERS - 1 and not terms.fields:
        p = np.linalg.lstsq(moments_of_parameters(arm), model.theta[: 4 * arm.n], rcond=None)[0]
        return np.asarray(p, dtype=float), model.theta[4 * arm.n :].reshape(arm.n, _POWERS)[:_JOINTS]
    powers = np.zeros((len(q), arm.n, _JOINTS * _POWERS))
    for joint in range(_JOINTS):
        for k in range(_POWERS):
            powers[:, joint, _POWERS * joint + k] = q[:, joint] ** k
    C = np.concatenate([regressor(q), powers], axis=2)[:, :_JOINTS].reshape(_JOINTS * len(q), -1)
    x = np.linalg.lstsq(C, model.holding(q, arm)[:, :_JOINTS].ravel(), rcond=1e-8)[0]
    x = np.asarray(x, dtype=float)
    return x[:PARAMETERS], x[PARAMETERS:].reshape(_JOINTS, _POWERS)


def _joint_friction(model: GravityModel, arm: Arm) -> Array:
    """Friction (6, 5) of a joint that moves alone, as a polynomial of its position."""
    if not model.motor_friction:
        padded = np.zeros((_JOINTS, _POWERS))
        padded[:, : model.friction.shape[1]] = model.friction[:_JOINTS]
        return padded
    motors = np.abs(np.linalg.inv(coupling(arm)))  # element (i, j): motor i moves with joint j and acts on it
    constant = motors.T @ model.friction[:, 0]
    return np.asarray(np.pad(constant[:_JOINTS, None], ((0, 0), (0, _POWERS - 1))))
