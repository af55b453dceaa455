"""Drive train of an arm: friction, rotors, springs, cables, and the coupling of motors and joints.

Every term is a column of the regressor: the drive torque per unit of its parameter. The coupling maps joint torques to
drive torques: tau_drive = A^T tau_joint for q_joint = A q_drive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from palpate.arm.arm import Arm
from palpate.base.arrays import Array

At = Literal["drives", "joints"]

PRESLIDING = {"revolute": 0.01, "prismatic": 5e-4}  # presliding displacement after a reversal [rad, m]
CABLE = 0.1  # prior deviation of a cable spring, as a fraction of the joint's torque


Column = Callable[["DriveMotion"], Array]


@dataclass(frozen=True)
class Term:
    """One parameter of the drive train. `column` gives the drive torque (k, m) per unit of it, for k states."""

    name: str
    column: Column
    positive: bool = False
    share: float = 1.0  # prior standard deviation, as a fraction of the drive torque


@dataclass(frozen=True)
class DriveMotion:
    """A motion in joint and in drive coordinates."""

    q: Array  # (k, n) joints
    v: Array
    a: Array
    q_drive: Array  # (k, m)
    v_drive: Array
    a_drive: Array


@dataclass(frozen=True)
class DriveTrain:
    """Coupling A (n, m) of q_joint = A q_drive, and the terms of the drives."""

    coupling: Array
    terms: tuple[Term, ...]

    def state(self, q_drive: Array, v_drive: Array, a_drive: Array) -> DriveMotion:
        """A motion (k, m) in drive coordinates, completed by its joint coordinates."""
        A = self.coupling.T
        return DriveMotion(q_drive @ A, v_drive @ A, a_drive @ A, q_drive, v_drive, a_drive)


def drive_train(arm: Arm, at: At = "drives") -> DriveTrain:
    """Drive train of an arm recorded at its drives, or at its joints (ROS: measured_js), each joint then being a drive.

    Da Vinci arms have the drives of the research kit; other arms have the coupling of their model file.
    """
    kind = arm.name.split("_")[0]
    if at == "joints":
        A, specific = np.eye(arm.n), (_mtm_springs if kind == "mtm" else _joint_springs)
    elif kind == "psm":
        A, specific = _PSM_COUPLING, _psm
    else:
        A, specific = arm.leader_options().coupling, (_mtm if kind == "mtm" else _joint_springs)
    revolute = np.abs(arm.jacobian(arm.home)[3:]).max(axis=0) > 1e-9
    presliding = [PRESLIDING["revolute" if j >= arm.n or revolute[j] else "prismatic"] for j in range(A.shape[1])]
    return DriveTrain(A, (*_each_drive(A, presliding), *specific(A)))


def _each_drive(A: Array, presliding: list[float]) -> Iterator[Term]:
    for j, displacement in enumerate(presliding):
        yield Term(f"coulomb_{j + 1}", _at_drive(A, j, _dry(j, displacement)), True)
        yield Term(f"viscous_{j + 1}", _at_drive(A, j, _speed(j)), True)
        yield Term(f"offset_{j + 1}", _at_drive(A, j, lambda s: np.ones(len(s.q))))
        yield Term(f"rotor_{j + 1}", _at_drive(A, j, _acceleration(j)), True)


def _joint_springs(A: Array) -> Iterator[Term]:
    for i in range(A.shape[0]):
        yield _spring(A, i)


def _mtm(A: Array) -> Iterator[Term]:
    """Springs of the MTM, and friction at the joints that two motors drive together."""
    yield from _mtm_springs(A)
    for i in (2, 3):
        yield Term(f"joint_coulomb_{i + 1}", _at_joint(A, i, _dry_joint(i)), True)
        yield Term(f"joint_viscous_{i + 1}", _at_joint(A, i, _speed_joint(i)), True)


def _mtm_springs(A: Array) -> Iterator[Term]:
    """Wrist spring, platform cable and counterbalance of the MTM, and weak cables."""
    for i in (0, 2, 5, 6):
        yield _spring(A, i)
    for power in (1, 2, 3):
        yield Term(f"cable_4_{power}", _at_joint(A, 3, _power(3, power)))
    yield Term("wrist_spring_sin", _at_joint(A, 4, lambda s: np.sin(s.q[:, 4])))
    yield Term("wrist_spring_cos", _at_joint(A, 4, lambda s: np.cos(s.q[:, 4])))
    forearm = A[1] + A[2]  # gradient of the forearm's absolute angle q2 + q3
    yield Term("counterbalance_cos", lambda s: np.outer(np.cos(s.q[:, 1] + s.q[:, 2]), forearm))
    yield Term("counterbalance_sin", lambda s: np.outer(np.sin(s.q[:, 1] + s.q[:, 2]), forearm))


#: One motor each drives yaw, pitch, insertion and roll. The instrument's cables couple wrist and jaws (LND 400006,
#: values of the research kit's software):
#: pitch = 1.0186 m5, yaw = -0.8306 m5 + 0.6089 (m6 + m7), jaw = 1.2177 (m7 - m6).
_PSM_COUPLING = np.array(
    [
        [1, 0, 0, 0, 0, 0, 0],
        [0, 1, 0, 0, 0, 0, 0],
        [0, 0, 1, 0, 0, 0, 0],
        [0, 0, 0, 1, 0, 0, 0],
        [0, 0, 0, 0, 1.0186, 0, 0],
        [0, 0, 0, 0, -0.8306, 0.6089, 0.6089],
    ]
)
_PSM_JAW = np.array([0, 0, 0, 0, 0, -1.2177, 1.2177])


def _psm(A: Array) -> Iterator[Term]:
    """Roll spring of the PSM, springs of wrist and jaws (their sheaths), friction at the wrist's yaw axis."""
    yield Term("roll_spring", _at_joint(A, 3, lambda s: s.q[:, 3]))
    yield _spring(A, 0)
    yield _spring(A, 4, 1.0)
    yield _spring(A, 5, 1.0)
    yield Term("joint_coulomb_6", _at_joint(A, 5, _dry_joint(5)), True)
    yield Term("joint_viscous_6", _at_joint(A, 5, _speed_joint(5)), True)
    yield Term("jaw_coulomb", lambda s: np.outer(dahl(s.q_drive @ _PSM_JAW, PRESLIDING["revolute"]), _PSM_JAW), True)
    yield Term("jaw_viscous", lambda s: np.outer(s.v_drive @ _PSM_JAW, _PSM_JAW), True)
    yield Term("jaw_spring", lambda s: np.outer(s.q_drive @ _PSM_JAW, _PSM_JAW))


