"""A driver in Python and the haptic cycle, in a thread of their own, with a second thread that watches over them."""

from __future__ import annotations

import threading
import time
import warnings
from collections.abc import Callable

import numpy as np

from palpate import _core
from palpate.base import switching
from palpate.base.arrays import Array
from palpate.base.errors import DeviceError, PalpateError, PalpateWarning
from palpate.devices.driver import Driver, Facts, as_reading, facts
from palpate.devices.loop import WORDS, DeviceLoop, device_scene
from palpate.record.ticks import Timing
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene

STALL = 0.012
"""Time without a completed round of read and write after which zero force is written [s]."""
PATIENCE = 1.0
"""Time after which a call that does not return ends the session [s]."""
_WATCH = 0.002  # period of the watchdog [s]
_RAMP = 0.1  # longest ramp-down at the end [s]
_SWITCH = 0.0005  # longest wait for the interpreter while another thread of Python computes [s]
_ZERO = np.zeros(6)
_POSES = (_core.DeviceFault.not_rigid, _core.DeviceFault.left_handed)


def driven_scene(scene: Scene, known: Facts) -> Scene:
    """The scene at the rate of a driver, with its caps and its gripper."""
    cap = min(known.force_max or scene.stability.force_cap, scene.stability.force_cap)
    return _with_gripper(device_scene(scene, known.name, known.rate, cap, known.moment_max), known)


def _with_gripper(scene: Scene, known: Facts) -> Scene:
    """The scene with a gripper torque that the driver can give."""
    leader, most = scene.arms.leader, known.gripper_max
    if leader.gripper.torque > most == 0.0:
        what = f"the gripper of {known.name} has no motor: its fingers do not feel the jaws"
        where = scene.where("arms", "leader", "gripper", "torque")
        warnings.warn(PalpateWarning(what, where=where, mend="leave gripper.torque out"), stacklevel=4)
    gripper = leader.gripper.model_copy(update={"torque": min(leader.gripper.torque, most)})
    arms = scene.arms.model_copy(update={"leader": leader.model_copy(update={"gripper": gripper})})
    return scene.model_copy(update={"arms": arms})


