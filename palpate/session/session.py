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
from palpate.record.ticks import Ticks, as_ticks
from palpate.scene.live_targets import PERIOD
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.session.backlog import loop_first
from palpate.session.live import DRAIN, LiveSession
from palpate.session.run_folder import require_writable
from palpate.session.state import State
from palpate.session.summary import Summary

if TYPE_CHECKING:
    from palpate.sensing.source import Clouds
    from palpate.session.loop import LockstepLoop, Rows

BATCH = 0.1  # simulated time per batch of ticks in lockstep [s]
UNWATCHED_BATCH = (
    0.25  # the same if nothing acts between batches: the loop then waits less for the recording thread [s]
)


class Session(LiveSession):
    """Runs a scene.

        session = palpate.Session(palpate.Scene.load("scenes/palpation.yaml"), out="runs")
        summary = session.run(10.0)

    Args:
        scene: the scene to run; its values as a dictionary, the path of its file, or the name of a shipped one.
        out: folder for records, in which each run gets its own folder; None: nothing is recorded.
        seed: seed of all random numbers; the scene's when left out.
        clouds: sources of the objects that are clouds of a sensor, by name: a ``CloudSource``, or an iterable of
            arrays (N, 3) [m] in W that is asked at 30 Hz.
        rig: the rig of the scene, if it is built already.

    Raises:
        SceneError, MeshError: the scene cannot run. OutputError: `out` cannot be written.
    """

    def __init__(
        self,
        scene: Scene | dict[str, Any] | str | os.PathLike[str],
        out: str | os.PathLike[str] | None = None,
        seed: int | None = None,
        clouds: Clouds | None = None,
        rig: Rig | None = None,
    ) -> None:
        scene = Scene.of(scene)
        if scene.arms.leader.driver is not None:
            raise PalpateError(
                f"this scene is felt on a device: driver {scene.arms.leader.driver}",
                where=scene.where("arms", "leader", "driver"),
                mend="use palpate.devices.DrivenSession or palpate run, or leave the driver out to simulate the arm",
            )
        if out is not None:
            require_writable(Path(out))
        rig, seed = rig or build(scene), scene.seed if seed is None else seed
        if rig.scene.graspable is not None and not self.paired:
            what = f"the object {rig.scene.graspable.name!r} is handed from one instrument to another, and there is one"
            raise SceneError(what, where=rig.scene.where("graspable"), mend="give the scene a section pairs")
        self._clouds = clouds
        self.simulation = self._simulation(rig, seed)  #: the loop of the session
        self._sim: LockstepLoop = self.simulation
        self._ticks_to_tracking = 0  # of a lockstep run, until the trackers are read
        super().__init__(rig, self._sim, scene.rates.haptic, seed, out, clouds)
        if scene.bodies and not self.paired:
            from palpate.scene import held

            self.world = held.join({"": rig}, [self.simulation])

    def _simulation(self, rig: Rig, seed: int) -> _core.Simulation:
        """The simulation that the session runs."""
        return rig.simulation(seed)

    def attach(self, remote: _core.RemoteEnd | None) -> None:
        """Let the hand feel what this end of a link renders; None: the objects of the session."""
        self.simulation.attach(remote)

    def run(
        self,
        duration: float | None = None,
        realtime: bool = False,
        on_progress: Callable[[State], None] | None = None,
    ) -> Summary:
        """Run for a duration, then close the record.

        Args:
            duration: simulated time [s]; the scene's when left out.
            realtime: True: in real time, in a C++ thread; False: in lockstep, as fast as possible.
            on_progress: called with the state about ten times per second of simulated time (lockstep) or real time.

        Returns:
            The summary of all ticks since the record began. Ctrl-C ends the run early, which the summary reports.
        """
        self._require_idle()
        n = max(1, round((self.scene.duration if duration is None else duration) * self.rate))
        with stop_signals.deferred(self._interrupted):
            try:
                (self._run_realtime if realtime else self._run_lockstep)(n, on_progress)
            except BaseException:
                self.close(interrupted=True)  # the record is complete after any exception
                raise
            return self.close(interrupted=self._interrupted.is_set())

    def step(self, n: int = 1) -> State:
        """Run `n` ticks in lockstep and return the newest; the record stays open."""
        self._require_idle()
        self._require_own_clock()
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
        self._require_own_clock()
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

    def _require_own_clock(self) -> None:
        name = self.tracking.needs_realtime if self.tracking is not None else ""
        if name:
            raise PalpateError(
                f"tracker {name!r} sends poses in real time, and a lockstep run has a clock of its own",
                mend="run in real time: palpate run --realtime, or session.run(realtime=True)",
            )

    def _advance(self, n: int, hand_W: Array | None = None) -> list[Rows]:
        """Run `n` ticks, with the hand as in `lead`, in blocks between which what is beside the loop has its turns."""
        beside = self.tracking is not None or self.sensing is not None or self.camera is not None
        if not beside and not self.takes_snapshots and not self.executes and not self.steps_beside:
            return [self._sim.run(n) if hand_W is None else self.simulation.run(n, hand_W)]
        size, done, at = max(1, round(PERIOD * self.rate)), [], 0
        while n > 0:
            if self._ticks_to_tracking == 0:
                for part in (self.tracking, self.sensing):
                    if part is not None:
                        part.step(float(self.latest()["t"]))
                for step in self.steps_beside:
                    step(float(self.latest()["t"]))
                self._steer_camera()
                self.take_snapshot()
                self.look_ahead()
                self._ticks_to_tracking = size
            next_turn = float(self.latest()["t"]) + self._ticks_to_tracking / self.rate
            idle = min(self.idle_periods(next_turn, size / self.rate), n)  # those that need no turn
            some = min(self._ticks_to_tracking + size * int(idle), n)
            led = None if hand_W is None else hand_W[at : at + some]
            done.append(self._sim.run(some) if led is None else self.simulation.run(some, led))
            n, at, self._ticks_to_tracking = n - some, at + some, (self._ticks_to_tracking - some) % size
        return done

    @loop_first()
    def _run_lockstep(self, n: int, on_progress: Callable[[State], None] | None) -> None:
        self._require_own_clock()
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

    def _run_realtime(self, n: int, on_progress: Callable[[State], None] | None) -> None:
        self.start()
        goal = self._taken + n
        try:
            while self._taken + self._sim.dropped < goal and not (
                self._interrupted.is_set() or self._task_over.is_set()
            ):
                time.sleep(2 * DRAIN)
                if on_progress is not None:
                    on_progress(self.state)
        finally:
            self.stop()
