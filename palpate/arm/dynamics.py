"""Identified dynamics of an arm: links and drive train, and their conversion to and from a model file.

tau_drive = A^T (M(q) a + C(q, v) v + G(q)) + terms(q, v, a) . theta,     q = A q_drive
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from palpate import _core
from palpate.arm.arm import Arm
from palpate.arm.drives import At, DriveMotion, DriveTrain, drive_train
from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate.base.errors import RecordingError

CUTOFF = 2.0  # low-pass cutoff of measured and predicted torques; the excitation lies below it [Hz]


@dataclass
class Dynamics:
    """An identified arm. Drive coordinates are those of the recording; `train.coupling` maps them to the joints."""

    arm: Arm
    pi: Array  # (10n,) inertial parameters of the links, in Pinocchio's order
    theta: Array  # (t,) parameters of the drive train's terms
    at: At = "drives"  # coordinates of the recording
    cutoff: float = CUTOFF
    trained: tuple[str, ...] = ()
    rank: int = 0  # rank of the whitened regressor
    condition: float = 0.0  # condition number of its identifiable part
    unknown: tuple[str, ...] = ()  # parameters that the motion hardly identified
    deviation: Array = field(default_factory=lambda: np.zeros(0))  # (t,) standard deviations of theta; () from a file
    misfit: Array = field(default_factory=lambda: np.zeros(0))  # (m,) residual over the torque's noise; () from a file
    train: DriveTrain = field(init=False)
    links: _core.Arm = field(init=False)  # the arm with the identified links

    def __post_init__(self) -> None:
        self.train = drive_train(self.arm, self.at)
        self.links = self.arm.with_inertial_parameters(self.pi)

    def torque(self, q: Array, v: Array, a: Array) -> Array:
        """Drive torque (k, m) of a motion in drive coordinates (k, m): inverse dynamics plus terms [N m, N]."""
        s = self.train.state(q, v, a)
        links = np.array([self.links.inverse_dynamics(*row) for row in zip(s.q, s.v, s.a, strict=True)])
        return np.asarray(links @ self.train.coupling + self.terms(s))

    def terms(self, s: DriveMotion, leave_out: str = " ") -> Array:
        """Drive torque (k, m) of the drive train, without the terms whose name begins with `leave_out`."""
        kept = ((t, x) for t, x in zip(self.train.terms, self.theta, strict=True) if not t.name.startswith(leave_out))
        return np.asarray(sum(x * term.column(s) for term, x in kept))

    def intervals(self) -> Array:
        """95 % intervals (t, 2) of theta; those of terms that cannot be negative end at zero."""
        ends = self.theta[:, None] + 1.96 * self.deviation[:, None] * [-1.0, 1.0]
        positive = np.array([term.positive for term in self.train.terms])
        return np.where(positive[:, None], np.maximum(ends, 0.0), ends)

    def masses(self) -> Array:
        """Link masses (n,) [kg]; mostly given by the prior, because a motion identifies torques rather than masses."""
        return self.pi[::10]


def to_data(d: Dynamics) -> Content:
    """The content of a model file."""
    names = d.arm.joint_names
    return {
        "dynamics": d.arm.name,
        "recorded_at": d.at,
        "trained_on": list(d.trained),
        "cutoff_Hz": d.cutoff,
        "links": [
            {"after_joint": name, "parameters": [float(x) for x in pi]}
            for name, pi in zip(names, d.pi.reshape(-1, 10), strict=True)
        ],
        "terms": {t.name: float(x) for t, x in zip(d.train.terms, d.theta, strict=True)},
    }


def from_data(data: Any, arm: Arm, where: str) -> Dynamics:
    """Build the model from the content of a file.

    Raises:
        RecordingError: the content is not a dynamics model, or is that of another arm.
    """
    if not isinstance(data, dict) or "dynamics" not in data:
        raise RecordingError("not a dynamics model", where=where, mend="palpate calibrate dynamics writes one")
    if data["dynamics"] != arm.name:
        raise RecordingError(
            f"this is the model of {data['dynamics']!r}", where=where, why=f"the arm is {arm.name!r}",
            mend="name the arm it was identified from, or its own model",
        )  # fmt: skip
    try:
        terms = [t.name for t in drive_train(arm, data["recorded_at"]).terms]
        pi = np.array([link["parameters"] for link in data["links"]], dtype=float).ravel()
        theta = np.array([data["terms"][name] for name in terms], dtype=float)
        return Dynamics(arm, pi, theta, data["recorded_at"], float(data["cutoff_Hz"]), tuple(data["trained_on"]))
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        raise RecordingError("the model is broken", where=where, why=str(error), mend="identify it again") from None
