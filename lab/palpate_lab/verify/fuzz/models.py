"""Damaged model files of arms, URDFs and gravity models: each is read and computes finite numbers, or is refused."""

from __future__ import annotations

import json
import tempfile
import warnings
from functools import cache
from pathlib import Path

import numpy as np

from palpate.arm import Arm, dvrk_gravity
from palpate.arm.arm import models_folder
from palpate.arm.gravity_model import GravityModel
from palpate.base.errors import PalpateError
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.damage import damaged

KINDS = ("model", "urdf", "gravity", "dvrk")


def case(seed: int) -> dict[str, int]:
    """Read one damaged model and compute with it.

    Raises:
        FaultError: the model was accepted, but its pose, Jacobian or torque is not finite.
    """
    rng = np.random.default_rng(seed)
    kind = str(rng.choice(KINDS))
    with tempfile.TemporaryDirectory(prefix="palpate-fuzz-") as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            if kind in ("model", "urdf"):
                _compute(_arm(rng, kind, Path(folder)))
            else:
                _hold(rng, kind, Path(folder) / "gravity")
        except PalpateError:
            return {"refused": 1, kind: 1}
    return {"read": 1, kind: 1}


def _arm(rng: np.random.Generator, kind: str, folder: Path) -> Arm:
    name = str(
        rng.choice(["six_axis", "mtm_right", "psm_lnd", "delta"] if kind == "model" else ["six_axis", "mtm_right"])
    )
    for file in (f"{name}.yaml", f"{name}.urdf"):
        source = models_folder() / file
        if source.is_file():
            data = source.read_bytes()
            (folder / file).write_bytes(damaged(rng, data) if file.endswith("urdf") == (kind == "urdf") else data)
    return Arm.load(folder / f"{name}.yaml")


def _compute(arm: Arm) -> None:
    q = arm.home
    for what, value in {"pose": arm.fk(q), "Jacobian": arm.jacobian(q), "gravity": arm.gravity(q)}.items():
        if not np.isfinite(value).all():
            raise FaultError(f"{arm.name}: {what} is not finite at the home pose")


def _hold(rng: np.random.Generator, kind: str, path: Path) -> None:
    arm = Arm.mtm("right")
    path.write_bytes(damaged(rng, _gravity() if kind == "gravity" else _dvrk()))
    model = GravityModel.load(path) if kind == "gravity" else dvrk_gravity.load(path)
    model.require(arm)
    if not np.isfinite(model.holding(arm.home[None], arm)).all():
        raise FaultError(f"{kind}: the holding torque is not finite at the home pose")


@cache
def _dvrk() -> bytes:
    """A gravity compensation of the dVRK with random parameters."""
    rng, controller = np.random.default_rng(0), {}
    for sign in ("pos", "neg"):
        controller[f"gc_dynamic_params_{sign}"] = rng.normal(size=40).round(4).tolist()
    arm = Arm.mtm("right")
    controller["joint_position_lower_limit"] = np.degrees(arm.q_min).round(3).tolist()
    controller["joint_position_upper_limit"] = np.degrees(arm.q_max).round(3).tolist()
    return json.dumps({"ARM_NAME": "MTMR", "SN": "1", "GC_controller": controller}).encode()


@cache
def _gravity() -> bytes:
    """The same as a model file of Palpate."""
    with tempfile.TemporaryDirectory(prefix="palpate-fuzz-") as folder:
        source, target = Path(folder) / "gc.json", Path(folder) / "gravity.yaml"
        source.write_bytes(_dvrk())
        dvrk_gravity.load(source).save(target)
        return target.read_bytes()
