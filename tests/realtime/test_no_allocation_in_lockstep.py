"""A cycle that is called step by step neither allocates nor frees memory and takes no lock: heap_guard.cpp counts.

No loop runs in real time here, so these tests may run beside others.
"""

from importlib.util import find_spec

import pytest

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
    *(["bodies"] if find_spec("mujoco") else []),
)


@pytest.fixture(scope="module")
def lockstep(watched):
    """Counts of all cases from one process."""
    return watched("lockstep", "proxy", *CASES)


@pytest.mark.parametrize("case", CASES)
def test_lockstep_tick_with_plant_allocates_nothing(lockstep, case):
    """A call takes a few allocations of Python and numpy, the same number for 7, 700 or 2000 ticks."""
    found = lockstep[case]
    first, *rest = found["calls"][1:]
    assert found["contact_ticks"] > 1000
    assert rest == [first] * len(rest)
    assert first[0] > 0, "control: the allocations of the call are counted"


ROBOTS = ("following", "impedance", "moving", "carried")


@pytest.fixture(scope="module")
def robots(watched):
    """Counts of all cases from one process."""
    return watched("robot", *ROBOTS)


@pytest.mark.parametrize("case", ROBOTS)
def test_simulated_dvrk_allocates_nothing(robots, case):
    """The only allocations are those of the call and of the release of the interpreter lock."""
    found = robots[case]
    first, *rest = found["calls"][1:]
    assert found["following"] == (case == "following")
    assert rest == [first] * len(rest)


def test_geometry_query_allocates_nothing(watched):
    for name, calls in watched("geometries", "all").items():
        first, *rest = calls[1:]
        assert rest == [first] * len(rest), name
        assert first[0] > 0, "control: the allocations of the call are counted"


def test_cycle_of_networked_devices_allocates_nothing(watched):
    found = watched("crtk", "all")
    assert found["contact_ticks"] >= 2
    counts = found["counts"]
    assert counts["no scene"][0][0] > 0, "control: the allocations of a call are counted"
    for name in ("free", "pressed", "bad stamps", "recovered"):
        assert counts[name] == counts["no scene"], f"{name}: each of 500 steps"
    assert counts["planted"] != counts["no scene"], "control: an allocation in five of 500 steps is found"


@pytest.mark.parametrize("what", ["alone", "linked"])
def test_cycle_of_a_device_allocates_nothing(watched, what):
    found = watched("device", what)
    assert found["contact_ticks"] > 1000
    assert (found["linked_ticks"] > 1000) == (what == "linked")
    assert found["control"][0] > 0, "the allocations of a call that returns an array are counted"
    for name, calls in found["calls"].items():
        assert [allocations for allocations, *_ in calls[1:]] == [0, 0, 0], name
        assert calls[2:] == calls[1:2] * 2, (
            f"{name}: releases and locks are those of the call, not of its 200 to 2000 steps"
        )
