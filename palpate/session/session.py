"""A session: one scene, run in lockstep or in real time, recorded while it runs."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

from palpate.record.ticks import as_ticks
from palpate.scene.rig import build
from palpate.scene.scene import Scene
from palpate.session.live import DRAIN, LiveSession
from palpate.session.loop import LockstepLoop
from palpate.session.run_folder import require_writable
from palpate.session.state import State
from palpate.session.summary import Summary

BATCH = 0.1  # lockstep: ticks are handed over in batches of so much simulated time [s]


class Session(LiveSession):
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
        if out is not None:
            require_writable(Path(out))
        rig, seed = build(scene), scene.seed if seed is None else seed
        self._sim: LockstepLoop = rig.simulation(seed)
        super().__init__(rig, self._sim, scene.rates.haptic, seed, out)

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

    def _run_lockstep(self, n: int, on_progress: Callable[[State], None] | None) -> None:
        batch = max(1, round(BATCH * self.rate))
        while n > 0 and not self._interrupted.is_set():
            rows = self._sim.run(min(batch, n))
            if not len(rows):  # paused: time stands still
                time.sleep(DRAIN)
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
                time.sleep(2 * DRAIN)
                if on_progress is not None:
                    on_progress(self.state)
        finally:
            self.stop()
