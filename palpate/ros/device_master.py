"""Any driver as a CRTK master on ROS 2: its pose goes out, forces come in, and a force that goes stale is zero."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from palpate import _core
from palpate.base import stop_signals, switching
from palpate.base.arrays import Array
from palpate.base.arrays.peaks import HeldPeak
from palpate.devices.buttons import own_names
from palpate.devices.driver import Driver, Facts, as_reading, facts, limited
from palpate.ros import topic
from palpate.ros.background import BackgroundNode
from palpate.ros.device_topics import DeviceTopics
from palpate.ros.latched import LatchedSubscription

STALE = 0.03
"""Age of a force after which the device gets none [s]."""
STALL = 0.012
"""Time without a completed round after which a second thread writes zero force [s]."""
_SWITCH = 0.0005  # longest wait for the interpreter while another thread of Python computes [s]
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
        from geometry_msgs.msg import WrenchStamped
        from std_msgs.msg import Bool, Empty

        self._out = DeviceTopics(self.node, name, own_names(driver, known.name))
        self._driver, self._known = driver, known
        self._force, self._absolute = Force(), False
        self._entered, self._running, self._enabled = np.inf, True, True
        self._peak = HeldPeak()
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
            self._out.tell("ENABLED")
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
            self._write(np.zeros(6))
            withdraw()
            _core.schedule(False)  # the thread is the caller's
            out.peak_force_N, out.peak_50ms_N = self._peak.values()
            out.rate_Hz = out.rounds / max(1e-9, time.monotonic() - begin)
            self._out.tell("FAULT" if out.fault else "DISABLED")
            self._driver.close()
        return out

    def _round(self) -> None:
        self._entered = time.monotonic()
        reading = as_reading(self._driver.read())
        now = time.monotonic()
        X = np.asarray(reading.X, dtype=np.float64)
        measured = bool(np.isfinite(X).all())  # a driver without a measurement now gives NaN: no pose, no force
        if measured:
            self._out.publish(reading, X, now)
        wrench = self._due(X[:3, :3], now) if measured and self._enabled else np.zeros(6)
        self._peak.add(now, math.hypot(*wrench[:3].tolist()))
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
        state = _STATES.get(message.string, self._out.state)
        self._enabled, self._force = state == "ENABLED", Force()
        self._out.tell(state)

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
