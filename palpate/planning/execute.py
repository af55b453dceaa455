"""Executes a plan as a stream of joint goals: speed override, pause, stop, and abort when the scene comes too near.

    execution = Execution(problem, plan, speed=0.5)
    while not execution.over:
        follower.servo_jp(execution.step(0.001))       # CRTK; simulated, or over ROS 2

The goals never jump: the execution moves along the plan's own path, only its pace changes, and within STOP_TIME.
Whoever takes over afterwards, such as a teleoperation that aligns itself, finds the arm at rest at the last goal.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import PlanningError
from palpate.planning.ahead import Ahead, require_arm, require_start
from palpate.planning.orders import Orders, Phase
from palpate.planning.problem import Problem
from palpate.planning.result import Plan
from palpate.planning.world import World

STOP_TIME = _core.STOP_TIME  # time in which the goals come to rest, as in a session [s]


class Execution(Orders):
    """One run of a plan.

    Args:
        problem: the problem in its present world.
        plan: the plan to execute.
        q_now: measured joints (n,) of the arm [rad, m]; the plan's start when left out.
        speed: pace, 1: as planned; 0 < speed <= 1.
        world: returns the present world; it is asked at every step, and must be quick.

    Raises:
        PlanningError: the plan has no motion, belongs to another arm or to a scene in which it is no longer free, or
            the arm is not at its start.
    """

    def __init__(
        self,
        problem: Problem,
        plan: Plan,
        q_now: Array | None = None,
        speed: float = 1.0,
        world: Callable[[], World] | None = None,
    ) -> None:
        super().__init__(speed)
        require_arm(problem, plan)
        self._trajectory = plan.trajectory
        self.plan, self._problem, self._world = plan, problem, world or (lambda: problem.world)
        self.time = 0.0  #: time along the plan [s]
        self._pace = _core.Pace(STOP_TIME)
        if q_now is not None:
            require_start(plan, np.asarray(q_now))
        self._ahead = Ahead(problem.robot, plan)
        if not self._is_free(self._world()):
            changed = plan.world_version != self._world().version
            what = "the scene has changed and the plan is not free in it" if changed else "the plan is not free"
            raise PlanningError(what, why=self.reason, mend="plan again")

    @property
    def over(self) -> bool:
        """True when the arm rests and the execution will not move it any more."""
        return self.phase is Phase.DONE or (self.phase in (Phase.STOPPED, Phase.ABORTED) and self._pace.value == 0.0)

    def step(self, dt: float) -> Array:
        """The next goal of the joints (n,) [rad, m], `dt` [s] after the one before."""
        world = self._world()
        if self.phase is Phase.MOVING and not self._is_free(world):
            self.phase = Phase.ABORTED
        wanted = self._speed if self.phase is Phase.MOVING else 0.0
        self.time = min(self.time + self._pace.step(wanted, dt), self._trajectory.duration)
        if self.phase is Phase.MOVING and self.time >= self._trajectory.duration:
            self.phase = Phase.DONE
            self._pace.reset()
        return np.asarray(self._trajectory.at(np.array([self.time]))[0][0])

    def _is_free(self, world: World) -> bool:
        """True if the rest of the plan is proved free in a world."""
        self.reason = self._ahead.prove(world, self.time, self._trajectory.duration)
        return not self.reason
