"""What runs beside a loop: tracked frames, sensors, the endoscope, snapshots, and the watch over a planned motion."""

from __future__ import annotations

import math
import os
import threading
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from palpate.base.arrays import Array
from palpate.record import snapshots
from palpate.record.ticks import Ticks, as_tick
from palpate.scene.live_targets import PERIOD, SharedTargets
from palpate.scene.rig import Rig
from palpate.session import execution as plan_execution
from palpate.session.console import Console
from palpate.session.execution import PlanExecution
from palpate.session.recording import RecordedLoop

if TYPE_CHECKING:
    from palpate.sensing.sensing import Sensing
    from palpate.sensing.source import Clouds
    from palpate.sensing.trackers.tracking import Tracking
    from palpate.session.camera import CameraArm
    from palpate.session.loop import Loop
    from palpate.world.bodies.engine import World


class AttendedLoop(RecordedLoop):
    """A recorded loop with the work beside it; arguments and errors as those of `Session`."""

    def __init__(
        self,
        rig: Rig,
        loop: Loop,
        rate: float,
        seed: int,
        out: str | os.PathLike[str] | None,
        clouds: Clouds | None,
    ) -> None:
        super().__init__(rig, loop, rate, seed, out)
        self._stop_pump = threading.Event()
        self.console = Console([weakref.proxy(self)])  #: pedals, presence, locks and scale
        self.console.on_change(partial(_accept_moved_tools, weakref.ref(self)))
        self.camera = self._own_camera()  #: the endoscope arm of the scene; None if the scene has none
        targets = SharedTargets(rig, loop)
        self.tracking = _tracking(rig, loop, targets)  #: moves the tracked frames
        if self.tracking is not None:
            weakref.finalize(self, self.tracking.close)
        self.sensing = _sensing(rig, loop, clouds, targets)  #: turns the frames of sensors into surfaces
        if self.sensing is not None:
            weakref.finalize(self, self.sensing.close)
            if self.scene.record.sensors:
                me = weakref.proxy(self)
                self.sensing.keep = lambda *frame: me.take_cloud(*frame)
        self.execution: PlanExecution | None = None  #: the newest plan that moves, or moved, the follower
        self.steps_beside: list[Callable[[float], None]] = []  #: called with the time [s], every `PERIOD`
        self.task_words: Callable[[], str] | None = None  #: how a task stands, for viewers; None: there is none
        self.world: World | None = None  #: the rigid bodies of the scene among the tools; None: it has none
        self._beside: list[threading.Thread] = []  # work beside the loop, in the order in which it ends

    def nearest(self, tick: Ticks) -> str:
        """What is nearest to a tool that touches nothing, how far, and where the hand must move; otherwise empty."""
        from palpate.session import nearest

        return nearest.in_words(self.rig, tick, None if self.sensing is None else self.sensing.surfaces)

    @property
    def camera_arm(self) -> CameraArm | None:
        """The endoscope arm, also one that several sessions share; None if the scene has none."""
        return self.camera

    def _own_camera(self) -> CameraArm | None:
        """The endoscope arm that this loop steers; none by itself."""
        return None

    def _camera_joints(self) -> Array | None:
        return None if self.camera_arm is None else self.camera_arm.q

    def _body_places(self) -> Mapping[str, Array]:
        return {} if self.world is None else self.world.drawn()

    @property
    def pedal_camera(self) -> bool:
        """True while the camera pedal of this hand is pressed."""
        return bool(self._loop.controls.camera)

    def idle_periods(self, t: float, period: float) -> float:
        """Number of periods from a time on [s] at whose begin nothing beside a lockstep loop has work."""
        steered = self.camera is not None and (self.pedal_camera or not self.camera.at_rest)
        if self.tracking is not None or self.sensing is not None or self.steps_beside or self.executes or steered:
            return 0.0
        return self._snapshots.idle_periods(t, period) if self.takes_snapshots else math.inf

    def _work_beside(self) -> list[threading.Thread]:
        """Start what runs beside the loop; the loop stops objects without targets or frames by itself."""
        from palpate.session.periodic import every

        found, tracking, sensing = [], self.tracking, self.sensing
        if tracking is not None:
            step, last = partial(self._timed, tracking.step), partial(self._timed, tracking.hold)
            found.append(every(PERIOD, step, self._stop_pump, "tracking", self._note, last))
        for one in self.steps_beside:
            found.append(every(PERIOD, partial(self._timed, one), self._stop_pump, "task", self._note))
        if self.camera is not None:
            found.append(every(PERIOD, self.steer_camera, self._stop_pump, "camera", self._note))
        if self.takes_snapshots:
            step = partial(self._timed, self._take_snapshot)
            found.append(every(1.0 / snapshots.RATE, step, self._stop_pump, "snapshots", self._note))
        if sensing is not None:
            from palpate.sensing import sensing as sensing_module

            step = partial(self._timed, sensing.step)
            found.append(every(sensing_module.PERIOD, step, self._stop_pump, "sensing", self._note, sensing.hold))
        if self.executes:
            found.append(self._watch_execution())
        return found

    def _watch_execution(self) -> threading.Thread:
        from palpate.session.periodic import every

        return every(plan_execution.PERIOD, self.look_ahead, self._stop_pump, "execution", self._note)

    @property
    def executes(self) -> bool:
        """True while a plan moves the follower."""
        return self.execution is not None and not self.execution.over

    def look_ahead(self) -> None:
        """Let the execution of a plan look at the world ahead."""
        if self.execution is not None and not self.execution.over:
            self.execution.look()

    def _timed(self, step: Callable[[float], object]) -> None:
        step(float(self.latest()["t"]))

    def _faults(self) -> list[str]:
        """Also sources that never spoke, and an engine that stood still: nothing else says why there is no force."""
        t = float(self.latest()["t"])
        parts = [part for part in (self.tracking, self.sensing) if part is not None]
        engine = [] if self.world is None else self.world.faults()
        return [*super()._faults(), *(words for part in parts for words in part.silent(t)), *engine]

    def _note(self, words: str) -> None:
        self.notes.append(words)

    def steer_camera(self) -> None:
        """Let the hand move the camera for one `PERIOD` while the camera pedal is pressed."""
        if self.camera is not None:
            self.camera.steer([self.latest()], PERIOD)


