"""A session in real time: a loop in its own thread, controlled while it runs and recorded."""

from __future__ import annotations

import os
import threading
import time
import weakref
from collections.abc import Callable, Iterable, Mapping
from datetime import datetime, timedelta
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.errors import PalpateError, StateError
from palpate.guidance.fixture import Fixture
from palpate.guidance.lists import with_unique_names
from palpate.guidance.steered import SteeredFixtures
from palpate.record import snapshots
from palpate.record.ticks import Ticks, Timing, as_ticks
from palpate.record.writer import Recorder
from palpate.scene.rig import Rig
from palpate.sensing import sensing as sensing_module
from palpate.sensing.source import Clouds, as_sources
from palpate.session import execution as plan_execution
from palpate.session import machine
from palpate.session.camera import CameraArm
from palpate.session.console import Console
from palpate.session.controls import Controls
from palpate.session.execution import PlanExecution
from palpate.session.faults import how_to_leave
from palpate.session.loop import Loop
from palpate.session.periodic import every
from palpate.session.recorded_frames import RecordedFrames
from palpate.session.run_folder import keep_scene, new_folder, require_writable
from palpate.session.snapshots import Snapshots
from palpate.session.state import State
from palpate.session.summary import Summary, Totals
from palpate.trackers.tracking import PERIOD, Tracking

if TYPE_CHECKING:
    from palpate.planning.problem import Problem
    from palpate.planning.result import Plan

DRAIN = 0.05
"""Period at which the loop's ring buffer is drained [s]."""


