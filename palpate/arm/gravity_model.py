"""Gravity model of an arm, identified from poses at which it was held, and its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import numpy as np
import yaml
from numpy.typing import NDArray

from palpate import _core
from palpate.arm.arm import Arm
from palpate.arm.coupling import coupling, drives
from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate.base.arrays.yaml_loader import read_yaml
from palpate.base.errors import OutputError, RecordingError, refuse_to_overwrite

_TITLE = """\
# Gravity model of one {arm}: what holds it still, identified from {poses} poses. Written by `palpate calibrate`.
# In a scene:  arms: {{leader: {{gravity_model: {name}}}}}
"""


@dataclass(frozen=True)
class Stop:
    """Stop of a joint: holding torque side stiffness max(0, side (q - at)) of its drive, smoothed over `width`.

    The model includes it in predicted measurements but never compensates it.
    """

    joint: int  # from 0
    side: int  # +1 upper, -1 lower end
    at: float  # position of the stop [rad]
    stiffness: float  # [N m/rad]
    width: float = 0.01  # [rad] repeatability of homing between recordings

    def torque(self, q: Array) -> Array:
        """Holding torque of the joint's drive at joint positions q (k, n) [N m]."""
        x = self.side * (q[:, self.joint] - self.at) / self.width
        return np.asarray(self.side * self.stiffness * self.width * np.logaddexp(0.0, x))


@dataclass(frozen=True)
class TrainingRegion:
    """Training region of a model: ranges of the joints and of the drives [rad], each (n,)."""

    q_min: Array
    q_max: Array
    motor_min: Array
    motor_max: Array

    @classmethod
    def of(cls, q: Array, arm: Arm) -> Self:
        """The region of the poses q (k, n)."""
        m = drives(q, arm)
        return cls(q.min(axis=0), q.max(axis=0), m.min(axis=0), m.max(axis=0))

    def outside(self, q: Array, arm: Arm, joints: int) -> NDArray[np.bool_]:
        """Mask (k,) of the poses q (k, n) that leave the region by more than 3 % of a range."""
        m = drives(q, arm)
        away = np.zeros(len(q), dtype=bool)
        for x, low, high in ((q, self.q_min, self.q_max), (m, self.motor_min, self.motor_max)):
            margin = 0.03 * (high - low) + 1e-6
            away |= ((x < low - margin) | (x > high + margin))[:, :joints].any(axis=1)
        return away


