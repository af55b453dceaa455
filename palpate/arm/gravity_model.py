"""A gravity model as a file: what holds an arm, as identified from poses it was held at."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np
import yaml
from numpy.typing import NDArray

from palpate import _core
from palpate.arm.arm import Arm
from palpate.arm.coupling import coupling, drives
from palpate.arrays import Array
from palpate.errors import OutputError, RecordingError, refuse_to_overwrite

_TITLE = """\
# Gravity model of one {arm}: what holds it still, identified from {poses} poses. Written by `palpate calibrate`.
# In a scene:  arms: {{leader: {{gravity_model: {name}}}}}
"""


@dataclass(frozen=True)
class Stop:
    """A joint that leaned on its stop: tau of its drive = -side stiffness max(0, side (q - at)), softened by `width`.

    Predicted where recordings show it, never compensated.
    """

    joint: int  # from 0
    side: int  # +1 upper, -1 lower end
    at: float  # [rad]
    stiffness: float  # [N m/rad]
    width: float = 0.01  # [rad] joints are homed anew for each recording: about so well

    def torque(self, q: Array) -> Array:
        """Holding torque of the joint's drive at joint positions q (k, n) [N m]."""
        x = self.side * (q[:, self.joint] - self.at) / self.width
        return np.asarray(self.side * self.stiffness * self.width * np.logaddexp(0.0, x))


@dataclass(frozen=True)
class Region:
    """Where a model was trained: ranges of joints and of drives [rad], and the poses, for expected directions."""

    q_min: Array
    q_max: Array
    motor_min: Array
    motor_max: Array

    @classmethod
    def of(cls, q: Array, arm: Arm) -> Self:
        """Of the poses q (k, n)."""
        m = drives(q, arm)
        return cls(q.min(axis=0), q.max(axis=0), m.min(axis=0), m.max(axis=0))

    def outside(self, q: Array, arm: Arm, joints: int) -> NDArray[np.bool_]:
        """(k,) poses that leave it by more than 3 % of a range."""
        m = drives(q, arm)
        away = np.zeros(len(q), dtype=bool)
        for x, low, high in ((q, self.q_min, self.q_max), (m, self.motor_min, self.motor_max)):
            margin = 0.03 * (high - low) + 1e-6
            away |= ((x < low - margin) | (x > high + margin))[:, :joints].any(axis=1)
        return away


@dataclass(frozen=True)
class GravityModel:
    """tau that holds the arm = Phi(q) theta, evaluated in C++; friction and stops apart, to explain recordings."""

    arm: str
    form: str
    terms: _core.GravityTerms
    theta: Array
    friction: Array  # (n, k): Coulomb torque of drive i is its direction times sum_k c_ik x_i^k [N m]
    motor_friction: bool  # drives are the motors (through the coupling), else the joints
    region: Region
    visited: Array  # (k, n) poses it was trained on [rad]
    stops: tuple[Stop, ...] = ()
    notes: dict[str, Any] = field(default_factory=dict)

    def require(self, arm: Arm, where: str = "") -> None:
        """Refuse another arm.

        Raises:
            RecordingError: names both arms.
        """
        if arm.name != self.arm:
            raise RecordingError(
                f"the gravity model is of {self.arm}, the arm is {arm.name}",
                where=where,
                mend="identify this arm from recordings of its own, or choose the other arm",
            )

    def apply(self, arm: Arm) -> Arm:
        """Let `arm` be held by this model (in place) and return it."""
        self.require(arm)
        arm.set_gravity_model(self.terms, self.theta)
        return arm

    def holding(self, q: Array, arm: Arm) -> Array:
        """Torques that hold `arm` at poses q (k, n), as the controller has them: no friction, no stops [N m]."""
        return np.asarray(arm.gravity_columns(self.terms, np.atleast_2d(q)) @ self.theta)

    def drives(self, q: Array, arm: Arm) -> Array:
        """Positions (k, n) of what rubs, at joint positions q (k, n): the motors, or the joints themselves [rad]."""
        return drives(q, arm) if self.motor_friction else q

    def measured(self, q: Array, arm: Arm, direction: Array) -> Array:
        """Torques (k, n) that a recording shows at q, drives having come in `direction` (k, n), -1 .. 1."""
        tau = self.holding(q, arm) + friction_torque(self.friction, self.motor_friction, q, direction, arm)
        out = np.linalg.inv(coupling(arm)).T
        for stop in self.stops:
            tau += stop.torque(q)[:, None] * out[:, stop.joint]
        return tau

    # -- file ------------------------------------------------------------------------------------------------------

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

    def _data(self) -> dict[str, Any]:
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
            "notes": self.notes,
        }

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a model file.

        Raises:
            RecordingError: it cannot be read, or is no gravity model; names what is missing.
        """
        path = Path(path)
        try:
            data = yaml.safe_load(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
            why = getattr(error, "strerror", None) or str(error).partition("\n")[0]
            raise RecordingError("the gravity model cannot be read", where=str(path), why=why) from None
        try:
            return cls._from(data)
        except (KeyError, TypeError, ValueError) as error:
            raise RecordingError(
                "this is no gravity model",
                where=str(path),
                why=f"{error} is missing" if isinstance(error, KeyError) else str(error),
                mend="write one with palpate calibrate gravity",
            ) from None

    @classmethod
    def _from(cls, data: dict[str, Any]) -> Self:
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
            region=Region(**{key: np.array(value, dtype=float) for key, value in data["region"].items()}),
            visited=np.array(data["visited"], dtype=float),
            stops=tuple(Stop(**stop) for stop in data["stops"]),
            notes=dict(data.get("notes") or {}),
        )


def friction_torque(coulomb: Array, of_motors: bool, q: Array, direction: Array, arm: Arm) -> Array:
    """Joint torques (k, n) of dry friction, drives having come in `direction` (k, n); see `GravityModel.friction`."""
    x = drives(q, arm) if of_motors else q
    powers = np.stack([x**k for k in range(coulomb.shape[1])], axis=2)
    tau = direction * np.einsum("ijk,jk->ij", powers, coulomb)
    return np.asarray(tau @ np.linalg.inv(coupling(arm)) if of_motors else tau)
