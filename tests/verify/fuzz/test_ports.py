"""`palpate fuzz ports`: sound code passes; each judge rejects a planted fault."""

import numpy as np
import pytest

from palpate.cli import main
from palpate.sensing.trackers import gate as tracker_gate
from palpate_lab.verify import fuzz
from palpate_lab.verify.fuzz import FaultError, ports
from palpate_lab.verify.fuzz.ports import node, openigtlink, simulator, viewer


def first_fault(case, cases=30):
    for seed in range(cases):
        try:
            case(np.random.default_rng(seed), 100, False)
        except FaultError as fault:
            return str(fault)
    return ""


def test_the_same_seed_sends_the_same_messages():
    counts = [ports.case(seed) for seed in range(8)]
    assert counts == [ports.case(seed) for seed in range(8)]
    assert {one["messages"] for one in counts} == {ports.MESSAGES}


def test_no_message_crosses_a_limit():
    outcome = fuzz.run("ports", 120, 31)
    assert not outcome.faults, outcome.faults
    assert outcome.counts["messages"] == 120 * ports.MESSAGES, "also where a socket carries a few of them"
    assert outcome.counts["by sockets"] > 0
    for name in ("node", "simulator", "openigtlink", "viewer"):
        assert outcome.counts[f"{name} messages"] > 500


def test_a_force_that_jumps_is_found(monkeypatch):
    class Jumps:
        def __init__(self, cycle):
            self.cycle = cycle

        def __getattr__(self, name):
            return getattr(self.cycle, name)

        def step(self, t, wall):
            row, wrench, goal, jaw = self.cycle.step(t, wall)
            return row, None if wrench is None else 1.2 * wrench, goal, jaw

    made = node._Node.__init__

    def planted(self, rng):
        made(self, rng)
        self.cycle = Jumps(self.cycle)

    monkeypatch.setattr(node._Node, "__init__", planted)
    assert "the force grew" in first_fault(node.case)


def test_a_measurement_that_is_not_finite_is_found(monkeypatch):
    class Robot:
        arms = ("MTMR",)

        def __getattr__(self, name):
            return lambda *arguments: True

        def state(self, arm):
            found = {name: np.zeros(6) for name in ("measured_cp", "measured_cv", "measured_cf")}
            found["measured_cv"][2] = np.nan
            return found | {"joints_valid": False, "cartesian_valid": True, "measured_js": {}}

    monkeypatch.setattr(simulator.dvrk, "system", lambda arms: Robot())
    assert "not finite" in first_fault(simulator.case, 1)


def test_a_pose_that_is_trusted_though_not_rigid_is_found(monkeypatch):
    def trusting(self, seen, now):
        self.X = seen.X
        return True

    monkeypatch.setattr(tracker_gate.Gate, "take", trusting)
    assert "not rigid" in first_fault(openigtlink.case)


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("palpate.viewer.gate._is_loopback", ["served"]),
        ("palpate.viewer.page.is_sound", ["controls have", "exchanged"]),
    ],
)
def test_a_viewer_that_believes_strangers_is_found(monkeypatch, place, words):
    monkeypatch.setattr(place, lambda *arguments: True)
    viewer._server.cache_clear()
    found = first_fault(viewer.case)
    viewer._server.cache_clear()
    assert any(word in found for word in words), found


def test_cases_count_messages(capsys):
    assert main(["fuzz", "ports", "--cases", "250", "--seed", "77"]) == 0
    assert "3 cases" in capsys.readouterr().out
    assert main(["fuzz", "contact", "--cases", "250"]) == 2