@dataclass(frozen=True)
class GravityModel:
    """Holding torque Phi(q) theta, evaluated in C++; friction and stops only predict what a recording shows."""

    arm: str
    form: str
    terms: _core.GravityTerms
    theta: Array
    friction: Array  # (n, k): Coulomb torque of drive i is its direction times sum_k c_ik x_i^k [N m]
    motor_friction: bool  # True: friction acts at the motors (through the coupling); False: at the joints
    region: TrainingRegion
    visited: Array  # (k, n) training poses, for expected approach directions [rad]
    stops: tuple[Stop, ...] = ()
    notes: Mapping[str, object] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.theta).all() and np.isfinite(self.friction).all()):
            raise ValueError("a parameter is not a finite number")

    def require(self, arm: Arm, where: str = "") -> None:
        """Check that the model belongs to this arm.

        Raises:
            RecordingError: it belongs to another arm; the message names both.
        """
        if arm.name != self.arm:
            raise RecordingError(
                f"the gravity model is of {self.arm}, the arm is {arm.name}",
                where=where,
                mend="identify this arm from recordings of its own, or choose the other arm",
            )

    def apply(self, arm: Arm) -> Arm:
        """Set this model as the gravity compensation of `arm` (in place) and return `arm`."""
        self.require(arm)
        arm.set_gravity_model(self.terms, self.theta)
        return arm

    def holding(self, q: Array, arm: Arm) -> Array:
        """Holding torques (k, n) at poses q (k, n) for a controller: without friction and stops [N m]."""
        return np.asarray(arm.gravity_columns(self.terms, np.atleast_2d(q)) @ self.theta)

    def drives(self, q: Array, arm: Arm) -> Array:
        """Positions (k, n) of the drives with friction, motors or joints, at joint positions q (k, n) [rad]."""
        return drives(q, arm) if self.motor_friction else q

    def measured(self, q: Array, arm: Arm, direction: Array) -> Array:
        """Torques (k, n) that a recording shows at q if the drives approached in `direction` (k, n), -1 .. 1 [N m]."""
        tau = self.holding(q, arm) + friction_torque(self.friction, self.motor_friction, q, direction, arm)
        to_joints = np.linalg.inv(coupling(arm)).T
        for stop in self.stops:
            tau += stop.torque(q)[:, None] * to_joints[:, stop.joint]
        return tau

    def save(self, path: str | Path, force: bool = False) -> None:
        """Write the model (YAML).

        Raises:
            OutputError: the file exists and `force` is not given, or cannot be written.
        """
        path = Path(path)
        refuse_to_overwrite(path, force)
        text = _TITLE.format(arm=self.arm, poses=len(self.visited), name=path.name)
        text += yaml.safe_dump(self._data(), sort_keys=False, default_flow_style=None, width=110)
        try:
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            why = error.strerror or str(error)
            raise OutputError("the file cannot be written", where=str(path), why=why, mend="use --out") from None

    def _data(self) -> Content:
        return {
            "kind": "gravity",
            "arm": self.arm,
            "form": self.form,
            "terms": {
                "masses": self.terms.masses,
                "degree": self.terms.degree,
                "fields": [
                    {"joints": f.joints, "length": f.length.tolist(), "centres": f.centres.tolist()}
                    for f in self.terms.fields
                ],
            },
            "theta": self.theta.tolist(),
            "friction": {"of": "motors" if self.motor_friction else "joints", "coulomb": self.friction.tolist()},
            "stops": [dict(vars(stop)) for stop in self.stops],
            "region": {key: value.tolist() for key, value in vars(self.region).items()},
            "visited": np.round(self.visited, 6).tolist(),
            "notes": dict(self.notes),
        }

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a model file.

        Raises:
            RecordingError: the file cannot be read or is not a gravity model; the message names what is missing.
        """
        path = Path(path)
        try:
            data = read_yaml(path)
        except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
            why = getattr(error, "strerror", None) or str(error).partition("\n")[0]
            raise RecordingError("the gravity model cannot be read", where=str(path), why=why) from None
        try:
            return cls._from(data)
        except (KeyError, TypeError, ValueError) as error:
            raise RecordingError(
                "this is not a gravity model",
                where=str(path),
                why=f"{error} is missing" if isinstance(error, KeyError) else str(error),
                mend="write one with palpate calibrate gravity",
            ) from None

    @classmethod
    def _from(cls, data: Content) -> Self:
        if data["kind"] != "gravity":
            raise ValueError(f"its kind is {data['kind']!r}")
        terms = data["terms"]
        fields = [_core.Field(f["joints"], np.array(f["centres"], ndmin=2), f["length"]) for f in terms["fields"]]
        return cls(
            arm=str(data["arm"]),
            form=str(data["form"]),
            terms=_core.GravityTerms(bool(terms["masses"]), int(terms["degree"]), fields),
            theta=np.array(data["theta"], dtype=float),
            friction=np.array(data["friction"]["coulomb"], dtype=float),
            motor_friction=data["friction"]["of"] == "motors",
            region=TrainingRegion(**{key: np.array(value, dtype=float) for key, value in data["region"].items()}),
            visited=np.array(data["visited"], dtype=float),
            stops=tuple(Stop(**stop) for stop in data["stops"]),
            notes=dict(data.get("notes") or {}),
        )


def friction_torque(coulomb: Array, of_motors: bool, q: Array, direction: Array, arm: Arm) -> Array:
    """Joint torques (k, n) of dry friction for approach directions (k, n); see `GravityModel.friction` [N m]."""
    x = drives(q, arm) if of_motors else q
    powers = np.stack([x**k for k in range(coulomb.shape[1])], axis=2)
    tau = direction * np.einsum("ijk,jk->ij", powers, coulomb)
    return np.asarray(tau @ np.linalg.inv(coupling(arm)) if of_motors else tau)
