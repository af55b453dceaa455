"""The cycle neither allocates nor frees memory, takes no lock and makes no system call but its sleep.

heap_guard.cpp and syscall_watch.cpp count this in the shipped module.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
SLEEP, PARENT, RESTART = "230", "110", "219"
"""Numbers of the system calls clock_nanosleep, getppid (planted) and restart_syscall on x86-64."""


def compiled(folder: Path, source: str, name: str, *flags: str) -> Path:
    compiler = os.environ.get("CXX") or shutil.which("c++") or shutil.which("g++")
    if compiler is None:
        pytest.skip("no C++ compiler: heap_guard.cpp cannot be built")
    warnings = ["-Wall", "-Wextra", "-Werror"]
    subprocess.run([compiler, "-std=c++20", "-O2", *warnings, *flags, "-o", folder / name, HERE / source], check=True)
    return folder / name


@pytest.fixture(scope="session")
def guard(tmp_path_factory) -> Path:
    flags = ("-shared", "-fPIC", "-ldl", "-pthread")
    return compiled(tmp_path_factory.mktemp("guard"), "heap_guard.cpp", "heap_guard.so", *flags)


@pytest.fixture(scope="session")
def watch(tmp_path_factory) -> Path:
    return compiled(tmp_path_factory.mktemp("watch"), "syscall_watch.cpp", "syscall_watch")


def watched(guard: Path, *arguments: str, **environment: str) -> dict:
    run = subprocess.run(
        [sys.executable, HERE / "watched.py", *arguments],
        env={**os.environ, "LD_PRELOAD": str(guard), **environment},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


@pytest.mark.parametrize(("method", "rate"), [("proxy", 1000), ("proxy", 4000), ("penalty", 1000)])
def test_real_time_loop_allocates_nothing_while_scenes_are_replaced(guard, method, rate):
    found = watched(guard, "realtime", method, str(rate), "2")
    assert found["ticks"] > rate
    assert found["swaps"] > 30
    assert found["contact_ticks"] > 100, "some ticks are in contact; their number depends on the machine"
    assert found["threads"] == [[0, 0, 0]], "allocations, releases, locks of the loop's thread"
    assert min(found["main"]) > 0, "control: the guard counts"
    assert found["last_force"] == [0.0, 0.0, 0.0], "the last force before the stop is zero"
    assert any(found["last_gravity"]), "gravity stays compensated"


def test_soft_body_on_a_thread_of_its_own_allocates_nothing(guard):
    found = watched(guard, "beside", "proxy", "1000")
    assert found["contact_ticks"] > 100
    assert found["nothing"] == [[0, 0, 0]] * 2, "the threads of the loop and of the body"
    assert min(thread[0] for thread in found["allocation"]) > 5, "control: planted calls are found in both threads"


def test_loop_makes_no_system_call_but_its_sleep_and_planted_calls_are_found(guard, watch):
    found = watched(guard, "planted", "proxy", "1000", SYSCALL_WATCH=str(watch))
    assert found["nothing"] == [0, 0, 0]
    assert min(found["allocation"][:2]) > 20
    for kind in ("lock", "trylock", "condition"):
        assert found[kind][2] > 20, kind
        assert found[kind][:2] == [0, 0]
    if "refused" in found["system_calls"]:
        pytest.skip("this system does not let a process trace another: system calls cannot be counted")
    assert set(found["system_calls"]) <= {SLEEP, RESTART}, found["system_calls"]
    assert found["system_calls"][SLEEP] > 20, "control: system calls are counted"
    assert found["system_calls_planted"][PARENT] > 20


def test_collision_thread_of_the_paper_allocates_but_the_cycle_does_not(guard):
    """Coal allocates: a control that such calls are counted, and that they are outside the thread of the cycle."""
    found = watched(guard, "realtime", "paper-alg1", "1000", "2")
    clean = [t for t in found["threads"] if t == [0, 0, 0]]
    dirty = [t for t in found["threads"] if t[0] > 100]
    assert found["swaps"] > 30
    assert len(found["threads"]) == 2
    assert len(clean) == 1
    assert len(dirty) == 1


CASES = (
    "organ",
    "solids",
    "cloud",
    "live",
    "impedance",
    "admittance",
    "six_axis",
    "soft",
    "delta",
    "identified",
    "estimating",
    "guided",
    "executing",
)


@pytest.fixture(scope="module")
def lockstep(guard):
    """Counts of all cases from one process."""
    return watched(guard, "lockstep", "proxy", *CASES)


@pytest.mark.parametrize("case", CASES)
def test_lockstep_tick_with_plant_allocates_nothing(lockstep, case):
    """A call takes a few allocations of Python and numpy, the same number for 7, 700 or 2000 ticks."""
    found = lockstep[case]
    first, *rest = found["calls"][1:]
    assert found["contact_ticks"] > 1000
    assert rest == [first] * len(rest)
    assert first[0] > 0, "control: the allocations of the call are counted"


ROBOTS = ("following", "impedance", "moving")


@pytest.fixture(scope="module")
def robots(guard):
    """Counts of all cases from one process."""
    return watched(guard, "robot", *ROBOTS)


@pytest.mark.parametrize("case", ROBOTS)
def test_simulated_dvrk_allocates_nothing(robots, case):
    """The only allocations are those of the call and of the release of the interpreter lock."""
    found = robots[case]
    first, *rest = found["calls"][1:]
    assert found["following"] == (case == "following")
    assert rest == [first] * len(rest)


def test_geometry_query_allocates_nothing(guard):
    for name, calls in watched(guard, "geometries", "all").items():
        first, *rest = calls[1:]
        assert rest == [first] * len(rest), name
        assert first[0] > 0, "control: the allocations of the call are counted"


def test_cycle_of_networked_devices_allocates_nothing(guard):
    found = watched(guard, "crtk", "all")
    assert found["contact_ticks"] >= 2
    counts = found["counts"]
    assert counts["no scene"][0][0] > 0, "control: the allocations of a call are counted"
    for name in ("free", "pressed", "bad stamps", "recovered"):
        assert counts[name] == counts["no scene"], f"{name}: each of 500 steps"
    assert counts["planted"] != counts["no scene"], "control: an allocation in five of 500 steps is found"


def test_cycle_of_a_device_allocates_nothing(guard):
    found = watched(guard, "device", "all")
    assert found["contact_ticks"] > 1000
    assert found["control"][0] > 0, "the allocations of a call that returns an array are counted"
    for name, calls in found["calls"].items():
        assert [allocations for allocations, *_ in calls[1:]] == [0, 0, 0], name
        assert calls[2:] == calls[1:2] * 2, (
            f"{name}: releases and locks are those of the call, not of its 200 to 2000 steps"
        )
