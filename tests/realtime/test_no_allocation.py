"""A cycle in real time neither allocates nor frees memory, takes no lock and makes no system call but its sleep.

heap_guard.cpp and syscall_watch.cpp count this in the shipped module; the cycle in lockstep has a file of its own.
"""

import pytest

SLEEP, PARENT, RESTART = "230", "110", "219"
"""Numbers of the system calls clock_nanosleep, getppid (planted) and restart_syscall on x86-64."""


@pytest.mark.parametrize(("method", "rate"), [("proxy", 1000), ("proxy", 4000), ("penalty", 1000)])
def test_real_time_loop_allocates_nothing_while_scenes_are_replaced(watched, method, rate):
    found = watched("realtime", method, str(rate), "2")
    assert found["ticks"] > rate
    assert found["swaps"] > 30
    assert found["contact_ticks"] > 30, "some ticks are in contact; their number depends on the machine"
    assert found["threads"] == [[0, 0, 0]], "allocations, releases, locks of the loop's thread"
    assert min(found["main"]) > 0, "control: the guard counts"
    assert found["last_force"] == [0.0, 0.0, 0.0], "the last force before the stop is zero"
    assert any(found["last_gravity"]), "gravity stays compensated"


def test_driver_of_a_haply_allocates_nothing_whatever_the_service_sends(watched):
    pytest.importorskip("websockets")
    found = watched("haply", "all", "0.5")
    assert found["exchanges"] > 300
    for fault, threads in found["calls"].items():
        assert threads, "the driver's thread and its watchdog"
        assert all(calls == [0, 0, 0] for calls in threads), (fault, threads)
    assert len(found["notices"]) >= 4, "the faults were met"
    assert min(found["control"]) > 0, "control: the guard counts"


@pytest.mark.parametrize("what", ["soft", "bodies", "linked"])
def test_what_steps_on_a_thread_beside_the_loop_allocates_nothing(watched, what):
    """A soft body, rigid ones, or the follower's end of a link whose other end is in the loop."""
    if what == "bodies":
        pytest.importorskip("mujoco")
    found = watched("beside", what)
    assert found["contact_ticks"] > 100
    assert found["nothing"] == [[0, 0, 0]] * 2, "the threads of the loop and of what is beside it"
    assert min(thread[0] for thread in found["allocation"]) > 5, "control: planted calls are found in both threads"


def test_loop_makes_no_system_call_but_its_sleep_and_planted_calls_are_found(watched, watch):
    found = watched("planted", "proxy", "1000", SYSCALL_WATCH=str(watch))
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


def test_collision_thread_of_the_paper_allocates_but_the_cycle_does_not(watched):
    """Coal allocates: a control that such calls are counted, and that they are outside the thread of the cycle."""
    found = watched("realtime", "paper-alg1", "1000", "2")
    clean = [t for t in found["threads"] if t == [0, 0, 0]]
    dirty = [t for t in found["threads"] if t[0] > 100]
    assert found["swaps"] > 30
    assert len(found["threads"]) == 2
    assert len(clean) == 1
    assert len(dirty) == 1