class LiveSession:
    """A loop that runs in real time, with its record: the base of `palpate.Session` and of sessions on ROS 2.

    Args:
        rig: the rig of the scene, from which `loop` is made.
        loop: the loop to run.
        rate: ticks of the loop per second [Hz].
        seed: seed of all random numbers in the loop, stored in the record.
        out: folder for records, in which each run gets its own folder; None: nothing is recorded.
        clouds: sources of the objects that are clouds of a sensor, by the name of the sensor or of the object.

    Raises:
        OutputError: `out` cannot be written. SceneError: an object has no source.
    """

    paired = False
    """True if the record holds the signals of contact with other pairs."""

    def __init__(
        self,
        rig: Rig,
        loop: Loop,
        rate: float,
        seed: int,
        out: str | os.PathLike[str] | None = None,
        clouds: Clouds | None = None,
    ) -> None:
        self.scene, self.rig, self.seed = rig.scene, rig, seed
        self.rate = rate  #: ticks per second [Hz]
        self._out = Path(out) if out is not None else None
        if self._out is not None:
            require_writable(self._out)
        self._loop = loop
        self._fixtures = self.scene.guidance
        weakref.finalize(self, loop.stop)  # ramps the force to zero when the session is collected or Python ends
        self._recorder: Recorder | None = None
        self._steered: SteeredFixtures | None = None
        self._closed = True
        self._totals = Totals(self.rate)
        self._live = False
        self._began = 0.0
        self._dropped = 0
        self._taken = 0  # ticks of all records
        self._lock = threading.RLock()  # only one thread at a time writes to the recorder
        self.console = Console([weakref.proxy(self)])  #: pedals, presence, locks and scale
        self.camera = self._own_camera()  #: the endoscope arm of the scene; None if the scene has none
        self._requests = threading.Lock()  # one thread at a time changes the controls by a request
        self._pump: threading.Thread | None = None
        self._stop_pump = threading.Event()
        self._interrupted = threading.Event()
        self.recording = self._out is not None  #: False: no new record is begun after the present one
        self.record: Path | None = None  #: file of the newest record
        self.tracking = Tracking(rig, loop) if rig.scene.trackers else None  #: moves the tracked frames
        if self.tracking is not None:
            weakref.finalize(self, self.tracking.close)
        self.sensing = _sensing(rig, loop, clouds)  #: turns the frames of sensors into surfaces
        if self.sensing is not None:
            weakref.finalize(self, self.sensing.close)
        me = weakref.proxy(self)  # what the session holds must not hold the session: it ends when it is collected
        self._snapshots = Snapshots(rig, lambda index: me.soft_vertices(index), lambda: me._camera_joints())
        self.execution: PlanExecution | None = None  #: the newest plan that moves, or moved, the follower
        self._beside: list[threading.Thread] = []  # work beside the loop, in the order in which it ends
        self.notes: list[str] = []  #: problems outside of the loop, e.g. a full disk

    # -- running ---------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Start running in real time, in separate threads, until `stop`. No effect if it is already running."""
        if self._pump is not None:
            return
        self._begin(realtime=True)
        self._stop_pump.clear()
        self._loop.start()
        self._pump = threading.Thread(target=self._keep_draining, name="palpate-drain", daemon=True)
        self._pump.start()
        self._beside = self._work_beside()

    def stop(self) -> None:
        """Stop the real-time run with the force at zero. No effect if it is not running."""
        if self._pump is None:
            return
        self._stop_pump.set()
        for thread in self._beside:
            thread.join()  # objects rest before the loop stops
        self._beside = []
        self._loop.stop()
        self._pump.join()
        self._pump = None
        self._drain()

    # -- observation and control ------------------------------------------------------------------------------------

    @property
    def running(self) -> bool:
        """True while the session runs in real time."""
        return self._pump is not None

    @property
    def state(self) -> State:
        """State of the newest tick."""
        tick = self.latest()
        return State(tick, self.rig.path.phase(float(tick["t"])))

    def latest(self) -> Ticks:
        """The newest tick as one row of `TICK`; never waits for the loop."""
        tick: Ticks = as_ticks(self._loop.latest().reshape(1, -1))[0]
        return tick

    def soft_vertices(self, index: int) -> Array:
        """Deformed surface of a soft object, at most 16 ms old; never waits for the loop.

        Args:
            index: number of the object in the scene.

        Returns:
            Vertices (n, 3) in the object's frame O [m], in the order of ``_core.TissueSurface.vertices``.

        Raises:
            ValueError: the object does not exist or is not soft.
        """
        return self._loop.soft_vertices(index)

    @property
    def controls(self) -> Controls:
        """Clutch, pause, stiffness and damping scales, drag of the hand. This is a copy: assign it as a whole."""
        return Controls(self._loop.controls)

    @controls.setter
    def controls(self, value: _core.Controls) -> None:
        self._loop.controls = value

    def change(self, **values: Any) -> None:
        """Assign some controls, e.g. ``session.change(clutch=True)``, and leave the others as they are.

        Raises:
            PalpateError: there is no such control, or the value has another type.
        """
        with self._requests:
            controls = self.controls
            for name, value in values.items():
                setattr(controls, name, value)
            self.controls = controls

    def request(self, request: str) -> None:
        """Ask for a change of the session's state, e.g. ``follow``, ``clutch`` or ``hold`` (docs/session.md).

        The loop takes it with its next tick; a session that does not run takes it when it runs.

        Raises:
            StateError: the request is unknown, or has no effect in the present state; the message says what has.
        """
        with self._requests:
            tick = self.latest()
            state = machine.name_of(float(tick["session_state"]))
            why = how_to_leave(int(tick["status"])) if state == "fault" else ""
            machine.require(state, request, why)
            controls = self._loop.controls
            machine.apply(controls, request)
            self._loop.controls = controls

    def execute(
        self, plan: Plan, speed: float = 1.0, guard: float = plan_execution.GUARD, problem: Problem | None = None
    ) -> PlanExecution:
        """Let a plan move the follower (docs/planning-execution.md); afterwards the hand takes over, as after a clutch.

        Args:
            plan: the plan; it begins where the follower is, and must be free in the scene as it is now.
            speed: pace, 1: as planned; 0 < speed <= 1.
            guard: contact force on the tool that stops the motion [N].
            problem: the planning problem of the scene, if there is one already.

        Raises:
            PlanningError: the plan begins elsewhere, belongs to another arm, or is not free any more; nothing moves.
            StateError: the session is in a state without plans, a plan is under way, or its follower takes none.
        """
        if self.execution is not None and not self.execution.over and self.execution.phase != "waiting":
            raise StateError("another plan moves the follower", mend="session.execution.stop()")
        self.execution = plan_execution.begin(
            self._loop, self.rig, self.sensing, weakref.proxy(self).latest, plan, speed, guard, problem
        )
        if self._pump is not None:
            self._beside.append(self._watch_execution())
        return self.execution

    @property
    def fixtures(self) -> tuple[Fixture, ...]:
        """Virtual fixtures in use. They can be replaced in a running session; the force on the hand is continuous."""
        return self._fixtures

    @fixtures.setter
    def fixtures(self, value: Iterable[Fixture]) -> None:
        fixtures = with_unique_names(tuple(value))
        context = self.rig.context
        self._loop.set_fixtures(_core.Fixtures([fixture.make(context) for fixture in fixtures], context.tool))
        self._fixtures, self._steered = fixtures, None

    @property
    def steered(self) -> SteeredFixtures:
        """The fixtures by name: each can be switched, scaled in authority and displaced."""
        if self._steered is None:
            self._steered = SteeredFixtures(self._fixtures, self.rig.context, self._steer)
        return self._steered

    def _steer(self, sections: tuple[Fixture, ...], core: _core.Fixtures) -> None:
        self._loop.set_fixtures(core)
        self._fixtures = sections

    @property
    def frames(self) -> Mapping[str, _core.Frame]:
        """Frames that carry fixtures, by name; ``frames["camera"].set(X_WC)`` sets the pose of the camera."""
        return self.rig.context.frames

    def why(self) -> str:
        """Explain in words the present guidance force: all contributions, and the terms of the largest."""
        from palpate.guidance.why import OperatorInput, explain_tick

        tick, scene = self.latest(), self.rig.scene
        V_WT = np.r_[scene.mapping.scale * self.rig.arms.X_WL[:3, :3] @ np.asarray(tick["v_LH"]), np.zeros(3)]
        hand = OperatorInput(V_WT, self.controls.guidance, float(np.linalg.norm(tick["F_cell_L"])))
        return explain_tick(self._fixtures, tick, self.rig.context, hand)

    @property
    def timing(self) -> Timing:
        """Compute time, lateness, slack and missed ticks of the loop (`Simulation.timing`)."""
        return self._loop.timing()

    def set_recording(self, on: bool) -> None:
        """End the present record, also while the session runs; True begins a new one with the next tick."""
        with self._lock:
            if self._recorder is not None and not self._closed:
                self._recorder.close(self._faults(), self.timing)
            self.recording, self._closed = on, True

    def interrupt(self) -> None:
        """End `run` before its duration is over; its record is complete."""
        self._interrupted.set()

    # -- ending ----------------------------------------------------------------------------------------------------

    def close(self, interrupted: bool = False) -> Summary:
        """Stop, close the record and return the summary. Later ticks go into a new record."""
        self.stop()
        with self._lock:
            faults = self._faults()
            timing = self.timing
            sha256 = None
            if self._recorder is not None and not self._closed:
                self._recorder.close(faults, timing)
                if self._recorder.failure and self._recorder.failure not in self.notes:
                    self.notes.append(self._recorder.failure)
                sha256 = self._recorder.sha256
            took = time.perf_counter() - self._began if not self._closed else 0.0
            summary = self._totals.summary(
                timing,
                instrument=Path(self.scene.arms.follower.model).stem,
                realtime=self._live,
                realtime_factor=round(self._totals.ticks / self.rate / took, 3) if took > 0 else 0.0,
                interrupted=interrupted,
                faults=(*faults, *self.notes),
                record=str(self.record) if self.record else None,
                record_sha256=sha256,
            )
            self._closed = True
            return summary

    def __enter__(self) -> Self:
        """The session itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the session."""
        self.close()

    # -- inside ----------------------------------------------------------------------------------------------------

    def _require_idle(self) -> None:
        if self._pump is not None:
            raise PalpateError("the session runs in real time already", mend="call stop() first")

    def _keep_draining(self) -> None:
        while not self._stop_pump.wait(DRAIN):
            self._drain()

    def _own_camera(self) -> CameraArm | None:
        """The endoscope arm that this session steers; None if there is none, or if several sessions share it."""
        return None if self.rig.ecm is None else CameraArm(self.rig.ecm, [self.rig.arms.X_WL], [self])

    def _work_beside(self) -> list[threading.Thread]:
        """Start what runs beside the loop; the loop stops objects without targets or frames by itself."""
        found, tracking, sensing = [], self.tracking, self.sensing
        if tracking is not None:
            step, last = partial(self._timed, tracking.step), partial(self._timed, tracking.hold)
            found.append(every(PERIOD, step, self._stop_pump, "tracking", self._note, last))
        if self.camera is not None:
            found.append(every(PERIOD, self._steer_camera, self._stop_pump, "camera", self._note))
        if self.takes_snapshots:
            step = partial(self._timed, self._take_snapshot)
            found.append(every(1.0 / snapshots.RATE, step, self._stop_pump, "snapshots", self._note))
        if sensing is not None:
            step = partial(self._timed, sensing.step)
            found.append(every(sensing_module.PERIOD, step, self._stop_pump, "sensing", self._note, sensing.hold))
        if self.execution is not None and not self.execution.over:
            found.append(self._watch_execution())
        return found

    @property
    def takes_snapshots(self) -> bool:
        """True if the record needs snapshots of soft objects or of the camera."""
        return self._out is not None and self.recording and self.scene.record.frames and self._snapshots.needed

    def take_snapshot(self) -> None:
        """Take a snapshot of the newest tick, if one is due."""
        if self.takes_snapshots:
            self._timed(self._take_snapshot)

    def _take_snapshot(self, t: float) -> None:
        self._snapshots.take(t)

    @property
    def camera_arm(self) -> CameraArm | None:
        """The endoscope arm, also one that several sessions share; None if the scene has none."""
        return self.camera

    def _camera_joints(self) -> Array | None:
        return None if self.camera_arm is None else self.camera_arm.q

    def _watch_execution(self) -> threading.Thread:
        return every(plan_execution.PERIOD, self._look_ahead, self._stop_pump, "execution", self._note)

    def _look_ahead(self) -> None:
        """Let the execution of a plan look at the world ahead."""
        if self.execution is not None and not self.execution.over:
            self.execution.look()

    def _timed(self, step: Callable[[float], object]) -> None:
        step(float(self.latest()["t"]))

    def _note(self, words: str) -> None:
        self.notes.append(words)

    def _steer_camera(self) -> None:
        """Let the hand move the camera for one `PERIOD` while the camera pedal is pressed."""
        if self.camera is not None:
            self.camera.steer([self.latest()], PERIOD)

    def _drain(self) -> None:
        rows = self._loop.drain()
        if len(rows):
            self._take(as_ticks(rows), realtime=True)

    def _take(self, ticks: Ticks, realtime: bool = False) -> None:
        with self._lock:
            self._begin(realtime)
            self._totals.add(ticks)
            self._taken += len(ticks)
            if self._recorder is not None:
                self._recorder.append(ticks, self._snapshots.collect())
                if self._recorder.failure and self._recorder.failure not in self.notes:
                    self.notes.append(self._recorder.failure)

    def _begin(self, realtime: bool) -> None:
        with self._lock:
            if not self._closed:
                return
            self._closed = False
            self._totals = Totals(self.rate)
            self._live = realtime
            self._began = time.perf_counter()
            self._dropped = self._loop.dropped
            self.notes = []
            self._recorder, self.record = None, None
            if self._out is not None and self.recording:
                folder = self._new_folder()
                self.record = folder / "record.mcap"
                self.notes += keep_scene(folder, self.rig.resolved_yaml(absolute=True))
                now = datetime.now().astimezone()
                self._recorder = Recorder(
                    self.record,
                    self.rig.resolved_yaml(),
                    self.seed,
                    self.rate,
                    not realtime,
                    bag=True,
                    started=now - timedelta(seconds=float(self.latest()["t"])),
                    every=self.scene.record.every(self.rate),
                    tracked=self.tracking is not None,
                    paired=self.paired,
                    extra=RecordedFrames(self.rig) if self.scene.record.frames else None,
                )

    def _new_folder(self) -> Path:
        """Make the folder of a run."""
        assert self._out is not None
        return new_folder(self._out, self.scene.title)

    def _faults(self) -> list[str]:
        fault = self._loop.fault()
        lost = self._loop.dropped - self._dropped
        faults = [fault] if fault else []
        return [*faults, f"{lost} ticks are missing in the record: the disk was too slow"] if lost > 0 else faults


def _sensing(rig: Rig, loop: Loop, clouds: Clouds | None) -> sensing_module.Sensing | None:
    """The sensing of a rig: sources as given, and for other sensors those of the scene's section `sensors`."""
    from palpate.sensing.make import make

    objects = [obj for obj in rig.scene.objects if obj.cloud is not None and obj.cloud.sensor is not None]
    sources = as_sources(clouds)
    for obj in objects:
        name = "" if obj.cloud is None else obj.cloud.sensor or ""
        if name in rig.scene.sensors and not {name, obj.name} & set(sources):
            sources[name] = make(rig, name, lambda: as_ticks(np.asarray(loop.latest()).reshape(1, -1))[0])
    return sensing_module.Sensing(rig, loop, sources) if objects or clouds else None
