"""A session of several pairs in one scene: one loop, record and ledger a pair."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from palpate import _core
from palpate.base import stop_signals
from palpate.base.errors import PalpateError, PlanningError, SceneError, StateError
from palpate.record.ticks import Ticks, as_ticks
from palpate.scene import held
from palpate.scene.live_targets import PERIOD
from palpate.scene.scene import Scene
from palpate.scene.together import capsules, join_instruments
from palpate.session import tool_exchange
from palpate.session.backlog import loop_first
from palpate.session.beside import Turns
from palpate.session.camera import CameraArm
from palpate.session.controls import Controls
from palpate.session.execution import GUARD, PlanExecution
from palpate.session.live import DRAIN
from palpate.session.operator_seat import OperatorSeat
from palpate.session.pair import PairSession
from palpate.session.pair_plants import opened, rigs_of
from palpate.session.pairs_summary import Met, PairsSummary, meeting
from palpate.session.periodic import every
from palpate.session.plants import Plant
from palpate.session.run_folder import keep_scene, new_folder, require_writable
from palpate.session.session import BATCH, UNWATCHED_BATCH
from palpate.session.state import State
from palpate.session.summary import Summary
from palpate.session.swap import swapped

if TYPE_CHECKING:
    from palpate.planning.result import Plan

States = Mapping[str, State]
"""State of each pair at its newest tick, by name."""

_GRACE = 2.0  # real time after the end of a run in which late pairs may still finish [s]


class PairsSession:
    """Runs the pairs of a scene: those with a driver are felt on their devices, the others are simulated.

        session = palpate.PairsSession(palpate.Scene.load("scenes/two_hands.yaml"), out="runs")
        summary = session.run(5.0)
        summary.pairs["left"].peak_force_N

    In lockstep all pairs advance tick by tick in one thread. In real time each pair has its own loop, thread, watchdog
    and record, and no pair waits for another: a pair that stalls leaves its instrument where it was last seen. Each
    device runs at its own rate, with a watchdog of its own, and in real time alone. One that fails ends its pair with
    zero force; its instrument then rests where it was, and the other pairs go on.

    Args:
        scene: a scene with the section `pairs`.
        out: folder for records, in which each run gets a folder with one record per pair; None: nothing is recorded.
        seed: seed of all random numbers; the scene's when left out. The hands have different tremors.
        plants: where the hands of some pairs are, by name, such as a `palpate.ros.plant.CrtkPlant`; the scene names
            those of the others.
        only: names of the pairs to run; all when left out. The instruments of the others are not known here.

    Raises:
        SceneError, MeshError: the scene cannot run. OutputError: `out` cannot be written. DeviceError: a driver is
        missing, invalid or not trusted; two pairs have the same device or the same grip.
    """

    def __init__(
        self,
        scene: Scene | dict[str, Any] | str | os.PathLike[str],
        out: str | os.PathLike[str] | None = None,
        seed: int | None = None,
        plants: Mapping[str, Plant] | None = None,
        only: Sequence[str] = (),
    ) -> None:
        scene = Scene.of(scene)
        self.scene, self.seed = scene, scene.seed if seed is None else seed
        self._out = None if out is None else Path(out)
        if self._out is not None:
            require_writable(self._out)
        self.folder: Path | None = None  #: folder of the newest run
        self._plants = opened(scene, plants, only)
        self.rigs = rigs_of(scene, self._plants)
        self._seat = OperatorSeat(self._exchange)
        self.console = self._seat.console  #: pedals, presence, locks and scale for the hands of all pairs
        self._sit()
        self._turns = Turns()
        self.task_words: Callable[[], str] | None = None  #: how a task stands, for viewers; None: there is none
        self.steps_beside: list[Callable[[float], None]] = []  #: called with the time [s], every `PERIOD`
        self._task_over, self._stop_steps = threading.Event(), threading.Event()
        self._steppers: list[threading.Thread] = []

    def finish(self) -> None:
        """End `run` before its duration is over, since its task is done; the run does not count as interrupted."""
        self._task_over.set()

    def _sit(self) -> None:
        """Make the sessions of all pairs; those that are made end again if one cannot be, or they cannot be joined."""
        self._pairs: dict[str, PairSession] = {}
        try:
            for i, (name, rig) in enumerate(self.rigs.items()):
                seed = (self.seed + i) % 2**64
                self._pairs[name] = PairSession(name, self._plants[name], rig, seed, self._out, self)
            self._join()
        except BaseException:
            for session in self._pairs.values():
                session.close(interrupted=True)
            raise

    @property
    def pairs(self) -> Mapping[str, PairSession]:
        """Session of each pair by name; `remove` takes one out."""
        return MappingProxyType(self._pairs)

    def remove(self, name: str) -> None:
        """Take a pair out of a session that does not run; its record is closed.

        Raises:
            PalpateError: the session runs, there is no such pair, or it is the last.
        """
        if name not in self._pairs:
            raise PalpateError(f"there is no pair {name!r}", mend=f"the pairs are {', '.join(self._pairs)}")
        if self.running:
            why = "its instrument would vanish from the hands of the others"
            raise PalpateError(f"pair {name!r} cannot be removed while it runs", why=why, mend="call stop() first")
        if len(self._pairs) == 1:
            raise PalpateError(f"{name!r} is the last pair of the session", mend="close the session")
        self._pairs.pop(name).close()
        self.rigs.pop(name)
        self._join()

    def _join(self) -> None:
        """Put the instruments of all pairs into one world, and all hands at one console."""
        plants = [session.plant for session in self._pairs.values()]
        joined = [plant.joined for plant in plants]
        self._loops = [one for one in joined if isinstance(one, _core.Simulation)]  #: of the simulated pairs
        law = self.scene.instruments
        rod = _core.RodOptions() if self.scene.graspable is None else self.scene.graspable.core()
        tools = [capsules(rig) for rig in self.rigs.values()]
        join_instruments(joined, tools, law.stiffness, law.damping, rod)
        lag, rate = max(plant.lag for plant in plants), min(plant.scene.rates.haptic for plant in plants)
        self.world = held.join(self.rigs, joined, lag, rate)  #: the rigid bodies of the scene; None: it has none
        self._seat.take(list(self._pairs.values()))

    def _exchange(self) -> None:
        """Exchange the leaders of both pairs; the pairs begin anew at their start, with the present controls.

        Raises:
            StateError: the session runs, has not two pairs, or an arm does not fit; nothing changes.
        """
        if self.running:
            mend = "call stop() first, then console.swap() and start()"
            raise StateError("the followers cannot be exchanged while the session runs", mend=mend)
        self._require_simulated("followers cannot be exchanged in a session")
        self._begin_anew(lambda: swapped(self.scene), "the hands do not fit each other's followers")

    def exchange_tool(self, model: str, pair: str) -> None:
        """Mount another instrument on the follower of a pair (docs/session.md#tool-exchange).

        The pairs then stand at their start and hold, with the present controls, until `Console.end_tool_exchange`;
        further ticks go into new records.

        Args:
            model: model of the arm with the new instrument, such as ``psm_prograsp``, or a model file.
            pair: name of the pair.

        Raises:
            StateError: the session runs or does not hold, the tool touches something, there is no such instrument, or
                it does not fit; nothing changes. PalpateError: there is no such pair.
        """
        if pair not in self._pairs:
            raise PalpateError(f"there is no pair {pair!r}", mend=f"the pairs are {', '.join(self._pairs)}")
        self._require_simulated("instruments cannot be exchanged in a session")
        for name, session in self._pairs.items():
            tool_exchange.require_still(session.latest(), self.running, name)
        tool_exchange.require_free(self._pairs[pair].latest(), pair)
        self._begin_anew(lambda: tool_exchange.mounted(self.scene, model, pair), f"{model} does not fit pair {pair}")

    def _begin_anew(self, changed: Callable[[], Scene], why_not: str) -> None:
        """Close the records and let all pairs begin at their start in a changed scene, with the present controls.

        Raises:
            StateError: the changed scene cannot run; nothing changes.
        """
        try:
            scene = changed()
            plants = opened(scene, only=tuple(self._pairs))
            rigs = rigs_of(scene, plants)
        except SceneError as error:
            raise StateError(f"{why_not}: {error.what}", where=error.where, why=error.why, mend=error.mend) from None
        self.close()
        kept = [session.controls for session in self._pairs.values()]
        self.scene, self.rigs, self._plants = scene, rigs, plants
        self._sit()
        for session, controls in zip(self._pairs.values(), kept, strict=True):
            controls.quat_WL = session.controls.quat_WL  # of the leader that the pair has now
            session.controls = controls

    # -- running ---------------------------------------------------------------------------------------------------

    def run(
        self,
        duration: float | None = None,
        realtime: bool | None = None,
        on_progress: Callable[[States], None] | None = None,
    ) -> PairsSummary:
        """Run all pairs for a duration, then close the records; as `Session.run`, with the states of all pairs."""
        self._require_idle()
        realtime = self.driven if realtime is None else realtime
        if not realtime:
            self._require_simulated("a session cannot run in lockstep")
        usual = np.inf if self.driven else self.scene.duration
        seconds = usual if duration is None else duration
        stopped = next(iter(self.pairs.values())).stopped
        with stop_signals.deferred(stopped):
            try:
                (self._run_realtime if realtime else self._run_lockstep)(seconds, on_progress)
            except BaseException:
                self.close(interrupted=True)  # the records are complete after any exception
                raise
            return self.close(interrupted=stopped.is_set())

    def start(self) -> None:
        """Start every pair in real time, each in its own threads; no effect on a pair that runs."""
        for session in self.pairs.values():
            session.prepare()
        if self.world is not None:
            self.world.start()
        try:
            for session in self.pairs.values():
                session.start()
        except BaseException:  # a device that cannot be opened: the others end with zero force
            self.stop()
            raise
        self._seat.start()
        self._stop_steps.clear()
        if not self._steppers:
            timed = [lambda one=one: one(float(self.latest()["t"])) for one in self.steps_beside]
            note = next(iter(self.pairs.values())).note
            self._steppers = [every(PERIOD, one, self._stop_steps, "task", note) for one in timed]

    def stop(self) -> None:
        """Stop every pair with its force at zero."""
        self._seat.stop()
        self._stop_steps.set()
        for thread in self._steppers:
            thread.join()
        self._steppers = []
        for session in self.pairs.values():
            session.stop()
        if self.world is not None:
            self.world.stop()

    def step(self, n: int = 1) -> States:
        """Run `n` ticks of every pair in lockstep; the records stay open."""
        self._require_idle()
        self._require_simulated("a session cannot be stepped")
        self._take(self._advance(n), behind=False)
        return self.states

    def close(self, interrupted: bool = False) -> PairsSummary:
        """Stop all pairs, close their records and return the summary."""
        self.stop()
        folder, self.folder = self.folder, None
        found: dict[str, Summary] = {}

        def close(name: str) -> None:
            found[name] = self.pairs[name].close(interrupted)

        with ExitStack() as closing:  # of every pair, even if the record of another one fails
            for name in reversed(list(self.pairs)):
                closing.callback(close, name)
        met = meeting([session.met for session in self.pairs.values()], bodies=self.world is not None)
        for session in self.pairs.values():
            session.met = self.new_met(session.rate)
        return PairsSummary.of(found, met, None if folder is None else str(folder))

    def __enter__(self) -> Self:
        """The session itself."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close the session."""
        self.close()

    # -- observation -----------------------------------------------------------------------------------------------

    @property
    def running(self) -> bool:
        """True while a pair runs in real time."""
        return any(session.running for session in self.pairs.values())

    @property
    def states(self) -> States:
        """State of each pair at its newest tick."""
        return {name: session.state for name, session in self.pairs.items()}

    def latest(self) -> Ticks:
        """The newest tick of the first pair."""
        return next(iter(self.pairs.values())).latest()

    @property
    def controls(self) -> Controls:
        """Controls of the first pair, as a copy. Assigned controls set the pause of all pairs, and nothing else."""
        return next(iter(self.pairs.values())).controls

    @controls.setter
    def controls(self, value: _core.Controls) -> None:
        for session in self.pairs.values():
            session.change(paused=value.paused)

    @property
    def camera(self) -> CameraArm | None:
        """The endoscope arm, which the hands of all pairs steer; None if the scene has none."""
        return self._seat.camera

    def request(self, request: str) -> None:
        """Ask for a change of the state of all pairs (`Console.request`); ``pairs[NAME].request`` asks one pair."""
        self.console.request(request)

    @property
    def recording(self) -> bool:
        """False: no new records are begun."""
        return next(iter(self.pairs.values())).recording

    def limit_record(self, size: float) -> None:
        """End the record of each pair at its share of a size, and begin no further one [bytes]."""
        for session in self.pairs.values():
            session.limit_record(size / len(self.pairs))

    def execute(self, plan: Plan, speed: float = 1.0, guard: float = GUARD) -> PlanExecution:
        """Let a plan move the follower of the pair that it names as its arm; as `Session.execute`.

        Where the instruments of the other pairs are counts as everything else that moves.

        Raises:
            PlanningError, StateError: as `Session.execute`, and if no pair has the name of the plan's arm.
        """
        if plan.arm not in self._pairs:
            names = ", ".join(self._pairs)
            what = f"the plan moves {plan.arm}, and the pairs are {names}"
            raise PlanningError(what, mend="plan for one of them: palpate plan SCENE --arm NAME")
        return self._pairs[plan.arm].execute(plan, speed, guard)

    def set_recording(self, on: bool) -> None:
        """End the present records, also while the pairs run; True begins new ones with the next tick."""
        for session in self.pairs.values():
            session.set_recording(on)
        self.folder = None

    def interrupt(self) -> None:
        """End `run` before its duration is over; the records are complete."""
        next(iter(self.pairs.values())).interrupt()

    # -- inside ----------------------------------------------------------------------------------------------------

    def new_met(self, rate: float) -> Met:
        """An empty account of meetings, for ticks at a rate [Hz]."""
        return Met(rate, self.scene.instruments.handle_distance)

    def run_folder(self) -> Path:
        """Folder of the present run, made when the first pair begins to record."""
        if self.folder is None:
            assert self._out is not None
            self.folder = new_folder(self._out, self.scene.title)
            keep_scene(self.folder, self.scene.to_yaml())
        return self.folder

    def keeps_shapes(self, name: str) -> bool:
        """True for the first pair: its record holds the soft objects and rigid bodies, which all pairs touch."""
        return name == next(iter(self._pairs))

    @property
    def driven(self) -> bool:
        """True if a pair is felt on a device: the session then runs in real time, without a limit of its own."""
        return any(not session.plant.simulated for session in self._pairs.values())

    def _require_simulated(self, what: str) -> None:
        """Refuse what no device can do.

        Raises:
            StateError: a pair is felt on a device.
        """
        for name, session in self._pairs.items():
            if not session.plant.simulated:
                felt = ", ".join(session.plant.hardware) or "a loop of your own"
                why = f"pair {name} is felt on {felt}, which has a time of its own"
                raise StateError(what, why=why, mend="run in real time; change the scene, and run it again")

    def _require_idle(self) -> None:
        if self.running:
            raise PalpateError("the session runs in real time already", mend="call stop() first")

    def steer_camera(self) -> None:
        """Let the hands of all pairs move the camera for one `PERIOD` while the camera pedal is pressed."""
        self._seat.steer()

    def _advance(self, n: int) -> list[list[np.ndarray]]:
        """Run `n` ticks of all pairs, in blocks (rows of each) between which what is beside has its turns."""
        hands = list(self.pairs.values())
        blocks = self._turns.blocks(n, self.scene.rates.haptic, self, hands)
        return [_core.run_in_turns(self._loops, some) for some in blocks]

    def _take(self, blocks: list[list[np.ndarray]], behind: bool) -> None:
        for rows in blocks:
            for session, one in zip(self.pairs.values(), rows, strict=True):
                session.take(as_ticks(one), behind)

    @loop_first()
    def _run_lockstep(self, seconds: float, on_progress: Callable[[States], None] | None) -> None:
        n = max(1, round(seconds * self.scene.rates.haptic))
        for session in self.pairs.values():
            session.require_own_clock()
        watched = on_progress is not None or self.steps_beside
        batch = max(1, round((BATCH if watched else UNWATCHED_BATCH) * self.scene.rates.haptic))
        stopped = next(iter(self.pairs.values())).stopped
        while n > 0 and not stopped.is_set() and not self._task_over.is_set():
            blocks = self._advance(min(batch, n))
            taken = sum(len(rows[0]) for rows in blocks)
            if not taken:  # paused: simulated time stops
                time.sleep(DRAIN)
                continue
            n -= taken
            self._take(blocks, behind=True)
            if on_progress is not None:
                on_progress(self.states)

    def _run_realtime(self, seconds: float, on_progress: Callable[[States], None] | None) -> None:
        stopped = next(iter(self.pairs.values())).stopped
        self.start()
        try:
            over = self._end_of_run(seconds)
            while not (stopped.is_set() or self._task_over.is_set() or over()):
                time.sleep(2 * DRAIN)
                if on_progress is not None:
                    on_progress(self.states)
        finally:
            self.stop()

    def _end_of_run(self, seconds: float) -> Callable[[], bool]:
        """What says whether a run that goes on for so many seconds is over: every pair has its ticks, or has ended.

        With a device by the clock, not by the ticks: one whose service is late has fewer of them.
        """
        if self.driven:
            end = time.monotonic() + seconds
            return lambda: time.monotonic() >= end or all(session.failed for session in self.pairs.values())
        goals = {name: session.taken + max(1.0, seconds * session.rate) for name, session in self.pairs.items()}
        latest = np.inf

        def over() -> bool:
            nonlocal latest
            going = [name for name, session in self.pairs.items() if session.ended is None]
            late = [name for name in going if self.pairs[name].taken < goals[name]]
            if len(late) < len(going):  # a pair that stalls does not keep the others running
                latest = min(latest, time.monotonic() + _GRACE)
            return not late or time.monotonic() > latest

        return over
