"""A real-time session runs any loop with the interface of `Loop`, but not in lockstep."""

import time

import numpy as np
import pytest

from palpate import Scene, _core
from palpate.record import TICK
from palpate.scene.rig import build
from palpate.session.live import LiveSession


class Metronome:
    """A loop without a simulation, which returns ten ticks at each drain while it runs."""

    def __init__(self):
        self.controls, self.dropped, self.running, self.t = _core.Controls(), 0, False, 0.0
        self.fixtures = None

    def start(self):
        self.running = True

    def stop(self):
        self.running = False

    def _rows(self, n):
        ticks = np.zeros(n, TICK)
        ticks["t"] = self.t + 1e-3 * np.arange(n)
        self.t += 1e-3 * n
        return ticks.view(np.float64).reshape(n, TICK.itemsize // 8)

    def drain(self):
        return self._rows(10 if self.running else 0)

    def latest(self):
        return self._rows(1)[0]

    def timing(self):
        return {"missed_ticks": 0}

    def set_snapshot(self, snapshot):
        raise AssertionError("unexpected change of the scene")

    def set_fixtures(self, fixtures):
        self.fixtures = fixtures

    def fault(self):
        return None


@pytest.fixture
def session(tmp_path):
    rig = build(Scene.model_validate({"objects": [{"shape": "organ", "triangles": 2000}]}))
    return LiveSession(rig, Metronome(), rate=1000.0, seed=1, out=tmp_path)


def test_loop_is_started_drained_recorded_and_stopped(session):
    session.start()
    assert session.running
    deadline = time.monotonic() + 20.0
    while session._totals.ticks < 20 and time.monotonic() < deadline:
        time.sleep(0.02)
    summary = session.close()
    assert not session.running
    assert not session._loop.running
    assert summary.ticks >= 20
    assert session.record.is_file()


def test_controls_and_fixtures_reach_the_loop(session):
    controls = session.controls
    controls.paused = True
    session.controls = controls
    assert session._loop.controls.paused
    session.fixtures = ()
    assert session._loop.fixtures is not None


def test_loop_without_simulation_has_no_lockstep(session):
    assert not hasattr(session, "run")
    assert not hasattr(session, "step")