def _accept_moved_tools(session: weakref.ref[Any], pedal: str, down: bool) -> None:
    """The pedal coag, pressed while the clutch is down, accepts tracked tools that were moved on purpose."""
    one = session()
    if pedal == "coag" and down and one is not None and one.tracking is not None and one.console.pedals["clutch"]:
        one.tracking.accept_jumps()


def _tracking(rig: Rig, loop: Loop, targets: SharedTargets) -> Tracking | None:
    """The trackers of a rig; None if its scene has none."""
    if not rig.scene.trackers:
        return None
    from palpate.sensing.trackers.tracking import Tracking

    return Tracking(rig, loop, targets=targets)


def _sensing(rig: Rig, loop: Loop, clouds: Clouds | None, targets: SharedTargets) -> Sensing | None:
    """The sensing of a rig: sources as given, and for other sensors those of the scene's section `sensors`."""
    objects = [obj for obj in rig.scene.objects if obj.cloud is not None and obj.cloud.sensor is not None]
    if not objects and not clouds:
        return None
    from palpate.sensing.make import make
    from palpate.sensing.sensing import Sensing
    from palpate.sensing.source import as_sources

    sources = as_sources(clouds)
    for obj in objects:
        name = "" if obj.cloud is None else obj.cloud.sensor or ""
        if name in rig.scene.sensors and not {name, obj.name} & set(sources):
            sources[name] = make(rig, name, lambda: as_tick(loop.latest()))
    return Sensing(rig, loop, sources, targets=targets)


class LockstepRun(Protocol):
    """What advances in lockstep: one session, or those of several pairs."""

    steps_beside: list[Callable[[float], None]]
    """Called with the time [s] at each turn."""

    @property
    def camera(self) -> CameraArm | None:
        """The endoscope arm that the hands steer."""
        ...

    def steer_camera(self) -> None:
        """Let the hands move the camera for one `PERIOD`."""
        ...


class Turns:
    """Cuts a run in lockstep into blocks, and gives what is beside the loop its turn every `PERIOD`."""

    def __init__(self) -> None:
        self._left = 0  # ticks until the next turn

    def blocks(self, n: int, rate: float, run: LockstepRun, hands: Sequence[AttendedLoop]) -> Iterator[int]:
        """The next `n` ticks as numbers of ticks, each to be run before the next one is asked for.

        Args:
            n: number of ticks.
            rate: ticks per second [Hz].
            run: what advances.
            hands: its sessions.
        """
        beside = [part for hand in hands for part in (hand.tracking, hand.sensing) if part is not None]
        attended = any(hand.takes_snapshots or hand.executes for hand in hands)
        if not beside and run.camera is None and not attended and not run.steps_beside:
            yield n
            return
        size = max(1, round(PERIOD * rate))
        while n > 0:
            if self._left == 0:
                for step in (*(part.step for part in beside), *run.steps_beside):
                    step(float(hands[0].latest()["t"]))
                run.steer_camera()
                for hand in hands:
                    hand.take_snapshot()
                    hand.look_ahead()
                self._left = size
            t = float(hands[0].latest()["t"])
            some = min(self._left + size * _idle(t + self._left / rate, size / rate, n, run, hands), n)
            yield some
            n, self._left = n - some, (self._left - some) % size


def _idle(t: float, period: float, most: int, run: LockstepRun, hands: Sequence[AttendedLoop]) -> int:
    """Number of periods from a time on [s], up to `most`, at whose begin nothing beside the loop has work."""
    camera = run.camera
    steered = camera is not None and (any(hand.pedal_camera for hand in hands) or not camera.at_rest)
    return 0 if run.steps_beside or steered else int(min(most, *(hand.idle_periods(t, period) for hand in hands)))
