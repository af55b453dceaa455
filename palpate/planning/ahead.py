"""Proves that what lies ahead on a plan is free in a world that changes while the plan is executed."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PlanningError
from palpate.planning.checker import Checker
from palpate.planning.problem import Problem
from palpate.planning.result import Plan
from palpate.planning.robot import Robot
from palpate.planning.sound import require_sound
from palpate.planning.world import World

_JAW = 1e-3  # angle by which the jaws may leave the range of the proof [rad]: 10 um at their ends
_NEAR = 2e-3  # distance of the measured joints from the plan's start, beyond which it does not begin [rad, m]


class Ahead:
    """The part of one plan that is proved free in the newest world.

    Args:
        robot: the instrument, with its jaws as they are during the motion.
        plan: the plan. One that was found in this process is known to be free in the world of its version; one from a
            file is proved anew, and so is one that was proved for other angles of the jaws.
    """

    def __init__(self, robot: Robot, plan: Plan) -> None:
        self._robot, self._plan = robot, plan
        self._trajectory = plan.trajectory
        low, high = robot.span
        covered = plan.jaw[0] - _JAW <= low and high <= plan.jaw[1] + _JAW
        self._version = "" if plan.from_file or not covered else plan.world_version
        self._checker: Checker | None = None
        self.until = self._trajectory.duration  #: time along the plan up to which it is proved free [s]

    def prove(self, world: World, begin: float, end: float) -> str:
        """Prove the plan free from one time along it to another [s]; where it is not, why, in words."""
        if world.version != self._version:
            self._version, self._checker, self.until = world.version, Checker(self._robot, world), begin
        if self._checker is None or self.until >= end:
            return ""
        clearance = self._plan.clearance_asked
        for curve in self._trajectory.between(max(begin, self.until), end):
            found = self._checker.blocked(curve, clearance)
            if found is not None:
                return f"{' and '.join(found.pair)} come nearer than {1e3 * clearance:g} mm ahead"
        self.until = end
        return ""


def require_speed(value: float) -> float:
    """The pace of a motion, 1: as planned.

    Raises:
        PlanningError: it lies outside of 0 < speed <= 1.
    """
    if not (np.isfinite(value) and 0.0 < value <= 1.0):
        raise PlanningError(f"the speed must lie in 0 to 1. Got: {value!r}", mend="e.g. 0.5; pause() rests")
    return float(value)


def require_arm(problem: Problem, plan: Plan) -> None:
    """Refuse a plan of another arm, and one whose file claims what is not so of this arm.

    Raises:
        PlanningError: the plan moves another arm, has other joints, or is not sound (`palpate.planning.sound`).
    """
    if plan.arm != problem.robot.name or len(plan.joint_names) != problem.robot.arm.n:
        raise PlanningError(f"the plan moves {plan.arm}, not {problem.robot.name}", mend="plan for this arm")
    if plan.from_file:
        require_sound(problem, plan)


def require_start(plan: Plan, q_now: Array) -> None:
    """Refuse a plan that begins elsewhere than at the joints q_now (n,) [rad, m].

    Raises:
        PlanningError: a joint is more than 2 mrad or 2 mm away; the message names it.
    """
    start = plan.trajectory.at(np.zeros(1))[0][0]
    if q_now.shape != start.shape:
        raise PlanningError(f"the arm has {q_now.size} joints, the plan {start.size}", mend="plan for this arm")
    away = np.abs(q_now - start)
    if not away.max() <= _NEAR:  # also true of values that are not finite
        joint = int(np.argmax(np.where(np.isfinite(away), away, np.inf)))
        name = plan.joint_names[joint]
        raise PlanningError(
            f"the arm is {away[joint]:.3g} rad or m from the start of the plan: {name} is at {q_now[joint]:.4f}, "
            f"the plan begins at {start[joint]:.4f}",
            mend="move the arm there, or plan from joints:" + ",".join(f"{q:.4f}" for q in q_now),
        )
