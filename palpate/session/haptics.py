"""`palpate.Haptics`: the haptic cycle for anybody's loop."""

from __future__ import annotations

import os
import threading
import time
import weakref
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import DeviceError
from palpate.devices.own_loop import OwnLoop
from palpate.scene.scene import Scene
from palpate.sensing.source import Clouds
from palpate.session.session import Session
from palpate.session.summary import Summary


class Haptics:
    """Renders a scene on a device whose loop you write, at 50 to 10000 Hz.

        with palpate.Haptics(scene, rate=1000) as haptics:
            while running:
                wrench = haptics.step(time.monotonic(), device.pose())
                device.command(wrench)

    The first pose is where the tool starts (``arms.follower.start`` of the scene); from there the tool follows the
    relative motion of the hand times ``mapping.scale``. ``arms.leader.base`` places the axes of the device in the
    scene; without it they are those of the world. All caps, the passivity layer, guidance and the watchdog of the scene
    act on every step. A ``Haptics`` object belongs to one thread; `session` is for other threads. Of several hands each
    has a `palpate.OwnLoop`.

    Args:
        scene: a scene, or the path of a scene file.
        record: folder for records, in which this run gets its own folder; None: nothing is recorded.
        rate: rate of your loop, which it should keep within a factor of two [Hz]; the scene's when left out.
        force_cap: largest force, at most the scene's [N]; the scene's when left out.
        moment_max: largest moment that the device can give, 0: no motor turns its handle [N m]. When left out it is
            ``stability.moment_cap`` of the scene file, and 0 if the file does not give one: energy that only a moment
            would take from the hand must not count as taken.
        clouds: sources of the objects that are clouds of a sensor, by name (docs/sensing.md). A thread beside your loop
            turns their frames into surfaces.
        delay: time from a measurement to the force on the hand, as ``palpate device bench`` measures it [s]. When left
            out, the scene's ``loop_delay`` or ``stability.known_delay`` holds; without them every force is paid for any
            delay of up to 3 ms.
        resolution: largest step of the measured position, or six times its noise if that is larger [m].
        friction: dry friction that certainly resists the handle, at the lower end of what ``palpate device bench``
            measures [N]. It pays for energy that sampling creates, so that the passivity layer takes less force.
        damping: viscous friction, likewise [N s/m].

    Raises:
        SceneError, MeshError: the scene cannot run. OutputError: `record` cannot be written. PalpateError: `rate` or
            `force_cap` is out of range. DeviceError: `friction` or `damping` is given without `resolution`.
    """

    def __init__(
        self,
        scene: Scene | str | os.PathLike[str],
        record: str | os.PathLike[str] | None = None,
        rate: float | None = None,
        force_cap: float | None = None,
        clouds: Clouds | None = None,
        moment_max: float | None = None,
        delay: float | None = None,
        resolution: float = 0.0,
        friction: float = 0.0,
        damping: float = 0.0,
    ) -> None:
        if not isinstance(scene, (Scene, str, os.PathLike)):
            what = f"palpate.Haptics takes a scene, or the path of a scene file. Got: {type(scene).__name__}"
            raise DeviceError(what, mend="make a scene of a dictionary: palpate.Scene.model_validate(values)")
        loaded = scene if isinstance(scene, Scene) else Scene.load(Path(scene))
        self._plant = OwnLoop(loaded, rate, force_cap, moment_max, delay, resolution, friction, damping)
        self.session = Session(self._plant.scene, record, clouds=clouds, plant=self._plant)
        """Record, controls, fixtures and newest state; also for `palpate.viewer.LiveViewer`."""
        self._steps, self._counted_at = 0, time.monotonic()
        self._summary: Summary | None = None
        self._dropped = weakref.finalize(self, _close_dropped, self.session)
        self.session.start()

    def step(
        self, t: float, X: npt.ArrayLike, V: npt.ArrayLike | None = None, gripper: float = 0.0, buttons: int = 0
    ) -> Array:
        """One step of the loop: a measured state in, the wrench to command out.

        Args:
            t: time of the measurement on a steady clock of yours [s].
            X: X_LH (4, 4), pose of the handle in the axes of the device's base [m].
            V: V_LH (6,), its velocity [m/s, rad/s]; estimated from the poses (40 Hz low-pass) when left out.
            gripper: angle of the gripper, 0: closed [rad].
            buttons: bit 0: clutch, the hand moves and the tool stays.

        Returns:
            Wrench (6,) on the hand in the axes of the device's base: force [N], moment about the handle [N m], which is
            zero for a device without `moment_max`. It is
            finite and within the caps at every step. A NaN, a pose that is not rigid or left-handed axes give zeros;
            after a time that does not increase or a gap, the force is zero within 15 ms. `status` and `why()` state
            the cause. The force returns by a ramp 0.1 s after the last fault.

        Raises:
            DeviceError: an argument has the wrong shape or type, or the object is closed; the wrench is then zero.
        """
        if self._summary is not None:
            raise DeviceError("Haptics.step after close()", mend="make a new palpate.Haptics")
        wrench = self._plant.step(t, X, V, gripper, buttons)
        self._keep_up()
        return wrench

    @property
    def gripper_torque(self) -> float:
        """Torque of the gripper on the fingers after the last step, positive when it opens them [N m].

        It is within ``arms.leader.gripper.torque`` of the scene, and zero after a fault.
        """
        return self._plant.gripper_torque

    @property
    def status(self) -> str:
        """``ok``, or the names of all present conditions, the gravest first (`OwnLoop.status`)."""
        return self._plant.status

    def why(self) -> str:
        """Why there is no force, or a reduced one, in a sentence with the mend; ``ok`` without a reason.

        While the tool touches nothing, it says which object is nearest, how far it is, and in which direction of the
        device's axes the hand must move.
        """
        words = self._plant.why()
        free = self.session.nearest(self.session.latest()) if words == "ok" else ""
        return f"no force: the tool touches nothing; {free}" if free else words

    def close(self) -> Summary:
        """Close the record and return the summary of the run. Command zero force to your device before."""
        if self._summary is None:
            self._dropped.detach()
            self._summary = self.session.close()
        return self._summary

    def __enter__(self) -> Self:
        """The object itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the record."""
        self.close()

    def _keep_up(self) -> None:
        """Drain a loop that steps faster than real time, whose ticks the session's thread would be too late for."""
        self._steps += 1
        if self._steps < self.session.rate:
            return
        now = time.monotonic()
        if now - self._counted_at < 0.5 * self._steps / self.session.rate:
            self.session.drain()
        self._steps, self._counted_at = 0, now


def _close_dropped(session: Session) -> None:
    """Close the session of an object that nobody has closed: it records no longer, and its record is complete.

    Objects can be collected in any thread, also in one that reads the ticks of this session and would wait for itself.
    """
    if threading.main_thread().is_alive():
        threading.Thread(target=session.close, name="palpate-close").start()
    else:  # at the end of the program, where no thread can begin
        session.close()
