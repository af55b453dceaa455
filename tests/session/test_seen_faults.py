"""Counts of faults in the status of ticks."""

import numpy as np

from palpate.record.ticks import STATUS, TICK
from palpate.session.faults import NO_FAULTS, SeenFaults


def ticks(*statuses):
    made = np.zeros(len(statuses), TICK)
    made["t"] = 0.001 * np.arange(len(statuses))
    made["status"] = [sum(STATUS[name][0] for name in names) for names in statuses]
    return made


def test_first_time_and_number_of_each_fault_over_several_calls():
    faults = SeenFaults()
    faults.take(ticks((), ("leader_stale",), ("leader_stale", "not_finite")))
    faults.take(ticks(("leader_stale",)))
    assert {name: (one.first, one.ticks) for name, one in faults.seen.items()} == {
        "leader_stale": (0.001, 3),
        "not_finite": (0.002, 1),
    }
    assert f"{STATUS['leader_stale'][1]} (first at t = 0.001 s, 3 ticks)" in faults.words()


def test_ordinary_conditions_are_no_faults():
    for name in STATUS:
        faults = SeenFaults()
        faults.take(ticks((name,)))
        assert bool(faults.seen) == (name not in NO_FAULTS)
