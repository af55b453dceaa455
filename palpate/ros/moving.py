"""What all motions of an arm over ROS 2 share: readiness, orders by topics, silence of the arm, and the result."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError, PlanningError
from palpate.planning.ahead import require_start
from palpate.planning.orders import Orders, Phase
from palpate.ros import topic
from palpate.ros.crtk_arm import CrtkArm
from palpate.ros.same_arm import SameArm, require_name

if TYPE_CHECKING:
    from palpate.planning.problem import Problem
    from palpate.planning.result import Plan

_SILENT = 0.25  # time without a measurement, after which an arm is silent [s]
_TIGHT = 1e-3  # tolerance of the path for plans with a smaller clearance [m]
ARRIVED = 2e-3
"""Distance from the goal within which the arm has arrived [rad, m]."""
_SETTLE = 1.0  # time to arrive after the last goal [s]


@dataclass
class Moved:
    """What came of a motion."""

    arm: str
    by: str = "servo_jp"
    """servo_jp or move_jp"""
    success: bool = False
    phase: str = ""
    """done, stopped or aborted"""
    reason: str = ""
    duration_s: float = 0.0  # of the plan
    along_s: float = 0.0  # time along the plan at the end
    time_s: float = 0.0  # from the first goal to the last
    stop_s: float | None = None  # from the request to stop, to the last goal or to hold
    rate_hz: float | None = None
    goals: int = 0
    path_error_m: float = 0.0  # largest distance from the path, in motion of the tip
    end: Array | None = None  # (n,) measured joint positions at the end [rad, m]


class Moving(ABC):
    """One motion of one arm.

    Args:
        here: a node, whose ~/pause, ~/resume, ~/stop (std_msgs/Empty) and ~/speed (std_msgs/Float64) change the motion.
        arm: the arm.
        problem: the problem in its present world.
        plan: the plan.
        on_change: called with each change of the phase, in words.

    Raises:
        PlanningError: the arm is not the plan's. PalpateError: the arm is silent, disabled, not homed or busy. Nothing
            was sent then.
    """

    orders: Orders

    def __init__(self, here: Any, arm: CrtkArm, problem: Problem, plan: Plan, on_change: Callable[[str], None]) -> None:
        self._here, self._arm, self._plan, self._on_change = here, arm, plan, on_change
        require_name(plan, arm.name)
        same = SameArm(here, arm)
        arm.find()
        self._require_ready()
        require_start(plan, self._q)
        note = same.require(problem, plan)
        if note:
            on_change(note)
        self._tolerance = max(plan.clearance_asked, _TIGHT)
        self._quiet, self._seen, self._stopped_at = 0.0, arm.received, 0.0
        self._phase = Phase.MOVING
        self.moved = Moved(arm.name, duration_s=plan.duration_s)

    def stop(self) -> None:
        """Come to rest for good."""
        self._stopped_at = self._stopped_at or time.monotonic()
        self.orders.stop()

    @property
    @abstractmethod
    def expectation(self) -> str:
        """What is about to happen, in words."""

    @abstractmethod
    def run(self) -> Moved:
        """Move until the arm has arrived, or the motion was stopped or aborted."""

    def _ended(self, along: float) -> Moved:
        """The result; a motion that is done must arrive at the plan's goal. along: time along the plan [s]."""
        moved = self.moved
        moved.phase, moved.reason, moved.along_s = self.orders.phase.value, self.orders.reason, along
        if self.orders.phase is Phase.DONE:
            moved.reason = self._settled(self._plan.curves[-1].controls[-1])
            moved.success = not moved.reason
        moved.end = self._arm.q
        return moved

    def _settled(self, goal: Array) -> str:
        """Wait until the arm is at its goal; why it is not, in words."""
        end = time.monotonic() + _SETTLE
        while (away := np.abs(self._q - goal)).max() > ARRIVED and time.monotonic() < end:
            topic.spin(self._here, 0.01)
        joint = int(np.argmax(away))
        if away[joint] <= ARRIVED:
            return ""
        return f"{self._arm.name} did not arrive: {self._plan.joint_names[joint]} is {away[joint]:.3g} rad or m away"

    def _barred(self) -> bool:
        """True if the arm takes no goals any more; none is sent then, not even to slow down."""
        refusal = self._arm.refusal()
        if refusal:
            self.orders.abort(refusal)
        return bool(refusal)

    def _fresh(self, dt: float) -> bool:
        """True if there is a new measurement; aborts if the arm is silent. dt [s] does not grow in a late process."""
        fresh, self._seen = self._arm.received > self._seen, self._arm.received
        self._quiet = 0.0 if fresh else self._quiet + dt
        if self._quiet > _SILENT:
            self.orders.abort(f"{self._arm.name} is silent: no measured_js for {1e3 * self._quiet:.0f} ms")
        return fresh

    def _require_on_path(self, away: Array) -> None:
        """Abort if the arm is farther from the path than the clearance; away (n,): as motion of the tip [m]."""
        error = float(away.sum())
        if not error <= self._tolerance:
            name = self._plan.joint_names[int(np.argmax(away))]
            self.orders.abort(
                f"{self._arm.name} left the path by {1e3 * error:.1f} mm, mostly by {name}; "
                f"{1e3 * self._tolerance:g} mm are allowed"
            )

    def _report(self) -> None:
        """Call back if the phase has changed."""
        if self.orders.phase is not self._phase:
            self._phase = self.orders.phase
            self._on_change(" ".join([self._phase.value, self.orders.reason]).strip())

    @property
    def _q(self) -> Array:
        assert self._arm.q is not None
        return self._arm.q

    def _require_ready(self) -> None:
        refusal = self._arm.refusal(starting=True)
        if refusal:
            raise PalpateError(f"the plan was not begun: {refusal}", mend="enable and home the arm, and let it rest")

    def _listen(self) -> None:
        from std_msgs.msg import Empty, Float64

        here, orders = self._here, self.orders
        here.create_subscription(Empty, "~/pause", lambda _: orders.pause(), 10)
        here.create_subscription(Empty, "~/resume", lambda _: orders.resume(), 10)
        here.create_subscription(Empty, "~/stop", lambda _: self.stop(), 10)
        here.create_subscription(Float64, "~/speed", self._set_speed, 10)

    def _set_speed(self, message: Any) -> None:
        try:
            self.orders.speed = message.data
        except PlanningError as error:
            self._on_change(error.what)
