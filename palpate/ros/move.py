"""Executes a motion plan on an arm over ROS 2 by CRTK's servo_jp. The law is `palpate.planning.Execution`."""

from __future__ import annotations

import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.planning.execute import Execution
from palpate.ros import topic
from palpate.ros.crtk_arm import CrtkArm
from palpate.ros.moving import Moved, Moving

if TYPE_CHECKING:
    from palpate.planning.problem import Problem
    from palpate.planning.result import Plan

SLOWEST, FASTEST = 20.0, 500.0
"""Range of the rate of the goals [Hz]."""
_USUAL = 200.0  # highest rate of the goals that is chosen without being asked for [Hz]
_LONGEST = 0.02  # longest step along the plan, however late this process is [s]
_WINDOW = 0.25  # time for which a goal counts as the path behind which the arm follows [s]


class Mover(Moving):
    """One motion of one arm by a stream of goals.

    Args:
        here: a node, whose ~/pause, ~/resume, ~/stop (std_msgs/Empty) and ~/speed (std_msgs/Float64) change the motion.
        arm: name of the arm.
        problem: the problem in its present world.
        plan: the plan.
        speed: pace, 0 < speed <= 1.
        rate: rate of the goals [Hz]; that of the arm's measurements, but no more than 200, when left out.
        on_change: called with each change of the phase, in words.

    Raises:
        PlanningError: the plan is stale, for another arm, or begins elsewhere. PalpateError: the arm is silent,
            disabled, not homed or busy. Nothing was sent then.
    """

    def __init__(
        self, here: Any, arm: str, problem: Problem, plan: Plan, speed: float = 1.0, rate: float | None = None,
        on_change: Callable[[str], None] = lambda _: None,
    ) -> None:  # fmt: skip
        if rate is not None and not SLOWEST <= rate <= FASTEST:
            raise PalpateError(f"--rate {rate:g}: must be {SLOWEST:g} to {FASTEST:g} Hz", mend="e.g. --rate 200")
        Execution(problem, plan, speed=speed)  # refuses stale plans before the network is asked
        super().__init__(here, CrtkArm(here, arm), problem, plan, on_change)
        self._rate = float(np.clip(self._arm.rate(), SLOWEST, _USUAL)) if rate is None else rate
        self._require_ready()
        self.execution = self.orders = Execution(problem, plan, self._arm.q, speed)
        self._recent: deque[Array] = deque(maxlen=max(1, round(_WINDOW * self._rate)))
        self.moved.rate_hz = self._rate
        self._listen()

    @property
    def expectation(self) -> str:
        """The time that the motion takes."""
        return f"for {self._plan.duration_s / self.execution.speed:.1f} s"

    def run(self) -> Moved:
        """Move until the arm has arrived, or the motion was stopped or aborted."""
        execution, moved = self.execution, self.moved
        begin = last = due = time.monotonic()
        while not execution.over and not self._barred():
            now = time.monotonic()
            dt, last = min(now - last, _LONGEST), now
            self._watch(dt)
            goal = execution.step(dt)
            self._arm.send(goal)
            self._recent.append(goal)
            moved.goals += 1
            self._report()
            due = max(due + 1.0 / self._rate, now)  # a late goal is not followed by a burst
            self._spin_until(due)
        moved.time_s = last - begin
        moved.stop_s = last - self._stopped_at if self._stopped_at else None
        return self._ended(execution.time)

    def _watch(self, dt: float) -> None:
        """Abort if the arm is silent or has left the path."""
        if not self._fresh(dt) or not self._recent:
            return
        away = np.abs(np.array(self._recent) - self._q) * self._plan.scale
        nearest = away[int(np.argmin(away.sum(axis=1)))]
        self.moved.path_error_m = max(self.moved.path_error_m, float(nearest.sum()))
        self._require_on_path(nearest)

    def _spin_until(self, due: float) -> None:
        topic.spin(self._here, 0.0)
        while (left := due - time.monotonic()) > 0.0 and not self._arm.refusal():
            topic.spin(self._here, left)


@contextmanager
def interrupted(call: Callable[[], None]) -> Iterator[list[int]]:
    """While open, Ctrl-C and termination call a function and do not end the process; yields the signals that came."""
    came: list[int] = []

    def take(number: int, _: Any) -> None:
        came.append(number)
        call()

    kinds = (signal.SIGINT, signal.SIGTERM) if threading.current_thread() is threading.main_thread() else ()
    before = {kind: signal.signal(kind, take) for kind in kinds}
    try:
        yield came
    finally:
        for kind, handler in before.items():
            signal.signal(kind, handler)
