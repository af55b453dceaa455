"""Executes a motion plan on an arm over ROS 2 by CRTK's move_jp: way points, between which the arm moves by itself."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PlanningError
from palpate.planning.checker import Checker
from palpate.planning.execute import Execution
from palpate.planning.orders import Orders, Phase
from palpate.planning.waypoints import SPREAD, blocked, waypoints
from palpate.ros import topic
from palpate.ros.crtk_arm import CrtkArm
from palpate.ros.moves import Moves
from palpate.ros.moving import ARRIVED, Moved, Moving

if TYPE_CHECKING:
    from palpate.planning.problem import Problem
    from palpate.planning.result import Plan
    from palpate.planning.world import World

_PERIOD = 0.005  # longest time between two looks at the orders [s]
_STILL = 1.0  # time without motion, after which an arm that is not at its goal has given it up [s]
_MOVED = 1e-4  # change of a joint that counts as motion [rad, m]
_REST = 0.05  # time without motion, after which an arm that holds is at rest [s]


class GoalMover(Moving):
    """One motion of one arm by way points, each sent when the arm has reached the one before.

    Before a way point is sent, and whenever the world changes on the way to it, the leg is proved free in the newest
    world, however the arm interpolates (`palpate.planning.waypoints`). Pause and stop send `hold`: the arm ends its
    move at its present set point. It goes on from there, if that leg is proved free.

    Args:
        here: a node, whose ~/pause, ~/resume, ~/stop (std_msgs/Empty) and ~/speed (std_msgs/Float64) change the motion.
        arm: name of the arm.
        problem: the problem in its present world.
        plan: the plan.
        clearance: clearance that the arm keeps between way points [m], no more than the plan's; the plan's when left
            out.
        speed: ratio of the arm's own speed and acceleration, 0 < speed <= 1; a change acts from the next way point on.
        on_change: called with each change of the phase, in words.
        world: returns the present world; that of the problem when left out.

    Raises:
        PlanningError: the plan is stale, for another arm, begins elsewhere, or has a part that is too near to something
            for the arm's own interpolation. PalpateError: the arm is silent, disabled, not homed or busy, or takes no
            moves. Nothing was sent then.
    """

    def __init__(
        self, here: Any, arm: str, problem: Problem, plan: Plan, speed: float = 1.0,
        on_change: Callable[[str], None] = lambda _: None, clearance: float | None = None,
        world: Callable[[], World] | None = None,
    ) -> None:  # fmt: skip
        self._world = world or (lambda: problem.world)
        Execution(problem, plan, speed=speed, world=self._world)  # refuses stale plans before the network is asked
        self.orders = Orders(speed)
        self._checker = Checker(problem.robot, self._world())
        self._clearance = _require_clearance(plan, clearance)
        self._rows = waypoints(self._checker, plan, self._clearance)
        super().__init__(here, CrtkArm(here, arm, "move_jp"), problem, plan, on_change)
        self._moves = Moves(here, self._arm)
        self._moves.find()
        self._require_ready()
        self._ratio = 0.0
        self.moved.by = "move_jp"
        self._listen()

    @property
    def expectation(self) -> str:
        """The number of way points."""
        return f"to {len(self._rows) - 1} way points"

    def run(self) -> Moved:
        """Move until the arm has arrived, or the motion was stopped or aborted."""
        begin, here = time.monotonic(), self._q
        try:
            for k, goal in enumerate(self._rows[1:], 1):
                if not self._reach(here, goal, f"way point {k} of {len(self._rows) - 1}"):
                    break
                here = goal
            else:
                self.orders.phase = Phase.DONE
        finally:
            self._moves.restore_speed()
        self._report()
        self.moved.time_s = time.monotonic() - begin
        away = (np.abs(self._plan.joints - self._q) * self._plan.scale).sum(axis=1)
        return self._ended(float(self._plan.t[int(np.argmin(away))]))

    def _reach(self, here: Array, goal: Array, name: str) -> bool:
        """Move from here to a way point (n,), with pauses; False if the motion ends before it."""
        while self._is_free(here, goal):
            if self.orders.speed != self._ratio:
                self._ratio = self.orders.speed
                self._moves.set_speed(self._ratio)
            self._moves.send(goal)
            self.moved.goals += 1
            if self._travel(here, goal, name):
                return True
            if not self._resumed():
                return False
            here = self._q
        return False

    def _is_free(self, here: Array, goal: Array) -> bool:
        """True if the leg from here to a way point (n,) is proved free in the newest world; aborts otherwise."""
        world = self._world()
        if world.version != self._checker.world.version:
            self._checker = Checker(self._checker.robot, world)
        found = blocked(self._checker, here, goal, self._clearance)
        if found is not None:
            self.orders.abort(f"{' and '.join(found.pair)} may come nearer than {1e3 * self._clearance:g} mm ahead")
        return found is None

    def _travel(self, here: Array, goal: Array, name: str) -> bool:
        """Wait for the arm at a way point (n,); at an order, an abort or a wrong answer the move ends with hold."""
        last, before = time.monotonic(), self._q
        moved_at = last
        while not self._barred():
            topic.spin(self._here, _PERIOD)
            now = time.monotonic()
            if self._fresh(now - last):
                self._watch(here, goal)
            last = now
            if np.abs(self._q - before).max() > _MOVED:
                before, moved_at = self._q, now
            if self._world().version != self._checker.world.version:
                self._is_free(here, goal)
            if self.orders.phase is Phase.MOVING and self._arrived(goal, now - moved_at, name):
                return True
            if self.orders.phase is not Phase.MOVING:
                self._moves.hold()
                self.moved.stop_s = now - self._stopped_at if self._stopped_at else None
                break
        self._report()
        return False

    def _arrived(self, goal: Array, still: float, name: str) -> bool:
        """True at a way point (n,); aborts if the arm stands still elsewhere for too long. still: [s]."""
        if self._moves.ended and np.abs(self._q - goal).max() < ARRIVED:
            return True
        if still > _STILL:
            gave_up = self._moves.reached is False
            self.orders.abort(f"{self._arm.name} {'gave up' if gave_up else 'does not move to'} {name}")
        return False

    def _resumed(self) -> bool:
        """Wait for the arm to rest, and for the end of a pause; True if the motion goes on."""
        before, since = self._q, time.monotonic()
        while not self._barred() and self.orders.phase is not Phase.ABORTED:
            topic.spin(self._here, _PERIOD)
            if np.abs(self._q - before).max() > _MOVED:
                before, since = self._q, time.monotonic()
            if time.monotonic() - since > _REST and self.orders.phase is not Phase.PAUSED:
                break
        self._report()
        return self.orders.phase is Phase.MOVING

    def _watch(self, here: Array, goal: Array) -> None:
        """Abort if the arm has left the leg, beyond what its own interpolation explains."""
        scale, way = self._plan.scale, goal - here
        square = float((scale * way) @ (scale * way))
        along = np.clip((scale * (self._q - here)) @ (scale * way) / square, 0.0, 1.0) if square > 0.0 else 0.0
        away = np.abs(self._q - here - along * way)
        self.moved.path_error_m = max(self.moved.path_error_m, float((away * scale).sum()))
        self._require_on_path(np.maximum(away - SPREAD * np.abs(way), 0.0) * scale)


def _require_clearance(plan: Plan, clearance: float | None) -> float:
    most = plan.clearance_asked
    if clearance is not None and not 0.0 <= clearance <= most:
        raise PlanningError(
            f"--clearance must lie in 0 to {1e3 * most:g} mm, that of the plan. Got: {1e3 * clearance:g} mm",
            mend=f"e.g. --clearance {900 * most:.2g}mm",
        )
    return most if clearance is None else clearance
