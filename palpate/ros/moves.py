"""The moves of a CRTK arm: one goal at a time, which the arm approaches by an interpolation of its own."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.ros import topic
from palpate.ros.crtk_arm import FIND, CrtkArm

if TYPE_CHECKING:
    from rclpy.node import Node

_ANSWER = 0.3  # time in which an arm reports a new ratio of its speed [s]


class Moves:
    """Sends goals to move_jp, and follows what the arm reports of them.

    An arm has reached its goal when it says so on goal_reached, or was busy (operating_state) and is no longer.

    Args:
        here: a node, which its owner spins.
        arm: the arm, whose goals go to move_jp.
    """

    def __init__(self, here: Node, arm: CrtkArm) -> None:
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from std_msgs.msg import Bool, Empty, Float64

        self._here, self._arm = here, arm
        self.reached: bool | None = None  #: the arm's answer to the newest goal
        self._was_busy = False
        self._ratios: dict[str, float] = {}
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        here.create_subscription(Bool, f"/{arm.name}/goal_reached", self._answered, 10)
        for key in ("v", "a"):
            here.create_subscription(
                Float64, f"/{arm.name}/trajectory_j/ratio_{key}", lambda m, key=key: self._note(key, m), latched
            )
        self._hold = here.create_publisher(Empty, f"/{arm.name}/hold", 1)
        self._speeds = {
            key: here.create_publisher(Float64, f"/{arm.name}/trajectory_j/set_ratio_{key}", 1) for key in ("v", "a")
        }
        self._before: dict[str, float] = {}

    def find(self) -> None:
        """Wait until the arm listens to hold and to the ratio of its speed.

        Raises:
            PalpateError: it does not.
        """
        end = time.monotonic() + FIND
        ends = {"hold": self._hold, **{f"trajectory_j/set_ratio_{key}": one for key, one in self._speeds.items()}}
        while missing := [name for name, one in ends.items() if not one.get_subscription_count()]:
            if time.monotonic() > end:
                raise PalpateError(
                    f"nobody listens to /{self._arm.name}/{missing[0]}", mend="--by servo_jp needs no moves of the arm"
                )
            topic.spin(self._here, 0.02)
        self._before = {key: self._ratios.get(key, 1.0) for key in self._speeds}

    def send(self, q: Array) -> None:
        """Send a goal (n,) [rad, m]."""
        self.reached, self._was_busy = None, False
        self._arm.send(q)

    def hold(self) -> None:
        """End the move: the arm stays at its present set point."""
        from std_msgs.msg import Empty

        self._hold.publish(Empty())

    @property
    def ended(self) -> bool:
        """True if the newest goal was reached or given up, as far as the arm says."""
        self._was_busy = self._was_busy or self._arm.is_busy
        return not self._arm.is_busy and (self._was_busy or self.reached is not None)

    def set_speed(self, ratio: float) -> None:
        """Set the ratio of the arm's own speed and acceleration, 0 to 1; waits until the arm reports it."""
        self._set(dict.fromkeys(self._speeds, ratio))

    def restore_speed(self) -> None:
        """Set the ratios that the arm had before; 1 if it had not reported any."""
        self._set(self._before)

    def _set(self, ratios: dict[str, float]) -> None:
        from std_msgs.msg import Float64

        for key, ratio in ratios.items():
            self._speeds[key].publish(Float64(data=ratio))
        end = time.monotonic() + _ANSWER
        while self._ratios != ratios and time.monotonic() < end:
            topic.spin(self._here, 0.005)

    def _note(self, key: str, message: Any) -> None:
        self._ratios[key] = message.data

    def _answered(self, message: Any) -> None:
        self.reached = bool(message.data)
