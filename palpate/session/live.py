"""A session in real time: a loop in its own thread, controlled while it runs and recorded."""

from __future__ import annotations

import os
import threading
import weakref
from collections.abc import Iterable, Mapping, Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from palpate import _core, rebuild
from palpate.base.errors import PalpateError, StateError
from palpate.record.ticks import as_ticks
from palpate.scene.guidance.fixture import Fixture
from palpate.scene.guidance.lists import with_unique_names
from palpate.scene.rig import Rig
from palpate.session import execution as plan_execution
from palpate.session import machine
from palpate.session.beside import AttendedLoop
from palpate.session.controls import Controls
from palpate.session.execution import PlanExecution
from palpate.session.state import State
from palpate.session.summary import Summary

if TYPE_CHECKING:
    from palpate.planning.live_world import Neighbour
    from palpate.planning.problem import Problem
    from palpate.planning.result import Plan
    from palpate.scene.guidance.steered import SteeredFixtures
    from palpate.sensing.source import Clouds
    from palpate.session.camera import CameraArm
    from palpate.session.loop import Loop

DRAIN = 0.05
"""Period at which the loop's ring buffer is drained [s]."""


class LiveSession(AttendedLoop):
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

    def __init__(
        self,
        rig: Rig,
        loop: Loop,
        rate: float,
        seed: int,
        out: str | os.PathLike[str] | None = None,
        clouds: Clouds | None = None,
    ) -> None:
        super().__init__(rig, loop, rate, seed, out, clouds)
        self._fixtures = self.scene.guidance
        self._steered: SteeredFixtures | None = None
        self._requests = threading.Lock()  # one thread at a time changes the controls by a request
        self._pump: threading.Thread | None = None
        self._draining = threading.Lock()
        self._interrupted, self._task_over = threading.Event(), threading.Event()

    # -- running ---------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Start running in real time, in separate threads, until `stop`. No effect if it is already running."""
        if self._pump is not None:
            return
        self._begin(realtime=True)
        self._stop_pump.clear()
        if self.world is not None:
            self.world.start()
        self._loop.start()
        rebuild.forbid()
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
        rebuild.allow()
        if self.world is not None:
            self.world.stop()
        self._pump.join()
        self._pump = None
        self.drain()

    def drain(self) -> None:
        """Take the rows of the loop now, as a thread does every `DRAIN`."""
        with self._draining:  # the ring buffer has one reader
            rows = self._loop.drain()
            if len(rows):
                self._take(as_ticks(rows), realtime=True)

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
            why = _how_to_leave(int(tick["status"])) if state == "fault" else ""
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
        latest = weakref.proxy(self).latest
        self.execution = plan_execution.begin(
            self._loop,
            self.rig,
            self.sensing,
            latest,
            plan,
            speed,
            guard,
            problem or self._problem(),
            self._neighbours(),
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
        made = _core.FixtureList(context.tool)
        if fixtures:
            from palpate import _guidance

            made = _guidance.Fixtures([fixture.make(context) for fixture in fixtures], context.tool)
        self._loop.set_fixtures(made)
        self._fixtures, self._steered = fixtures, None

    @property
    def steered(self) -> SteeredFixtures:
        """The fixtures by name: each can be switched, scaled in authority and displaced."""
        if self._steered is None:
            from palpate.scene.guidance.steered import SteeredFixtures

            self._steered = SteeredFixtures(self._fixtures, self.rig.context, self._steer)
        return self._steered

    def _steer(self, sections: tuple[Fixture, ...], core: _core.FixtureList) -> None:
        self._loop.set_fixtures(core)
        self._fixtures = sections

    @property
    def frames(self) -> Mapping[str, _core.Frame]:
        """Frames that carry fixtures, by name; ``frames["camera"].set(X_WC)`` sets the pose of the camera."""
        return self.rig.context.frames

    def why(self) -> str:
        """Explain in words the present guidance force: all contributions, and the terms of the largest."""
        from palpate.scene.guidance.why import OperatorInput, explain_tick

        tick, scene = self.latest(), self.rig.scene
        V_WT = np.r_[scene.mapping.scale * self.rig.arms.X_WL[:3, :3] @ np.asarray(tick["v_LH"]), np.zeros(3)]
        hand = OperatorInput(V_WT, self.controls.guidance, float(np.linalg.norm(tick["F_cell_L"])))
        return explain_tick(self._fixtures, tick, self.rig.context, hand)

    def interrupt(self) -> None:
        """End `run` before its duration is over; its record is complete."""
        self._interrupted.set()

    def finish(self) -> None:
        """End `run` before its duration is over, since its task is done; the run does not count as interrupted."""
        self._task_over.set()

    # -- ending ----------------------------------------------------------------------------------------------------

    def close(self, interrupted: bool = False) -> Summary:
        """Stop, close the record and return the summary. Later ticks go into a new record."""
        self.stop()
        self._loop.stop()  # also of a loop that never started, such as a node that holds its arm
        return self._finish(interrupted)

    def __enter__(self) -> Self:
        """The session itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the session."""
        self.close()

    # -- inside ----------------------------------------------------------------------------------------------------

    def _problem(self) -> Problem | None:
        """The planning problem of the session, where it is not that of its scene alone."""
        return None

    def _neighbours(self) -> Sequence[Neighbour]:
        """The instruments of other pairs, as a plan must avoid them."""
        return ()

    def _require_idle(self) -> None:
        if self._pump is not None:
            raise PalpateError("the session runs in real time already", mend="call stop() first")

    def _keep_draining(self) -> None:
        while not self._stop_pump.wait(DRAIN):
            self.drain()

    def _own_camera(self) -> CameraArm | None:
        """The endoscope arm that this session steers; None if there is none, or if several sessions share it."""
        if self.rig.ecm is None:
            return None
        from palpate.session.camera import CameraArm

        return CameraArm(self.rig.ecm, [self.rig.arms.X_WL], [self])


def _how_to_leave(status: int) -> str:
    from palpate.session.faults import how_to_leave

    return how_to_leave(status)
