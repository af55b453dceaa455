"""An arm with known parameters: masses of its URDF, a smooth cable potential, dry friction of its motors, noise."""

from __future__ import annotations

import numpy as np

from palpate import Arm, _core
from palpate.arm.coupling import coupling, drives
from palpate.arm.gravity_model import friction_torque
from palpate.arm.identify.approach import directions
from palpate.arm.identify.recordings import Static

COULOMB = np.array([0.016, 0.025, 0.03, 0.03, 0.004, 0.002, 0.0])
NOISE = np.array([0.006, 0.010, 0.010, 0.004, 0.002, 0.001, 0.0])
LOW = np.array([-0.35, -0.25, -0.30, -1.3, -1.4, -0.7, 0.0])
HIGH = np.array([0.15, 0.16, 0.35, 3.2, 3.0, 0.7, 0.0])


def poses(count: int, seed: int) -> np.ndarray:
    """Random joints (count, 7) [rad] in the range of a real recording."""
    return np.random.default_rng(seed).uniform(LOW, HIGH, (count, 7))


def true_arm() -> Arm:
    """The arm with a cable whose potential depends on joints 1 to 3, and another cable around joint 4."""
    arm = Arm.mtm("right")
    fields = [
        _core.Field([0, 1, 2], np.array([[0.2, -0.1, 0.1], [-0.3, 0.2, -0.2]]), [0.6, 0.5, 0.9]),
        _core.Field([3], np.array([[0.5], [2.5]]), [1.2]),
    ]
    theta = np.concatenate([arm.moments, np.zeros(14), [0.035, -0.03], [0.03, -0.04]])
    arm.set_gravity_model(_core.GravityTerms(degree=1, fields=fields), theta)
    return arm


def recording(count: int, seed: int, noise: float = 1.0, friction: float = 1.0) -> Static:
    """A recording of random poses in the order of the visits."""
    arm, q = true_arm(), poses(count, seed)
    start = np.arange(count) == 0
    bare = Static(q, np.zeros_like(q), start, ("synthetic",), count)
    direction = directions(bare, drives(q, arm))
    tau = np.array([arm.holding(x) for x in q]) + friction_torque(friction * COULOMB[:, None], True, q, direction, arm)
    tau += noise * NOISE * np.random.default_rng(seed + 1).standard_normal(tau.shape)
    tau[:, 6] = 0.0
    return Static(q, tau, start, ("synthetic",), count)


def write(path, poses: Static, header: bool = True) -> None:
    """Write poses as a CSV file."""
    names = [f"q{k}_rad" for k in range(1, 8)] + [f"tau{k}_Nm" for k in range(1, 8)]
    rows = np.hstack([poses.q, poses.tau])
    np.savetxt(path, rows, delimiter=",", header=",".join(names) if header else "", comments="", fmt="%.9g")


__all__ = ["COULOMB", "NOISE", "coupling", "poses", "recording", "true_arm", "write"]