class DrivenLoop(DeviceLoop):
    """Reads a driver, steps the cycle, writes the wrench; at the rate of the driver.

    The force on the device is zero within 20 ms of a fault of the driver: after an exception or a value of the wrong
    shape, which end the loop; while numbers are invalid; and when a call does not return, as the watchdog then writes
    zeros. Only a driver that keeps the interpreter locked is out of its reach: such code belongs into another process
    (driver ``shared-memory``) or into a shared object.

    Args:
        scene: scene to render; its rate becomes that of the driver, and its force cap at most that of the driver.
        driver: the driver, not yet open.
        name: name of the driver for messages.
        rig: the rig of `driven_scene`, if it is built already.
        own: as for `DeviceLoop`.

    Raises:
        DeviceError: the facts of the driver are invalid. SceneError, MeshError: the scene cannot run.
    """

    def __init__(self, scene: Scene, driver: Driver, name: str, rig: Rig | None = None, own: bool = True) -> None:
        self.facts = known = facts(driver, name)
        scene = driven_scene(scene, known) if rig is None else rig.scene
        super().__init__(scene, known.at_handle, known.workspace, rig=rig, own=own)
        self.driver = driver
        if isinstance(driver, Driver):
            driver.force_cap = self.rig.scene.stability.force_cap
        self.stalls = 0  #: how often the watchdog wrote zero force
        self._lateness: list[float] = []
        self.named: set[_core.DeviceFault] = set()  #: faults that the status does not tell apart
        self._missed, self._scheduler = 0, "not started"
        self._ended: str | None = None
        self._call, self._entered = "", 0.0
        self._silenced = False
        self._withdraw: Callable[[], None] = lambda: None  # the wish for the interpreter
        self._stop, self._finished = threading.Event(), threading.Event()
        self._threads: list[threading.Thread] = []

    def start(self) -> None:
        """Open the device and start both threads.

        Raises:
            DeviceError: the device cannot be opened.
        """
        if self._threads:
            return
        super().start()
        try:
            self.driver.open()
        except PalpateError:
            raise
        except Exception as error:
            what = f"driver {self.facts.name}: open() raised {type(error).__name__}: {error}"
            raise DeviceError(what, mend="check cable, power and permissions; `palpate device list`") from error
        self.cycle.allow_force(True)
        self._stop.clear()
        self._finished.clear()
        self._ended, self._entered = None, time.monotonic()
        self._withdraw = switching.ask(_SWITCH)
        self._threads = [
            threading.Thread(target=self._run, name="palpate-driver", daemon=True),
            threading.Thread(target=self._watch, name="palpate-driver-watch", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """Ramp the force to zero, close the device and end the threads; does not wait for a driver that hangs."""
        if not self._threads:
            return
        self._stop.set()
        self._finished.wait(_RAMP + PATIENCE)
        self._withdraw()
        for thread in self._threads:
            thread.join(timeout=0.1)
        self._threads = []
        try:
            self.driver.close()
        except BaseException as error:
            self._end(f"close() raised {type(error).__name__}: {error}")
        super().stop()

    def fault(self) -> str | None:
        """Why the loop ended by itself; None if it did not."""
        call = self._call
        if call and not self._finished.is_set() and time.monotonic() - self._entered > PATIENCE:
            self._end(f"{call}() did not return within {PATIENCE:g} s")
        return self._ended

    def notices(self) -> list[str]:
        """The faults of the driver's poses."""
        return [f"driver: {WORDS[fault][0]}; mend: {WORDS[fault][1]}" for fault in self.named]

    def timing(self) -> Timing:
        """Compute time, lateness against the deadlines, missed deadlines, stalls of the driver, scheduling."""
        late = 1e6 * np.array(self._lateness or [0.0])
        quantiles = {"p50": 50.0, "p99": 99.0, "p999": 99.9, "max": 100.0}
        shares = {name: float(np.percentile(late, q)) for name, q in quantiles.items()}
        return {
            **super().timing(),
            "lateness_us": shares,
            "missed_ticks": self._missed,
            "stalls": self.stalls,
            "scheduler": f"{self._scheduler}; lateness p50 {shares['p50']:.0f} us, p99 {shares['p99']:.0f} us, "
            f"at most {shares['max']:.0f} us",
        }

    # -- the thread of the driver ------------------------------------------------------------------------------------

    def _run(self) -> None:
        self._scheduler = _core.schedule(True)
        period = 1.0 / self.facts.rate
        due = time.monotonic()
        try:
            while not self._done():
                self._round()
                due = self._sleep(due + period, period)
        except BaseException as error:  # SystemExit, too: a driver must not end its thread in silence
            call = f"{self._call}() " if self._call else ""
            text = str(error) if isinstance(error, PalpateError) else f"{call}raised {type(error).__name__}: {error}"
            self._end(text)
        finally:
            if self._ended is not None:
                self.cycle.report_failure(self.wrench)
            self._write_zero()
            self._finished.set()

    def _done(self) -> bool:
        """True once a stop is requested and the force has ramped to zero; ends the teleoperation first."""
        if self._ended is not None:
            return True
        if not self._stop.is_set():
            return False
        self.cycle.allow_force(False)
        return not self.wrench.any()

    def _round(self) -> None:
        self._enter("read")
        given = self.driver.read()
        t = time.monotonic()
        self._enter("")
        reading = as_reading(given)
        if self._silenced:  # the watchdog has written zeros meanwhile: the force returns by a ramp, after a pause
            self._silenced = False
            self.cycle.report_failure(self.wrench)
        else:
            X = np.ascontiguousarray(reading.X, dtype=np.float64)
            V = None if reading.V is None else np.ascontiguousarray(reading.V, dtype=np.float64)
            fault = self.step(t, X, V, float(reading.gripper), int(reading.buttons))
            if fault in _POSES:
                self.named.add(fault)
        self._enter("write")
        self.driver.write(self._limited())
        if self.facts.gripper_max > 0.0:
            self._enter("grip")
            self.driver.grip(self.cycle.gripper_torque)
        self._enter("")

    def _limited(self) -> Array:
        wrench = self.wrench.copy()
        most = self.facts.moment_max
        moment = float(np.linalg.norm(wrench[3:]))
        if moment > most:
            wrench[3:] *= most / moment
        return wrench

    def _enter(self, call: str) -> None:
        self._call, self._entered = call, time.monotonic()

    def _sleep(self, due: float, period: float) -> float:
        """Sleep until the deadline; returns it, or the next one if some were missed."""
        time.sleep(max(0.0, due - time.monotonic()))
        late = time.monotonic() - due
        if len(self._lateness) < 1_000_000:
            self._lateness.append(late)
        skipped = int(late / period)
        self._missed += skipped
        return due + skipped * period

    # -- the watchdog ------------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        while not self._finished.wait(_WATCH):
            pause = 0.0 if self._call else 1.0 / self.facts.rate
            if time.monotonic() - self._entered > STALL + pause and not self._silenced:
                self._silenced = True
                self.stalls += 1
                self._write_zero()
            self.fault()

    def _write_zero(self) -> None:
        try:
            self.driver.write(_ZERO.copy())
            if self.facts.gripper_max > 0.0:
                self.driver.grip(0.0)
        except BaseException as error:
            self._end(f"write() raised {type(error).__name__}: {error}")

    def _end(self, what: str) -> None:
        if self._ended is None:
            self._ended = f"driver {self.facts.name}: {what}; the force was set to zero"
