"""The cycle allocates nothing, frees nothing and takes no lock: counted in the shipped module by heap_guard.cpp."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def guard(tmp_path_factory) -> Path:
    compiler = os.environ.get("CXX") or shutil.which("c++") or shutil.which("g++")
    if compiler is None:
        pytest.skip("no C++ compiler: heap_guard.cpp cannot be built")
    library = tmp_path_factory.mktemp("guard") / "heap_guard.so"
    flags = ["-std=c++20", "-O2", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror"]
    subprocess.run([compiler, *flags, "-o", library, HERE / "heap_guard.cpp", "-ldl", "-pthread"], check=True)
    return library


def watched(guard: Path, *arguments: str) -> dict:
    run = subprocess.run(
        [sys.executable, HERE / "watched.py", *arguments],
        env={**os.environ, "LD_PRELOAD": str(guard)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


@pytest.mark.parametrize(("method", "rate"), [("proxy", 1000), ("proxy", 4000), ("penalty", 1000)])
def test_real_time_loop_with_scenes_swapped_meanwhile(guard, method, rate):
    found = watched(guard, "realtime", method, str(rate), "2")
    assert found["ticks"] > rate
    assert found["swaps"] > 30
    assert found["contact_ticks"] > 100, "some of them in contact: how many is the machine's business"
    assert found["threads"] == [[0, 0, 0]], "allocations, releases, locks of the loop's thread"
    assert min(found["main"]) > 0, "control: the guard does count"
    assert found["last_force"] == [0.0, 0.0, 0.0], "stopped: the last force is zero"
    assert any(found["last_gravity"]), "and gravity stays compensated"


def test_collision_thread_of_the_paper_allocates_beside_a_clean_loop(guard):
    """Coal allocates: a control that such calls are seen, and that they stay out of the cycle's thread."""
    found = watched(guard, "realtime", "paper-alg1", "1000", "2")
    clean = [t for t in found["threads"] if t == [0, 0, 0]]
    dirty = [t for t in found["threads"] if t[0] > 100]
    assert len(found["threads"]) == 2
    assert len(clean) == 1
    assert len(dirty) == 1


@pytest.mark.parametrize(
    "what", ["organ", "solids", "impedance", "admittance", "six_axis", "delta", "identified", "estimating", "guided"]
)
def test_lockstep_tick_with_plant_asks_nothing(guard, what):
    """A call costs Python and numpy a few allocations, whatever its length: 700 ticks as many as 7 or 2000."""
    found = watched(guard, "lockstep", "proxy", what)
    first, *rest = found["calls"][1:]
    assert found["contact_ticks"] > 1000
    assert rest == [first] * len(rest)
    assert first[0] > 0, "control: the call's own allocations are counted"


@pytest.mark.parametrize("what", ["following", "impedance", "moving"])
def test_simulated_dvrk_asks_nothing(guard, what):
    """As above: what remains is the call's own, and its letting go of the interpreter."""
    found = watched(guard, "robot", what)
    first, *rest = found["calls"][1:]
    assert found["following"] == (what == "following")
    assert rest == [first] * len(rest)


def test_a_query_of_a_geometry_asks_nothing(guard):
    for name, calls in watched(guard, "geometries", "all").items():
        first, *rest = calls[1:]
        assert rest == [first] * len(rest), name
        assert first[0] > 0, "control: the call's own allocations are counted"


def test_the_cycle_of_networked_devices_asks_nothing(guard):
    found = watched(guard, "crtk", "all")
    assert found["contact_ticks"] >= 2
    asked = found["asked"]
    assert asked["no scene"][0] > 0, "control: what a call costs Python is counted"
    for name in ("free", "pressed", "bad stamps", "well again"):
        assert asked[name] == asked["no scene"], name
