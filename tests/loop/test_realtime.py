"""The real-time thread: it runs, accepts reads and controls, and stops at zero force. No timing is asserted."""

import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from loop_rig import HEIGHT, floor, simulation

from palpate import _core
from palpate.record.ticks import as_ticks

PRESS = _core.HandPath([0.05, 0.3], np.array([[0, 0, HEIGHT], [0, 0, -0.006]]))


def wait_for(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "timeout"
        time.sleep(0.01)


def test_thread_stops_at_zero_force_with_gravity_compensation():
    sim = simulation(path=PRESS)
    sim.start()
    assert sim.running
    with pytest.raises(RuntimeError, match="stop"):
        sim.run(1)
    with pytest.raises(RuntimeError, match="already"):
        sim.start()
    wait_for(lambda: np.linalg.norm(as_ticks(sim.latest())[0]["F_H_L"]) > 0.3)
    sim.stop()
    assert not sim.running
    ticks = as_ticks(sim.drain())
    last = ticks[-1]
    assert not last["F_H_L"].any()
    assert not last["tau_force"].any()
    assert last["tau_gravity"].any()
    assert np.linalg.norm(np.diff(ticks["F_H_L"], axis=0), axis=1).max() <= 0.05 + 1e-12
    timing = sim.timing()
    assert timing["ticks"] == len(ticks) + sim.dropped
    assert set(timing["cycle_us"]) == set(timing["lateness_us"]) == {"p50", "p99", "p999", "max"}
    assert "SCHED_FIFO" in timing["scheduler"] or "normal" in timing["scheduler"]
    assert sim.fault() is None


def test_second_start_continues_the_simulation():
    sim = simulation(path=PRESS)
    for _ in range(3):
        sim.start()
        wait_for(lambda: sim.timing()["ticks"] > 0)
        sim.stop()
    t = as_ticks(sim.drain())["t"]
    assert (np.diff(t) > 0).all()
    assert as_ticks(sim.run(1))["t"][0] > t[-1]


def test_concurrent_changes_and_reads_are_safe():
    """Several threads change scenes and controls and read: all reads are consistent and the thread goes on."""
    sim = simulation(path=PRESS)
    sim.start()
    over, errors = threading.Event(), []

    def repeat(act):
        try:
            while not over.is_set():
                act()
        except Exception as error:
            errors.append(error)

    def steer():
        c = _core.Controls()
        c.clutch = not sim.controls.clutch
        sim.controls = c
        time.sleep(0.01)

    def swap():
        sim.set_snapshot(floor())
        time.sleep(0.001)

    rows = []
    threads = [
        threading.Thread(target=repeat, args=(act,))
        for act in (steer, swap, swap, sim.latest, lambda: rows.append(sim.drain()))
    ]
    for thread in threads:
        thread.start()
    time.sleep(1.0)
    over.set()
    for thread in threads:
        thread.join()
    sim.stop()
    rows.append(sim.drain())
    ticks = as_ticks(np.concatenate(rows))
    assert errors == []
    assert np.isfinite(ticks["F_H_L"]).all()
    assert (np.diff(ticks["t"]) > 0).all()
    assert sim.fault() is None


def test_time_stands_still_during_a_pause():
    sim = simulation(path=PRESS)
    sim.start()
    wait_for(lambda: sim.timing()["ticks"] > 10)
    c = _core.Controls()
    c.paused = True
    sim.controls = c
    time.sleep(0.1)
    t = as_ticks(sim.latest())[0]["t"]
    time.sleep(0.1)
    assert as_ticks(sim.latest())[0]["t"] == t
    sim.stop()  # also ends a paused simulation


def test_deleted_simulation_ends_its_thread():
    sim = simulation(path=PRESS)
    sim.start()
    del sim


def test_thread_runs_without_privileges_and_reports_it():
    options = _core.RealTimeOptions()
    options.allow_priority = options.allow_affinity = False
    bare = _core.BareLoop(1000.0, options)
    bare.start()
    wait_for(lambda: bare.timing()["ticks"] > 50)
    bare.stop()
    timing = bare.timing()
    assert timing["scheduler"] == "normal scheduling"
    assert timing["lateness_us"]["p50"] >= 0


def test_what_a_real_time_thread_begins_has_normal_scheduling():
    """A sender of Fast DDS that inherited SCHED_FIFO held both cores of a machine for ten minutes."""
    found = {}

    def body():
        found["granted"] = _core.schedule(True)
        found["own"] = os.sched_getscheduler(0)
        child = threading.Thread(target=lambda: found.update(thread=os.sched_getscheduler(0)))
        child.start()
        child.join()
        code = "import os; print(os.sched_getscheduler(0))"
        found["process"] = int(subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout)
        _core.schedule(False)
        found["after"] = os.sched_getscheduler(0)

    thread = threading.Thread(target=body)
    thread.start()
    thread.join()
    if "refused" in found["granted"]:
        pytest.skip("this system refuses SCHED_FIFO")
    assert found["own"] & ~os.SCHED_RESET_ON_FORK == os.SCHED_FIFO
    assert [found[who] for who in ("thread", "process", "after")] == [os.SCHED_OTHER] * 3
