"""Executes a motion plan on an arm over ROS 2 by CRTK's servo_jp. The law is `palpate.planning.Execution`."""

from __future__ import annotations

import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.arrays import Array
from palpate.errors import PalpateError, PlanningError
from palpate.planning.execute import Execution, Phase
from palpate.ros import topic
from palpate.ros.crtk_arm import CrtkArm

if TYPE_CHECKING:
    from palpate.planning.problem import Problem
    from palpate.planning.result import Plan

SLOWEST, FASTEST = 20.0, 500.0
"""Range of the rate of the goals [Hz]."""
_USUAL = 200.0  # highest rate of the goals that is chosen without being asked for [Hz]
_SILENT = 0.25  # time without a measurement, after which an arm is silent [s]
_LONGEST = 0.02  # longest step along the plan, however late this process is [s]
_WINDOW = 0.25  # time for which a goal counts as the path behind which the arm follows [s]
_TIGHT = 1e-3  # tolerance of the path for plans with a smaller clearance [m]
_ARRIVED = 2e-3  # distance from the goal within which the arm has arrived [rad, m]
_SETTLE = 1.0  # time to arrive after the last goal [s]


@dataclass
class Moved:
    """What came of a motion."""

    arm: str
    success: bool = False
    phase: str = ""
    """done, stopped or aborted"""
    reason: str = ""
    duration_s: float = 0.0  # of the plan
    along_s: float = 0.0  # time along the plan at the end
    time_s: float = 0.0  # from the first goal to the last
    stop_s: float | None = None  # from the request to stop, to the last goal
    rate_hz: float = 0.0
    goals: int = 0
    path_error_m: float = 0.0  # largest distance from the path, in motion of the tip
    end: Array | None = None  # (n,) measured joint positions at the end [rad, m]


class Mover:
    """One motion of one arm.

    Args:
        here: a node, whose ~/pause, ~/resume, ~/stop (std_msgs/Empty) and ~/speed (std_msgs/Float64) change the motion.
        arm: the arm.
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
        self._here, self._arm, self._plan, self._on_change = here, CrtkArm(here, arm), plan, on_change
        self._arm.find()
        self._require_ready()
        self._rate = float(np.clip(self._arm.rate(), SLOWEST, _USUAL)) if rate is None else rate
        self._require_ready()
        self.execution = Execution(problem, plan, self._arm.q, speed)
        self._tolerance = max(plan.clearance_asked, _TIGHT)
        self._recent: deque[Array] = deque(maxlen=max(1, round(_WINDOW * self._rate)))
        self._quiet, self._seen, self._stopped_at = 0.0, self._arm.received, 0.0
        self.moved = Moved(arm, duration_s=plan.duration_s, rate_hz=self._rate)
        self._listen()

    def stop(self) -> None:
        """Come to rest within 50 ms for good."""
        self._stopped_at = self._stopped_at or time.monotonic()
        self.execution.stop()

    def run(self) -> Moved:
        """Move until the arm has arrived, or the motion was stopped or aborted."""
        execution, moved, phase = self.execution, self.moved, Phase.MOVING
        begin = last = due = time.monotonic()
        while not execution.over and not self._barred():
            now = time.monotonic()
            dt, last = min(now - last, _LONGEST), now
            self._watch(dt)
            goal = execution.step(dt)
            self._arm.servo_jp(goal)
            self._recent.append(goal)
            moved.goals += 1
            if execution.phase is not phase:
                phase = execution.phase
                self._on_change(" ".join([phase.value, execution.reason]).strip())
            due = max(due + 1.0 / self._rate, now)  # a late goal is not followed by a burst
            self._spin_until(due)
        moved.time_s = last - begin
        moved.stop_s = last - self._stopped_at if self._stopped_at else None
        return self._ended()

    def _ended(self) -> Moved:
        moved, execution = self.moved, self.execution
        moved.phase, moved.reason, moved.along_s = execution.phase.value, execution.reason, execution.time
        if execution.phase is Phase.DONE:
            moved.reason = self._settled()
            moved.success = not moved.reason
        moved.end = self._arm.q
        return moved

    def _settled(self) -> str:
        """Wait until the arm is at its goal; why it is not, in words."""
        goal, end = self._recent[-1], time.monotonic() + _SETTLE
        while (away := np.abs(self._q - goal)).max() > _ARRIVED and time.monotonic() < end:
            topic.spin(self._here, 0.01)
        joint = int(np.argmax(away))
        if away[joint] <= _ARRIVED:
            return ""
        return f"{self._arm.name} did not arrive: {self._plan.joint_names[joint]} is {away[joint]:.3g} rad or m away"

    def _barred(self) -> bool:
        """True if the arm takes no goals any more; none is sent then, not even to slow down."""
        refusal = self._arm.refusal()
        if refusal:
            self.execution.abort(refusal)
        return bool(refusal)

    def _watch(self, dt: float) -> None:
        """Abort if the arm is silent or has left the path; `dt` [s] does not grow when this process is late."""
        fresh, self._seen = self._arm.received > self._seen, self._arm.received
        self._quiet = 0.0 if fresh else self._quiet + dt
        if self._quiet > _SILENT:
            self.execution.abort(f"{self._arm.name} is silent: no measured_js for {1e3 * self._quiet:.0f} ms")
        if not fresh or not self._recent:
            return
        away = np.abs(np.array(self._recent) - self._q) * self._plan.scale
        nearest = away[int(np.argmin(away.sum(axis=1)))]
        error = float(nearest.sum())
        self.moved.path_error_m = max(self.moved.path_error_m, error)
        if not error <= self._tolerance:
            name = self._plan.joint_names[int(np.argmax(nearest))]
            self.execution.abort(
                f"{self._arm.name} left the path by {1e3 * error:.1f} mm, mostly by {name}; "
                f"{1e3 * self._tolerance:g} mm are allowed"
            )

    @property
    def _q(self) -> Array:
        assert self._arm.q is not None
        return self._arm.q

    def _require_ready(self) -> None:
        refusal = self._arm.refusal(starting=True)
        if refusal:
            raise PalpateError(f"the plan was not begun: {refusal}", mend="enable and home the arm, and let it rest")

    def _spin_until(self, due: float) -> None:
        topic.spin(self._here, 0.0)
        while (left := due - time.monotonic()) > 0.0 and not self._arm.refusal():
            topic.spin(self._here, left)

    def _listen(self) -> None:
        from std_msgs.msg import Empty, Float64

        here, execution = self._here, self.execution
        here.create_subscription(Empty, "~/pause", lambda _: execution.pause(), 10)
        here.create_subscription(Empty, "~/resume", lambda _: execution.resume(), 10)
        here.create_subscription(Empty, "~/stop", lambda _: self.stop(), 10)
        here.create_subscription(Float64, "~/speed", self._set_speed, 10)

    def _set_speed(self, message: Any) -> None:
        try:
            self.execution.speed = message.data
        except PlanningError as error:
            self._on_change(error.what)


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
