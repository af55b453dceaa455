"""Any driver as a CRTK master on ROS 2: its pose goes out, forces come in, and a force that goes stale is zero."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.base.arrays import Array
from palpate.base.arrays.peaks import SustainedPeak
from palpate.devices.buttons import OWN, own_names
from palpate.devices.driver import Driver, Facts, Reading, as_reading, facts, limited
from palpate.ros import topic
from palpate.ros.background import BackgroundNode

STALE = 0.03
"""Age of a force after which the device gets none [s]."""
STALL = 0.012
"""Time without a completed round after which a second thread writes zero force [s]."""
_WINDOW = 0.01  # time over which the velocity is measured, where the driver has none [s]


@dataclass
class Outcome:
    """What a run did. The keys are the documented contract of ``--json``."""

    name: str  #: of the arm on the network
    rate_Hz: float  #: rounds per second
    rounds: int
    forces: int  #: messages of forces that were taken
    refused: int  #: messages with a number that is not finite, or moments of a device without motors for them
    stale: int  #: how often a force went stale and became zero
    stalls: int  #: how often the driver stood still and a second thread wrote zero
    peak_force_N: float
    peak_50ms_N: float  #: largest mean over 50 ms
    fault: str = ""  #: why it ended; empty: Ctrl-C or the duration


@dataclass
class Force:
    """The newest wrench of the network, in base axes or in those of the handle."""

    wrench: Array = field(default_factory=lambda: np.zeros(6))
    body: bool = False
    at: float = -np.inf  # time of arrival on the monotonic clock [s]


class DeviceMaster(BackgroundNode):
    """The node of one device.

    Args:
        name: name of the arm on the network, such as MTMR.
        driver: the driver, not yet open.
        known: its facts.
        domain: ROS domain.
    """

    def __init__(self, name: str, driver: Driver, known: Facts, domain: int) -> None:
        super().__init__(f"palpate_device_{name}", domain)
        from geometry_msgs.msg import PoseStamped, TwistStamped, WrenchStamped
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import JointState, Joy
        from std_msgs.msg import Bool

        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        state = topic.message_type("crtk_msgs/OperatingState")
        make = self.node.create_publisher
        self._cp = make(PoseStamped, f"/{name}/measured_cp", 10)
        self._cv = make(TwistStamped, f"/{name}/measured_cv", 10)
        self._grip = make(JointState, f"/{name}/gripper/measured_js", 10)
        self._buttons = make(Joy, f"/{name}/buttons", latched)
        self._state = make(state, f"/{name}/operating_state", latched)
        self._pose, self._twist, self._jaw, self._joy = PoseStamped(), TwistStamped(), JointState(), Joy()
        self._pose.header.frame_id = self._twist.header.frame_id = f"{name}_base"
        self._jaw.name = ["gripper"]
        self._made_state = state
        self._own = [make(Joy, f"/{name}/{button}", latched) for button in own_names(driver, known.name)]
        self._driver, self._known, self._name = driver, known, name
        self._force, self._absolute, self._pressed = Force(), False, -1
        self._recent: deque[tuple[float, Array]] = deque(maxlen=max(2, round(_WINDOW * known.rate)))
        self._entered, self._running = np.inf, True
        self._held = SustainedPeak(1.0 / known.rate)
        self.outcome = Outcome(name, 0.0, 0, 0, 0, 0, 0, 0.0, 0.0)
        subscribe = self.node.create_subscription
        subscribe(WrenchStamped, f"/{name}/servo_cf", lambda m: self._take(m, False), 1)
        subscribe(WrenchStamped, f"/{name}/body/servo_cf", lambda m: self._take(m, not self._absolute), 1)
        subscribe(Bool, f"/{name}/body/set_cf_orientation_absolute", self._set_absolute, latched)
        self.spin()

    def run(self, seconds: float | None = None) -> Outcome:
        """Open the device and serve it until a time has passed, it fails, or an exception such as Ctrl-C; then zero."""
        out, period = self.outcome, 1.0 / self._known.rate
        self._driver.open()
        watch = threading.Thread(target=self._watch, daemon=True)
        begin = due = time.monotonic()
        try:
            self._tell("ENABLED")
            watch.start()
            while seconds is None or time.monotonic() - begin < seconds:
                self._round()
                due = max(due + period, time.monotonic() - 0.1)
                time.sleep(max(0.0, due - time.monotonic()))
        except Exception as error:
            out.fault = f"{type(error).__name__}: {error}"
        finally:
            self._running = False
            out.peak_50ms_N = self._held.value
            self._write(np.zeros(6))
            out.rate_Hz = out.rounds / max(1e-9, time.monotonic() - begin)
            self._tell("FAULT" if out.fault else "DISABLED")
            self._driver.close()
        return out

    def _round(self) -> None:
        self._entered = time.monotonic()
        reading = as_reading(self._driver.read())
        now = time.monotonic()
        X = np.asarray(reading.X, dtype=np.float64)
        measured = bool(np.isfinite(X).all())  # a driver without a measurement now gives NaN: no pose, no force
        if measured:
            self._publish(reading, X, now)
        wrench = self._due(X[:3, :3], now) if measured else np.zeros(6)
        size = float(np.linalg.norm(wrench[:3]))
        self._held.add(np.array([size]))
        self.outcome.peak_force_N = max(self.outcome.peak_force_N, size)
        self._driver.write(wrench)
        self._entered = np.inf
        self.outcome.rounds += 1

    def _due(self, R: Array, now: float) -> Array:
        """The wrench of the network in base axes, within the caps of the device; zero if it is stale."""
        force = self._force
        if now - force.at > STALE:
            if force.wrench.any():
                self.outcome.stale += 1
                self._force = Force()
            return np.zeros(6)
        wrench = np.concatenate([R @ force.wrench[:3], R @ force.wrench[3:]]) if force.body else force.wrench
        return limited(wrench, self._known)

    def _publish(self, reading: Reading, X: Array, now: float) -> None:
        stamp = self.node.get_clock().now().to_msg()
        p, q = self._pose.pose.position, self._pose.pose.orientation
        p.x, p.y, p.z = X[:3, 3].tolist()
        q.x, q.y, q.z, q.w = Rotation.from_matrix(X[:3, :3]).as_quat().tolist()
        V = self._velocity(X, now) if reading.V is None else np.asarray(reading.V, dtype=np.float64)
        v, w = self._twist.twist.linear, self._twist.twist.angular
        v.x, v.y, v.z, w.x, w.y, w.z = V.tolist()
        self._jaw.position = [float(reading.gripper)]
        for message, publisher in ((self._pose, self._cp), (self._twist, self._cv), (self._jaw, self._grip)):
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
        then, old = self._recent[0]
        if now <= then:
            return np.zeros(6)
        turn = Rotation.from_matrix(X[:3, :3] @ old[:3, :3].T).as_rotvec()
        return np.concatenate([X[:3, 3] - old[:3, 3], turn]) / (now - then)

    def _take(self, message: Any, body: bool) -> None:
        f, t = message.wrench.force, message.wrench.torque
        wrench = np.array([f.x, f.y, f.z, t.x, t.y, t.z])
        if not np.isfinite(wrench).all():
            self.outcome.refused += 1
            self._force = Force()
            return
        self.outcome.forces += 1
        self._force = Force(wrench, body, time.monotonic())

    def _set_absolute(self, message: Any) -> None:
        self._absolute = bool(message.data)

    def _tell(self, state: str) -> None:
        message = self._made_state()
        message.header.stamp = self.node.get_clock().now().to_msg()
        message.state, message.is_homed = state, True
        self._state.publish(message)

    def _watch(self) -> None:
        silenced = False
        while self._running:
            late = time.monotonic() - self._entered > STALL
            if late and not silenced:
                self.outcome.stalls += 1
                self._write(np.zeros(6))
            silenced = late
            time.sleep(0.002)

    def _write(self, wrench: Array) -> None:
        try:
            self._driver.write(wrench)
        except Exception as error:
            self.outcome.fault = self.outcome.fault or f"write() raised {type(error).__name__}: {error}"


def serve(name: str, driver: Driver, arm: str, network: bool, seconds: float | None) -> Outcome:
    """Run the master of a driver.

    Args:
        name: name of the driver, for messages.
        driver: the driver, not yet open.
        arm: name of the arm on the network.
        network: True: other machines may hear and command it.
        seconds: time after which it ends; None: Ctrl-C ends it [s].

    Raises:
        DeviceError: the facts of the driver are invalid, or its device cannot be opened.
    """
    from palpate import ros

    known = facts(driver, name)
    domain = ros.load().Context(network=network).domain
    with DeviceMaster(arm, driver, known, domain) as master:
        return master.run(seconds)
