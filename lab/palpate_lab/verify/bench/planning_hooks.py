"""Queries that need a search: the jaws reach sideways into slots, on both sides of a wall, so that neither the straight
line of the joints nor retracting, turning and inserting is free."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from palpate.base.arrays import Array
from palpate.planning import goals, planners
from palpate.planning.checker import Checker
from palpate.planning.curves import line
from palpate.planning.kinematics import pose_of
from palpate.planning.problem import Problem
from palpate.planning.world import World, obstacle
from palpate.world import surfaces

CLEARANCE = 1e-3
_MIDDLE = np.array([-0.100, -0.090, -0.015])  # of the wall, at the height of the slots [m]
_EDGE = 0.045  # distance of the slots' openings from the wall [m]
_SLOT = 0.020  # height of the slots [m]
_OUT = 0.024  # displacement with which the jaws leave a slot [m]
_UP = 0.05  # insertion at which the instrument is above all of it [m]


def world() -> World:
    """A wall, and on each side of it a slot between two plates that opens towards the wall."""
    parts = {"wall": ([0.004, 0.12, 0.07], (0.0, 0.0, -0.005))}
    for side, name in ((-1.0, "left"), (1.0, "right")):
        x = side * (_EDGE + 0.02)
        parts[f"{name} roof"] = ([0.04, 0.12, 0.003], (x, 0.0, 0.5 * _SLOT + 0.0015))
        parts[f"{name} floor"] = ([0.04, 0.12, 0.003], (x, 0.0, -0.5 * _SLOT - 0.0015))
        parts[f"{name} back"] = ([0.003, 0.12, _SLOT], (x + side * 0.0185, 0.0, 0.0))
    placed = {name: pose_of(_MIDDLE + place, np.zeros(3)) for name, (_, place) in parts.items()}
    return World(tuple(obstacle(name, surfaces.Box(size), placed[name]) for name, (size, _) in parts.items()))


def queries(problem: Problem, count: int, seed: int = 0) -> Iterator[tuple[Array, Array]]:
    """Pairs of free joint positions with the jaws in the left and in the right slot, in random order.

    Each leaves its slot by a proved motion and is then free to retract, so that a motion exists. Pairs that the
    straight line or retracting solves are left out.
    """
    rng, checker = np.random.default_rng(seed), Checker(problem.robot, problem.world)
    while count > 0:
        one, two = (_in_slot(problem, checker, side, rng) for side in (-1.0, 1.0))
        if checker.blocked(line(one, two), problem.clearance) is None:
            continue
        if planners.retracting(checker, one, two, problem.clearance, time.monotonic() + 60.0) is not None:
            continue
        yield (one, two) if count % 2 else (two, one)
        count -= 1


def _in_slot(problem: Problem, checker: Checker, side: float, rng: np.random.Generator) -> Array:
    arm, X_BW = problem.robot.arm, np.linalg.inv(problem.robot.X_WB)
    while True:
        X = np.eye(4)
        z = np.array([side, 0.0, 0.0]) + rng.uniform(-0.25, 0.25, 3) * [0.0, 1.0, 0.6]
        z /= np.linalg.norm(z)
        x = np.cross(rng.normal(size=3), z)
        x /= np.linalg.norm(x)
        X[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
        depth, along, above = rng.uniform(-0.001, 0.004), rng.uniform(-0.03, 0.03), rng.uniform(-0.002, 0.002)
        X[:3, 3] = _MIDDLE + np.array([side * (_EDGE + depth), along, above])
        found = goals.solutions(arm, X_BW @ X, arm.home, int(rng.integers(1 << 30)))
        for q in [] if isinstance(found, goals.Unreachable) else found:
            if checker.refusal(q, problem.clearance + 3e-4) is None and _leaves(problem, checker, X, q, side):
                return q


def _leaves(problem: Problem, checker: Checker, X_WT: Array, q: Array, side: float) -> bool:
    """True if the jaws leave the slot sideways by a free motion, after which the instrument can retract."""
    out = X_WT.copy()
    out[0, 3] -= side * _OUT
    q_out, result = problem.robot.arm.ik_from(np.linalg.inv(problem.robot.X_WB) @ out, q)
    if not result.converged or not checker.free_line(q, q_out, problem.clearance):
        return False
    up = q_out.copy()
    up[2] = _UP
    return checker.free_line(q_out, up, problem.clearance)
