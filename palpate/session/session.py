"""A session: one scene, run in lockstep or in real time, and recorded."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate import _core
from palpate.base import stop_signals
from palpate.base.arrays import Array
from palpate.base.errors import PalpateError, SceneError, StateError
from palpate.record.ticks import Rows, Ticks, as_ticks
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.session.backlog import loop_first
from palpate.session.beside import Turns
from palpate.session.live import DRAIN, LiveSession
from palpate.session.plants import Plant, plant_of
from palpate.session.run_folder import require_writable
from palpate.session.state import State
from palpate.session.summary import Summary

if TYPE_CHECKING:
    from palpate.devices.driver import Driver
    from palpate.sensing.source import Clouds
    from palpate.session.faults import Seen, SeenFaults

BATCH = 0.1  # simulated time per batch of ticks in lockstep [s]
UNWATCHED_BATCH = (
    0.25  # the same if nothing acts between batches: the loop then waits less for the recording thread [s]
)


class Session(LiveSession):
    """Runs a scene, with a simulated hand, or on the device of its driver (``arms.leader.driver``).

        session = palpate.Session(palpate.Scene.load("scenes/palpation.yaml"), out="runs")
        summary = session.run(10.0)

    A device runs in real time only. Its summary names every fault that removed the force.

    Args:
        scene: the scene to run; its values as a dictionary, the path of its file, or the name of a shipped one.
        out: folder for records, in which each run gets its own folder; None: nothing is recorded.
        seed: seed of all random numbers; the scene's when left out.
        clouds: sources of the objects that are clouds of a sensor, by name: a ``CloudSource``, or an iterable of
            arrays (N, 3) [m] in W that is asked at 30 Hz.
        rig: the rig of the scene, if it is built already.
        driver: an object that drives a device (`palpate.devices.Driver`); that of the scene when left out.
        plant: where the hand is, such as a `palpate.ros.plant.CrtkPlant`; that of scene and driver when left out.

    Raises:
        SceneError, MeshError: the scene cannot run. OutputError: `out` cannot be written. DeviceError: the driver is
        missing, invalid, or code that is not trusted.
    """

    def __init__(
        self,
        scene: Scene | dict[str, Any] | str | os.PathLike[str],
        out: str | os.PathLike[str] | None = None,
        seed: int | None = None,
        clouds: Clouds | None = None,
        rig: Rig | None = None,
        driver: Driver | None = None,
        plant: Plant | None = None,
    ) -> None:
        if out is not None:
            require_writable(Path(out))
        plant = plant or plant_of(Scene.of(scene), driver)
        if rig is not None and not plant.simulated and not self.paired:
            why = "its rate, its caps and its workspace come from the driver"
            raise StateError("the rig of a device is built by its session", why=why, mend="leave rig out")
        rig = rig or plant.build()
        scene = rig.scene
        seed = scene.seed if seed is None else seed
        if scene.graspable is not None and not self.paired:
            what = f"the object {scene.graspable.name!r} is handed from one instrument to another, and there is one"
            raise SceneError(what, where=scene.where("graspable"), mend="give the scene a section pairs")
        self._clouds, self.plant = clouds, plant
        self._seen: SeenFaults | None = None  # of a device: what removed the force
        self._pressed = 0  # buttons of the handle that the console knows
        self._turns = Turns()
        super().__init__(rig, plant.begin(rig, seed, self.paired), scene.rates.haptic, seed, out, clouds)
        self.world = plant.world
        if not plant.simulated:
            from palpate.session import faults

            self._seen = faults.SeenFaults(faults.NO_FAULTS | {"settling"})

    @property
    def simulation(self) -> _core.Simulation:
        """The simulation that the session runs.

        Raises:
            StateError: the hand is on a device.
        """
        self._require_simulated()
        assert isinstance(self._loop, _core.Simulation)
        return self._loop

    @property
    def seen(self) -> dict[str, Seen]:
        """Faults that removed the force of a device, by the name of their status bit."""
        return {} if self._seen is None else self._seen.seen

    @property
    def failed(self) -> bool:
        """True if the loop ended by itself, as when a driver fails."""
        return self._loop.fault() is not None

    @property
    def state(self) -> State:
        """State of the newest tick; the phase is empty where the hand is not simulated."""
        tick = self.latest()
        return State(tick, self.plant.phase(float(tick["t"])))

    def attach(self, remote: _core.RemoteEnd | None) -> None:
        """Let the hand feel what this end of a link renders, from the next start on; None: the objects of the scene."""
        if not self.plant.simulated:
            self._require_idle()
        self.plant.attach(remote)

    def run(
        self,
        duration: float | None = None,
        realtime: bool | None = None,
        on_progress: Callable[[State], None] | None = None,
    ) -> Summary:
        """Run for a duration, then close the record.

        Args:
            duration: time [s]; when left out, that of the scene, and on a device no limit.
            realtime: True: in real time, in a thread of its own; False: in lockstep, as fast as possible. When left
                out, a simulation runs in lockstep and a device in real time.
            on_progress: called with the state about ten times per second of simulated time (lockstep) or real time.

        Returns:
            The summary of all ticks since the record began. Ctrl-C ends the run early, which the summary reports; its
            faults name the cause where a device failed.

        Raises:
            StateError: a device shall run in lockstep.
        """
        self._require_idle()
        realtime = not self.plant.simulated if realtime is None else realtime
        if duration is None:
            duration = self.scene.duration if self.plant.simulated else np.inf
        if not realtime:
            self._require_simulated()
        with stop_signals.deferred(self._interrupted):
            try:
                (self._run_realtime if realtime else self._run_lockstep)(duration, on_progress)
            except BaseException:
                self.close(interrupted=True)  # the record is complete after any exception
                raise
            return self.close(interrupted=self._interrupted.is_set())

    def step(self, n: int = 1) -> State:
        """Run `n` ticks in lockstep and return the newest; the record stays open."""
        self._require_idle()
        self.require_own_clock()
        for rows in self._advance(n):
            self._take(as_ticks(rows))
        return self.state

    def lead(self, n: int, hand_W: Array) -> Ticks:
        """Run `n` ticks in lockstep while an operator model moves the hand; the record stays open.

        Args:
            n: number of ticks.
            hand_W: (n, 3) displacement of the hand from its path in W at the end of each tick [m].

        Returns:
            The ticks (n,), or fewer while the session is paused.
        """
        self._require_idle()
        self.require_own_clock()
        ticks = as_ticks(np.concatenate(self._advance(n, np.ascontiguousarray(hand_W))))
        self._take(ticks)
        return ticks

    def exchange_tool(self, model: str) -> None:
        """Mount another instrument on the follower (docs/session.md#tool-exchange).

        The session then stands at its start and holds, with the present controls and fixtures, until
        `Console.end_tool_exchange`; further ticks go into a new record.

        Args:
            model: model of the arm with the new instrument, such as ``psm_prograsp``, or a model file.

        Raises:
            StateError: the session runs or does not hold, the tool touches something, there is no such instrument, or
                it does not fit; nothing changes.
        """
        from palpate.session import tool_exchange

        self._require_simulated()
        tool_exchange.require_still(self.latest(), self.running)
        tool_exchange.require_free(self.latest())
        scene = tool_exchange.mounted(self.scene, model)
        try:
            rig = build(scene)
        except SceneError as error:
            what = f"{model} does not fit: {error.what}"
            raise StateError(what, where=error.where, why=error.why, mend=error.mend) from None
        self.close()
        console, controls, fixtures, recording = self.console, self.controls, self.fixtures, self.recording
        camera = None if self.camera is None else self.camera.q
        for part in (self.tracking, self.sensing):
            if part is not None:
                part.close()
        Session.__init__(self, scene, self._out, self.seed, self._clouds, rig)
        self.console, self.controls, self.fixtures, self.recording = console, controls, fixtures, recording
        if camera is not None and self.camera is not None:
            self.camera.move_to(camera)

    def _require_simulated(self) -> None:
        if not self.plant.simulated:
            name = ", ".join(self.plant.hardware) or "a loop of your own"
            what = f"the hand is on {name}, which has a time of its own"
            raise StateError(what, mend="use run() or start(), or leave the driver out to simulate the arm")

    def require_own_clock(self) -> None:
        """Refuse what has no time of its own in lockstep: a device, and a tracker that sends poses in real time.

        Raises:
            StateError, PalpateError: there is such a thing; nothing moves.
        """
        self._require_simulated()
        name = self.tracking.needs_realtime if self.tracking is not None else ""
        if name:
            raise PalpateError(
                f"tracker {name!r} sends poses in real time, and a lockstep run has a clock of its own",
                mend="run in real time: palpate run --realtime, or session.run(realtime=True)",
            )

    def _advance(self, n: int, hand_W: Array | None = None) -> list[Rows]:
        """Run `n` ticks, with the hand as in `lead`, in blocks between which what is beside the loop has its turns."""
        done, at = [], 0
        for some in self._turns.blocks(n, self.rate, self, [self]):
            led = () if hand_W is None else (hand_W[at : at + some],)
            done.append(self.simulation.run(some, *led))
            at += some
        return done

    @loop_first()
    def _run_lockstep(self, seconds: float, on_progress: Callable[[State], None] | None) -> None:
        self.require_own_clock()
        n = max(1, round(seconds * self.rate))
        watched = on_progress is not None or self.steps_beside
        batch = max(1, round((BATCH if watched else UNWATCHED_BATCH) * self.rate))
        while n > 0 and not self._interrupted.is_set() and not self._task_over.is_set():
            blocks = self._advance(min(batch, n))
            if not sum(map(len, blocks)):  # paused: simulated time stops
                time.sleep(DRAIN)
                continue
            for rows in blocks:
                n -= len(rows)
                self._take_behind(as_ticks(rows))
            if on_progress is not None:
                on_progress(self.state)

    def _run_realtime(self, seconds: float, on_progress: Callable[[State], None] | None) -> None:
        self.start()
        over = self._end_of_run(seconds)
        try:
            while not (over() or self._interrupted.is_set() or self._task_over.is_set()):
                time.sleep(2 * DRAIN)
                if on_progress is not None:
                    on_progress(self.state)
        finally:
            self.stop()

    def _end_of_run(self, seconds: float) -> Callable[[], bool]:
        """What says whether a run that begins now is over: by its ticks, or by the clock on a device, which may be late
        and have fewer of them; and where the loop has ended by itself."""
        if self.plant.simulated:
            goal = self._taken + max(1, round(seconds * self.rate))
            return lambda: self._taken + self._loop.dropped >= goal or self.failed
        end = time.monotonic() + seconds
        return lambda: time.monotonic() >= end or self.failed

    def _take(self, ticks: Ticks, realtime: bool = False) -> None:
        if self._seen is not None:
            self._seen.take(ticks)
        self.plant.see(ticks)
        super()._take(ticks, realtime)

    def drain(self) -> None:
        """Take the rows of the loop now, and tell the console which buttons of the handle have changed."""
        super().drain()
        self.plant.look()
        if not self.plant.simulated:
            from palpate.session.pedals import press

            source = ", ".join(self.plant.hardware) or "device"
            self._pressed = press(self.console, self._pressed, self.plant.buttons, source)

    def _faults(self) -> list[str]:
        seen = [] if self._seen is None else self._seen.words()
        return [*super()._faults(), *seen, *self.plant.notices()]
