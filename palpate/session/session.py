"""A session: one scene, run in lockstep or in real time, recorded while it runs."""

from __future__ import annotations

import os
import signal
import threading
import time
import weakref
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from palpate import _core
from palpate.errors import PalpateError
from palpate.guidance.fixture import Fixture
from palpate.guidance.lists import named
from palpate.guidance.steered import SteeredFixtures
from palpate.record.ticks import Ticks, as_ticks
from palpate.record.writer import Recorder
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.session.run_folder import keep_scene, new_folder, require_writable
from palpate.session.summary import Summary, Totals

BATCH = 0.1  # lockstep: ticks are handed over in batches of so much simulated time [s]
_DRAIN = 0.05  # real time: the ring is drained so often [s]


@dataclass(frozen=True)
class State:
    """The newest tick of a session, for people and progress lines. `tick` holds every signal."""

    tick: Ticks  # one row of `TICK`
    phase: str  # of the operator's path: approach, press, slide, leave; empty when unknown

    @property
    def t(self) -> float:
        """Time of the tick [s]."""
        return float(self.tick["t"])

    @property
    def force(self) -> float:
        """Size of the force commanded on the hand [N]."""
        return float(np.linalg.norm(self.tick["F_H_L"]))

    @property
    def F_T_W(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Force of the environment on the tool (3,) [N]."""
        return np.asarray(self.tick["F_T_W"])

    @property
    def depth(self) -> float:
        """Penetration [m]."""
        return float(self.tick["depth"])

    @property
    def contacts(self) -> int:
        """Number of objects touched."""
        return int(self.tick["contacts"])

    @property
    def cycle_us(self) -> float:
        """Compute time of the haptic cycle [us]."""
        return float(self.tick["cycle_us"])


class Session:
    """A scene that runs.

        session = palpate.Session(palpate.Scene.load("scenes/palpation.yaml"), out="runs")
        summary = session.run(10.0)

    Args:
        scene: what to run.
        out: folder for records; each run gets a folder of its own below it. None: nothing is recorded.
        seed: instead of the scene's.

    Raises:
        SceneError, MeshError: the scene cannot run. OutputError: `out` cannot be written.
    """

    def __init__(self, scene: Scene, out: str | os.PathLike[str] | None = None, seed: int | None = None) -> None:
        self.scene = scene
        self.seed = scene.seed if seed is None else seed
        self.rate = scene.rates.haptic  #: ticks per second [Hz]
        self._out = Path(out) if out is not None else None
        if self._out is not None:
            require_writable(self._out)
        self.rig: Rig = build(scene)
        self._sim = self._make_loop()
        self._fixtures = scene.guidance
        weakref.finalize(self, self._sim.stop)  # a session forgotten, or alive when Python ends: force to zero first
        self._recorder: Recorder | None = None
        self._steered: SteeredFixtures | None = None
        self._closed = True
        self._totals = Totals(self.rate)
        self._live = False
        self._began = 0.0
        self._dropped = 0
        self._lock = threading.RLock()  # the recorder is fed by one thread at a time
        self._pump: threading.Thread | None = None
        self._stop_pump = threading.Event()
        self._interrupted = threading.Event()
        self.recording = self._out is not None  #: set it to False to run on unrecorded from the next record on
        self.record: Path | None = None  #: file of the newest record
        self.notes: list[str] = []  #: what went wrong beside the run, e.g. a full disk

    # -- running ---------------------------------------------------------------------------------------------------

    def run(
        self,
        duration: float | None = None,
        realtime: bool = False,
        on_progress: Callable[[State], None] | None = None,
    ) -> Summary:
        """Run on for a while, then close the record.

        Args:
            duration: simulated time [s]; the scene's when left out.
            realtime: at the pace of the clock, in a C++ thread; otherwise lockstep, as fast as the machine can.
            on_progress: told the state about ten times a second of simulated time (lockstep) or of time (real time).

        Returns:
            The summary of everything since the record began. Ctrl-C ends the run early and is told in it.
        """
        self._require_idle()
        n = max(1, round((self.scene.duration if duration is None else duration) * self.rate))
        with self._ctrl_c_waits():
            try:
                (self._run_realtime if realtime else self._run_lockstep)(n, on_progress)
            except BaseException:
                self.close(interrupted=True)  # whatever was thrown, the record is whole
                raise
            return self.close(interrupted=self._interrupted.is_set())

    def step(self, n: int = 1) -> State:
        """Run `n` ticks in lockstep and return the newest; the record stays open."""
        self._require_idle()
        self._take(as_ticks(self._sim.run(n)))
        return self.state

    def start(self) -> None:
        """Run in real time from here on, in threads of its own, until `stop`. Does nothing when it runs already."""
        if self._pump is not None:
            return
        self._begin(realtime=True)
        self._stop_pump.clear()
        self._sim.start()
        self._pump = threading.Thread(target=self._keep_draining, name="palpate-drain", daemon=True)
        self._pump.start()

    def stop(self) -> None:
        """Stop the real-time run with the force at zero. Does nothing when it does not run."""
        if self._pump is None:
            return
        self._sim.stop()
        self._stop_pump.set()
        self._pump.join()
        self._pump = None
        self._drain()

    # -- looking and steering --------------------------------------------------------------------------------------

    @property
    def running(self) -> bool:
        """Does it run in real time now?"""
        return self._pump is not None

    @property
    def state(self) -> State:
        """The newest tick: of the loop itself while it runs in real time."""
        tick = self.latest()
        return State(tick, self.rig.path.phase(float(tick["t"])))

    def latest(self) -> Ticks:
        """The newest tick as one row of `TICK`; never waits for the loop."""
        tick: Ticks = as_ticks(self._sim.latest().reshape(1, -1))[0]
        return tick

    @property
    def controls(self) -> _core.Controls:
        """Clutch, pause, stiffness and damping scales, drag of the hand. A copy: assign it whole."""
        controls: _core.Controls = self._sim.controls
        return controls

    @controls.setter
    def controls(self, value: _core.Controls) -> None:
        self._sim.controls = value

    @property
    def fixtures(self) -> tuple[Fixture, ...]:
        """Virtual fixtures in use. Assign others, or changed ones, while it runs: nothing that the hand feels jumps."""
        return self._fixtures

    @fixtures.setter
    def fixtures(self, value: Iterable[Fixture]) -> None:
        fixtures = named(tuple(value))
        here = self.rig.here
        self._sim.set_fixtures(_core.Fixtures([fixture.make(here) for fixture in fixtures], here.tool))
        self._fixtures, self._steered = fixtures, None

    @property
    def steered(self) -> SteeredFixtures:
        """The same by name, to be switched, weighed and moved one by one."""
        if self._steered is None:
            self._steered = SteeredFixtures(self._fixtures, self.rig.here, self._steer)
        return self._steered

    def _steer(self, sections: tuple[Fixture, ...], core: _core.Fixtures) -> None:
        self._sim.set_fixtures(core)
        self._fixtures = sections

    @property
    def frames(self) -> Mapping[str, _core.Frame]:
        """Frames that fixtures are attached to, by name; ``frames["camera"].set(X_WC)`` tells where the camera is."""
        return self.rig.here.frames

    def why(self) -> str:
        """Why the hand feels guidance now, in words: the fixture that pulls most, and its terms."""
        from palpate.guidance.why import Hand, of_tick

        tick, scene = self.latest(), self.rig.scene
        V_WT = np.r_[scene.mapping.scale * self.rig.arms.X_WL[:3, :3] @ np.asarray(tick["v_LH"]), np.zeros(3)]
        hand = Hand(V_WT, self.controls.guidance, float(np.linalg.norm(tick["F_cell_L"])))
        return of_tick(self._fixtures, tick, self.rig.here, hand)

    @property
    def timing(self) -> dict[str, Any]:
        """Compute time, lateness, slack and missed ticks of the loop (`Simulation.timing`)."""
        return dict(self._sim.timing())

    # -- ending ----------------------------------------------------------------------------------------------------

    def close(self, interrupted: bool = False) -> Summary:
        """Stop, close the record and sum up. What runs afterwards goes into a new record."""
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
        """Close it."""
        self.close()

    # -- inside ----------------------------------------------------------------------------------------------------

    def _make_loop(self) -> Any:
        """What ticks: a simulation, or what is driven as one."""
        return self.rig.simulation(self.seed)

    def _require_idle(self) -> None:
        if self._pump is not None:
            raise PalpateError("the session runs in real time already", mend="call stop() first")

    @contextmanager
    def _ctrl_c_waits(self) -> Iterator[None]:
        """Ctrl-C (and SIGTERM, SIGHUP where somebody listens) ends a run between two batches, never inside a write."""
        self._interrupted.clear()
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        heard = [s for s in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP) if callable(signal.getsignal(s))]
        before = {s: signal.signal(s, lambda *_: self._interrupted.set()) for s in heard}
        try:
            yield
        finally:
            for s, handler in before.items():
                signal.signal(s, handler)

    def _run_lockstep(self, n: int, on_progress: Callable[[State], None] | None) -> None:
        batch = max(1, round(BATCH * self.rate))
        while n > 0 and not self._interrupted.is_set():
            rows = self._sim.run(min(batch, n))
            if not len(rows):  # paused: time stands still
                time.sleep(_DRAIN)
                continue
            n -= len(rows)
            self._take(as_ticks(rows))
            if on_progress is not None:
                on_progress(self.state)

    def _run_realtime(self, n: int, on_progress: Callable[[State], None] | None) -> None:
        self.start()
        goal = self._totals.ticks + n
        try:
            while self._totals.ticks + self._sim.dropped < goal and not self._interrupted.is_set():
                time.sleep(2 * _DRAIN)
                if on_progress is not None:
                    on_progress(self.state)
        finally:
            self.stop()

    def _keep_draining(self) -> None:
        while not self._stop_pump.wait(_DRAIN):
            self._drain()

    def _drain(self) -> None:
        rows = self._sim.drain()
        if len(rows):
            self._take(as_ticks(rows), realtime=True)

    def _take(self, ticks: Ticks, realtime: bool = False) -> None:
        with self._lock:
            self._begin(realtime)
            self._totals.add(ticks)
            if self._recorder is not None:
                self._recorder.append(ticks)
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
            self._dropped = int(self._sim.dropped)
            self.notes = []
            self._recorder, self.record = None, None
            if self._out is not None and self.recording:
                folder = new_folder(self._out, self.scene.title)
                self.record = folder / "record.mcap"
                self.notes += keep_scene(folder, self.rig.resolved_yaml(absolute=True))
                self._recorder = Recorder(
                    self.record, self.rig.resolved_yaml(), self.seed, self.rate, not realtime, bag=True
                )

    def _faults(self) -> list[str]:
        fault = self._sim.fault()
        lost = int(self._sim.dropped) - self._dropped
        faults = [fault] if fault else []
        return [*faults, f"{lost} ticks are missing in the record: the disk was too slow"] if lost > 0 else faults
