"""An arm as CRTK shows it: measured joints and operating state; takes joint goals by servo_jp, or by move_jp."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.ros import topic

if TYPE_CHECKING:
    from rclpy.node import Node

FIND = 3.0
"""Time in which the arm's topics must be found and speak [s]."""
_COUNTED = 40  # measurements after which their rate is known to 3 %


def refusal(name: str, state: Any, starting: bool = False) -> str:
    """Why the arm of this name and operating state (None: unknown) may not be moved, in words; empty if it may.

    starting: a motion that another program began is a reason too.
    """
    if state is None or state.state != "ENABLED":
        return f"{name} is {state.state if state is not None and state.state else 'without state'}, not ENABLED"
    if not state.is_homed:
        return f"{name} is not homed"
    return f"{name} is busy with another motion" if starting and state.is_busy else ""


class CrtkArm:
    """The joint topics of one arm, on a node that its owner spins.

    Args:
        here: a node.
        name: name of the arm on the network, such as PSM1.
        verb: servo_jp or move_jp, by which it takes goals.
    """

    def __init__(self, here: Node, name: str, verb: str = "servo_jp") -> None:
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import JointState

        self.name, self._here, self._verb = name, here, verb
        self.q: Array | None = None  #: newest valid joint positions (n,) [rad, m]
        self.joint_names: tuple[str, ...] = ()  #: names of the joints as the arm reports them; may be empty
        self.received = 0  #: number of valid joint positions so far
        self._state: Any = None
        self._message = JointState()
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        here.create_subscription(JointState, f"/{name}/measured_js", self._measured, 1)
        kind = topic.message_type("crtk_msgs/OperatingState")
        here.create_subscription(kind, f"/{name}/operating_state", self._keep_state, latched)
        self._goals = here.create_publisher(JointState, f"/{name}/{verb}", 1)

    def find(self) -> None:
        """Wait until the arm speaks and takes goals.

        Raises:
            PalpateError: it does not within `FIND`; the message names the topic.
        """
        end = time.monotonic() + FIND
        while (missing := self._missing()) and time.monotonic() < end:
            topic.spin(self._here, 0.02)
        if missing:
            raise PalpateError(f"{self.name} is silent: {missing}", mend="check the name with `palpate ros topic list`")

    def rate(self, seconds: float = 0.4) -> float:
        """Rate at which the arm measures its joints [Hz], counted for `seconds`, or until it is known to 3 %."""
        begin, before = time.monotonic(), self.received
        while time.monotonic() < begin + seconds and self.received - before < _COUNTED:
            topic.spin(self._here, 0.02)
        return (self.received - before) / (time.monotonic() - begin)

    def refusal(self, starting: bool = False) -> str:
        """Why the arm may not be moved, in words; empty if it may.

        starting: a motion that another program began is a reason too.
        """
        return refusal(self.name, self._state, starting)

    @property
    def is_busy(self) -> bool:
        """True while the arm executes a move."""
        return self._state is not None and bool(self._state.is_busy)

    def send(self, q: Array) -> None:
        """Send a goal (n,) [rad, m]."""
        self._message.header.stamp = self._here.get_clock().now().to_msg()
        self._message.position = np.asarray(q, dtype=float).tolist()
        self._goals.publish(self._message)

    def _missing(self) -> str:
        if self._state is None:
            return f"nothing on /{self.name}/operating_state"
        if self.refusal():  # an arm without power measures nothing
            return ""
        if self.q is None:
            return f"nothing valid on /{self.name}/measured_js"
        return "" if self._goals.get_subscription_count() else f"nobody listens to /{self.name}/{self._verb}"

    def _measured(self, message: Any) -> None:
        stamp = message.header.stamp
        if stamp.sec or stamp.nanosec:  # a zero stamp marks invalid values
            self.q, self.joint_names = np.array(message.position, dtype=float), tuple(message.name)
            self.received += 1

    def _keep_state(self, message: Any) -> None:
        self._state = message