def _spring(A: Array, joint: int, share: float = CABLE) -> Term:
    return Term(f"spring_{joint + 1}", _at_joint(A, joint, lambda s: s.q[:, joint]), share=share)


def _dry(drive: int, presliding: float) -> Column:
    return lambda s: dahl(s.q_drive[:, drive], presliding)


def _speed(drive: int) -> Column:
    return lambda s: s.v_drive[:, drive]


def _acceleration(drive: int) -> Column:
    return lambda s: s.a_drive[:, drive]


def _dry_joint(joint: int) -> Column:
    return lambda s: dahl(s.q[:, joint], PRESLIDING["revolute"])


def _speed_joint(joint: int) -> Column:
    return lambda s: s.v[:, joint]


def _power(joint: int, power: int) -> Column:
    return lambda s: (s.q[:, joint] / 3.0) ** power


def _at_drive(A: Array, drive: int, f: Column) -> Column:
    unit = np.eye(A.shape[1])[drive]
    return lambda s: np.outer(f(s), unit)


def _at_joint(A: Array, joint: int, f: Column) -> Column:
    return lambda s: np.outer(f(s), A[joint])


def dahl(q: Array, presliding: float) -> Array:
    """Unit dry friction (k,) along a path q (k,), which reverses over a displacement `presliding` (Dahl, 1968).

    dz = (dq - |dq| z) / presliding, integrated exactly over each step.
    """
    dq = np.diff(q, prepend=q[:1])
    steady, decay = np.sign(dq), np.exp(-np.abs(dq) / presliding)
    z, friction = 0.0, np.empty(len(q))
    for k in range(len(q)):
        z = steady[k] + (z - steady[k]) * decay[k]
        friction[k] = z
    return friction
