"""Small planning problems without scene files, for the tests of `palpate.planning`."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("ompl", reason="motion planning needs the extra planning")
pytest.importorskip("coal", reason="motion planning needs the extra planning")
pytest.importorskip("ruckig", reason="motion planning needs the extra planning")

from palpate import Arm
from palpate.planning.problem import Problem
from palpate.planning.robot import Robot
from palpate.planning.timing import Limits
from palpate.planning.world import World, obstacle
from palpate.world import surfaces


def at(x: float, y: float, z: float) -> np.ndarray:
    X = np.eye(4)
    X[:3, 3] = x, y, z
    return X


LYING = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])  # turns z to y


def psm(z: float = 0.0) -> Robot:
    """A PSM whose remote centre lies at height z [m]."""
    return Robot("PSM1", Arm.psm(), at(0.0, 0.0, z))


def posts() -> World:
    """Two thin posts and a ball below the remote centre."""
    thin = surfaces.Capsule(0.0005, 0.02, name="vessel")
    return World((
        obstacle("vessel", thin, at(0.03, 0.0, -0.12) @ LYING),
        obstacle("post", surfaces.Box([0.004, 0.05, 0.06], name="post"), at(-0.03, 0.0, -0.12)),
        obstacle("ball", surfaces.Sphere(0.01, name="ball"), at(0.0, 0.03, -0.13)),
    ))  # fmt: skip


def problem(world: World | None = None) -> Problem:
    robot = psm()
    home = robot.arm.home
    return Problem(robot, posts() if world is None else world, {"home": home, "current": home},
                   Limits.of(robot.arm, 0.2), 0.003)  # fmt: skip


def reaching(x: float, y: float, z: float) -> np.ndarray:
    """Joints (6,) of a PSM at the origin, wrist straight, whose tip is at (x, y, z) [m]."""
    arm = Arm.psm()
    q = arm.home.copy()
    for _ in range(40):
        away = np.array([x, y, z]) - arm.fk(q)[:3, 3]
        q[:3] += np.linalg.solve(arm.jacobian(q)[:3, :3], away)
    return q
