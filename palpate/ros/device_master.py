"""Any driver as a CRTK master on ROS 2: its pose goes out, forces come in, and a force that goes stale is zero."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from palpate import _core
from palpate.base import stop_signals, switching
from palpate.base.arrays import Array, so3
from palpate.base.arrays.peaks import WINDOW, sustained_held
from palpate.devices.buttons import OWN, own_names
from palpate.devices.driver import Driver, Facts, Reading, as_reading, facts, limited
from palpate.ros import topic
from palpate.ros.background import BackgroundNode
from palpate.ros.latched import LatchedSubscription

STALE = 0.03
"""Age of a force after which the device gets none [s]."""
STALL = 0.012
"""Time without a completed round after which a second thread writes zero force [s]."""
_WINDOW = 0.01  # time over which the velocity is measured, where the driver has none [s]
_SWITCH = 0.0005  # longest wait for the interpreter while another thread of Python computes [s]
_PIECE = 1000  # rounds whose forces are counted at once
_STATES = {"enable": "ENABLED", "resume": "ENABLED", "disable": "DISABLED", "pause": "PAUSED"}
_KNOWN = (*_STATES, "home", "unhome")  # a device is calibrated by its own program: it is always homed


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
        from std_msgs.msg import Bool, Empty

        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        state = topic.message_type("crtk_msgs/OperatingState")
        make = self.node.create_publisher
        self._cp, self._setpoint = (make(PoseStamped, f"/{name}/{cp}", 10) for cp in ("measured_cp", "setpoint_cp"))
        self._cv = make(TwistStamped, f"/{name}/measured_cv", 10)
        self._grip = make(JointState, f"/{name}/gripper/measured_js", 10)
        self._buttons = make(Joy, f"/{name}/buttons", latched)
        self._state = make(state, f"/{name}/operating_state", latched)
        self._pose, self._twist, self._jaw, self._joy = PoseStamped(), TwistStamped(), JointState(), Joy()
        self._pose.header.frame_id = self._twist.header.frame_id = f"{name}_base"
        self._jaw.name = ["gripper"]
        self._made_state = state
        self._told = "DISABLED"
        self._own = [make(Joy, f"/{name}/{button}", latched) for button in own_names(driver, known.name)]
        self._driver, self._known, self._name = driver, known, name
        self._force, self._absolute, self._pressed = Force(), False, -1
        self._recent: deque[tuple[float, Array]] = deque()  # poses with their times [s]
        self._entered, self._running, self._enabled = np.inf, True, True
        self._sizes: list[tuple[float, float]] = []  # times [s] and sizes of the newest forces [N]
        self.outcome = Outcome(name, 0.0, 0, 0, 0, 0, 0, 0.0, 0.0)
        subscribe = self.node.create_subscription
        subscribe(WrenchStamped, f"/{name}/servo_cf", lambda m: self._take(m, False), 1)
        subscribe(WrenchStamped, f"/{name}/body/servo_cf", lambda m: self._take(m, not self._absolute), 1)
        subscribe(Empty, f"/{name}/hold", self._let_go, 1)
        subscribe(Empty, f"/{name}/free", self._let_go, 1)
        both = partial(LatchedSubscription, self.node)
        self._latching = (
            both(Bool, f"/{name}/body/set_cf_orientation_absolute", self._set_absolute),
            both(topic.message_type("crtk_msgs/StringStamped"), f"/{name}/state_command", self._command),
        )
        self.spin()

    def run(self, seconds: float | None = None) -> Outcome:
        """Open the device and serve it until a time has passed, it fails, or Ctrl-C; then zero force."""
        self._driver.open()
        watch = threading.Thread(target=self._watch, daemon=True)
        interrupted = threading.Event()
        with stop_signals.deferred(interrupted):
            return self._serve(seconds, watch, interrupted)

    def _serve(self, seconds: float | None, watch: threading.Thread, interrupted: threading.Event) -> Outcome:
        out, period = self.outcome, 1.0 / self._known.rate
        begin = due = time.monotonic()
        withdraw = switching.ask(_SWITCH)
        try:
            self._tell("ENABLED")
            watch.start()
            _core.schedule(True)  # as the threads of all drivers: other programs delay its poses and forces less
            while not interrupted.is_set() and (seconds is None or time.monotonic() - begin < seconds):
                self._round()
                due = max(due + period, time.monotonic() - 0.1)
                time.sleep(max(0.0, due - time.monotonic()))
        except Exception as error:
            out.fault = f"{type(error).__name__}: {error}"
        finally:
            self._running = False
            withdraw()
            self._count_forces()
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
        wrench = self._due(X[:3, :3], now) if measured and self._enabled else np.zeros(6)
        self._sizes.append((now, math.hypot(*wrench[:3].tolist())))
        if len(self._sizes) >= _PIECE:
            self._count_forces()
        self._driver.write(wrench)
        self._entered = np.inf
        self.outcome.rounds += 1

    def _count_forces(self) -> None:
        """Count the newest forces into the peaks; those of the last 50 ms stay for the next ones."""
        if not self._sizes:
            return
        t, F = np.array(self._sizes).T
        self.outcome.peak_force_N = max(self.outcome.peak_force_N, float(F.max()))
        self.outcome.peak_50ms_N = max(self.outcome.peak_50ms_N, sustained_held(t, F, float(t[-1])))
        self._sizes = [one for one in self._sizes if one[0] >= t[-1] - WINDOW]

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

    def _let_go(self, _: Any) -> None:
        """CRTK's hold and free: a device with forces alone cannot hold a position, so both end the force."""
        self._force = Force()

    def _command(self, message: Any) -> None:
        """CRTK's state_command; the state is published after each, since clients wait for it."""
        if message.string not in _KNOWN or not self._running:
            return
        state = _STATES.get(message.string, self._told)
        self._enabled, self._force = state == "ENABLED", Force()
        self._tell(state)

    def _tell(self, state: str) -> None:
        message = self._made_state()
        message.header.stamp = self.node.get_clock().now().to_msg()
        message.state, message.is_homed = state, True
        self._told = state
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
