"""The session around a device's loop: record, summary, fixtures, viewer."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from palpate import _core
from palpate.base import stop_signals
from palpate.devices.buttons import press
from palpate.devices.driven import DrivenLoop
from palpate.devices.driver import Driver
from palpate.devices.leader import leader_of
from palpate.devices.loop import WORDS, DeviceLoop
from palpate.devices.native import NativeLoop
from palpate.record.ticks import Ticks
from palpate.scene.scene import Scene
from palpate.sensing.source import Clouds
from palpate.session import LiveSession, State
from palpate.session.faults import NO_FAULTS, SeenFaults
from palpate.session.run_folder import require_writable
from palpate.session.summary import Summary

_CHECK_PERIOD = 0.05  # interval at which a run looks for faults of the driver [s]


class DeviceSession(LiveSession):
    """A session whose leader is a device. Its summary names every fault that removed the force."""

    def __init__(
        self, loop: DeviceLoop, out: str | os.PathLike[str] | None = None, clouds: Clouds | None = None
    ) -> None:
        self._seen = SeenFaults(NO_FAULTS | {"settling"})
        self.seen = self._seen.seen
        """Faults by the name of their status bit."""
        scene = loop.rig.scene
        self._pressed = 0  # buttons that the console knows
        super().__init__(loop.rig, loop, scene.rates.haptic, scene.seed, out, clouds)
        self.world = loop.world
        self._steps, self._counted_at = 0, time.monotonic()

    def attach(self, remote: _core.RemoteEnd | None) -> None:
        """Let the hand feel what this end of a link renders, from the next start on; None: the objects of the scene."""
        self._require_idle()
        assert isinstance(self._loop, DeviceLoop)
        self._loop.cycle.attach(remote)

    @property
    def state(self) -> State:
        """The newest tick; the phase is empty, as the hand is not simulated."""
        return State(self.latest(), "")

    def stepped(self) -> None:
        """To be called after every step of a loop that may run faster than real time: counts its ticks in time."""
        self._steps += 1
        if self._steps < self.rate:
            return
        now = time.monotonic()
        if now - self._counted_at < 0.5 * self._steps / self.rate:
            self._drain()
        self._steps, self._counted_at = 0, now

    def _take(self, ticks: Ticks, realtime: bool = False) -> None:
        self._seen.take(ticks)
        super()._take(ticks, realtime)

    def _drain(self) -> None:
        super()._drain()
        loop, source = self._loop, self.scene.arms.leader.driver or "device"
        if isinstance(loop, DeviceLoop):
            self._pressed = press(self.console, self._pressed, 0 if loop.fault() else loop.buttons, source)

    def _faults(self) -> list[str]:
        named = self._loop.named if isinstance(self._loop, DrivenLoop) else set()
        notices = self._loop.notices() if isinstance(self._loop, NativeLoop) else []
        return [
            *super()._faults(),
            *self._seen.words(),
            *notices,
            *(f"driver: {WORDS[fault][0]}; mend: {WORDS[fault][1]}" for fault in named),
        ]

    @property
    def failed(self) -> bool:
        """True if the driver failed, which ended the run."""
        return self._loop.fault() is not None


class DrivenSession(DeviceSession):
    """Renders a scene on a device with a driver, in real time.

        with palpate.devices.DrivenSession(palpate.Scene.load("my.yaml", trust=True)) as session:
            summary = session.run(60.0)

    Args:
        scene: a scene whose ``arms.leader.driver`` names a driver.
        out: folder for records; None: nothing is recorded.
        driver: a driver object; that of the scene when left out.

    Raises:
        DeviceError: the driver is missing, invalid, or code that is not trusted. SceneError, MeshError: the scene
        cannot run. OutputError: `out` cannot be written.
    """

    def __init__(self, scene: Scene, out: str | os.PathLike[str] | None = None, driver: Driver | None = None) -> None:
        if out is not None:
            require_writable(Path(out))
        super().__init__(leader_of(scene, driver).loop(None), out)

    @property
    def driver(self) -> Driver | _core.Driver:
        """The driver of the device."""
        assert isinstance(self._loop, DrivenLoop | NativeLoop)
        return self._loop.driver

    def run(self, duration: float | None = None, on_progress: Callable[[State], None] | None = None) -> Summary:
        """Render the scene for a time, or until its task is done, the driver fails, Ctrl-C or SIGTERM.

        The record is then closed.

        Args:
            duration: time [s]; no limit when left out.
            on_progress: called with the state about twenty times a second.

        Returns:
            The summary; its faults name the cause if the driver failed.
        """
        self._require_idle()
        with stop_signals.deferred(self._interrupted):
            try:
                self.start()
                end = time.monotonic() + (np.inf if duration is None else duration)
                while time.monotonic() < end and self._loop.fault() is None and not self._task_over.is_set():
                    if self._interrupted.wait(_CHECK_PERIOD):
                        break
                    if on_progress is not None:
                        on_progress(self.state)
            except BaseException:
                self.close(interrupted=True)
                raise
            return self.close(interrupted=self._interrupted.is_set())
