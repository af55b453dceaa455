"""What a device sends as a CRTK master: pose, set point, velocity, gripper, buttons and operating state."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import numpy as np

from palpate.base.arrays import Array, so3
from palpate.devices.buttons import OWN
from palpate.devices.driver import Reading
from palpate.ros import topic

_WINDOW = 0.01  # time over which the velocity is measured, where the driver has none [s]


class DeviceTopics:
    """The publishers of one device. A device without position control is where it shall be: setpoint_cp is measured_cp.

    Args:
        node: its node.
        name: name of the arm on the network, such as MTMR.
        own: names of the topics of the device's own buttons.
    """

    def __init__(self, node: Any, name: str, own: tuple[str, ...]) -> None:
        from geometry_msgs.msg import PoseStamped, TwistStamped
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import JointState, Joy

        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._node, make = node, node.create_publisher
        self._made_state = topic.message_type("crtk_msgs/OperatingState")
        self._cp, self._setpoint = (make(PoseStamped, f"/{name}/{cp}", 10) for cp in ("measured_cp", "setpoint_cp"))
        self._cv = make(TwistStamped, f"/{name}/measured_cv", 10)
        self._grip = make(JointState, f"/{name}/gripper/measured_js", 10)
        self._buttons = make(Joy, f"/{name}/buttons", latched)
        self._own = [make(Joy, f"/{name}/{button}", latched) for button in own]
        self._operating = make(self._made_state, f"/{name}/operating_state", latched)
        self._pose, self._twist, self._jaw, self._joy = PoseStamped(), TwistStamped(), JointState(), Joy()
        self._pose.header.frame_id = self._twist.header.frame_id = f"{name}_base"
        self._jaw.name = ["gripper"]
        self._recent: deque[tuple[float, Array]] = deque()  # poses with their times [s]
        self._pressed = -1
        self.state = "DISABLED"  #: the newest operating state

    def publish(self, reading: Reading, X: Array, now: float) -> None:
        """Publish a measured pose X, finite, with velocity, gripper and changed buttons; `now`: its time [s]."""
        stamp = self._node.get_clock().now().to_msg()
        p, q = self._pose.pose.position, self._pose.pose.orientation
        p.x, p.y, p.z = X[:3, 3].tolist()
        q.w, q.x, q.y, q.z = so3.quaternion(X[:3, :3])
        V = self._velocity(X, now) if reading.V is None else np.asarray(reading.V, dtype=np.float64)
        v, w = self._twist.twist.linear, self._twist.twist.angular
        v.x, v.y, v.z, w.x, w.y, w.z = V.tolist()
        self._jaw.position = [float(reading.gripper)]
        sent = ((self._pose, self._cp), (self._pose, self._setpoint), (self._twist, self._cv), (self._jaw, self._grip))
        for message, publisher in sent:
            message.header.stamp = stamp
            publisher.publish(message)
        self._press(int(reading.buttons), stamp)

    def _press(self, buttons: int, stamp: Any) -> None:
        """Publish what the buttons do, and each own button, where they have changed."""
        before, self._pressed = self._pressed, buttons
        self._joy.header.stamp = stamp
        if before < 0 or (before ^ buttons) % (1 << OWN):
            self._joy.buttons = [buttons >> i & 1 for i in range(OWN)]
            self._buttons.publish(self._joy)
        for i, publisher in enumerate(self._own):
            down = buttons >> OWN + i & 1
            if before < 0 or before >> OWN + i & 1 != down:
                self._joy.buttons = [down]
                publisher.publish(self._joy)

    def _velocity(self, X: Array, now: float) -> Array:
        """Velocity (6,) from the poses of the last 10 ms [m/s, rad/s]."""
        self._recent.append((now, X.copy()))
        while len(self._recent) > 2 and now - self._recent[0][0] > _WINDOW:
            self._recent.popleft()
        then, old = self._recent[0]
        if now <= then:
            return np.zeros(6)
        w, *axis = so3.quaternion(X[:3, :3] @ old[:3, :3].T)
        sine = math.hypot(*axis)
        turn = np.multiply(2.0 * math.atan2(sine, w) / sine if sine > 1e-12 else 2.0, axis)
        return np.concatenate([X[:3, 3] - old[:3, 3], turn]) / (now - then)

    def tell(self, state: str) -> None:
        """Publish the operating state: ENABLED, DISABLED, PAUSED or FAULT."""
        message = self._made_state()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.state, message.is_homed = state, True
        self.state = state
        self._operating.publish(message)
