"""Places of the conformance suite: seeds, shares of rejected places, and what is judged at rejected places."""

from dataclasses import replace

import numpy as np
import pytest

from palpate import _core, _verify
from palpate_lab.verify.conformance import billing, combinations, drawn, examine, in_motion, rejected, sample, summary
from palpate_lab.verify.conformance.bench import DT, Answer, Bench, Motion
from palpate_lab.verify.conformance.combinations import Combination
from palpate_lab.verify.conformance.probes import POOL, pool, probes, rejected_poses
from palpate_lab.verify.conformance.run import CHECKS

EDGE = Combination("forbid", "box", "spring", "soft")
HARD = replace(EDGE, policy="hard")


def test_combinations_of_a_pair_together_are_judged_at_all_places():
    mine = [c for c in combinations() if (c.role, c.geometry) == ("forbid", "box")]
    first = {id(probes(c)[0]) for c in mine}
    assert len(first) == POOL == len(pool("forbid", "box", 0).violated)


def test_seeds_have_places_of_their_own():
    a, b = (probes(replace(EDGE, seed=seed))[0].X for seed in (0, 1))
    assert np.abs(a - b).max() > 1e-3


def test_two_samples_together_have_every_pair():
    pairs = {(c.role, c.geometry) for c in combinations() if not c.meaningless}
    one, two = ({(c.role, c.geometry) for c in sample(seed)} for seed in (1, 2))
    assert one | two == pairs
    assert not one & two
    assert 900 < len(sample(1)) * len(CHECKS) < 1200


def test_rejected_share_is_that_of_the_drawn_places():
    assert drawn("keep-in", "plane", 0) == (0.0, POOL)
    share, places = drawn("forbid, no margin", "box", 0)
    assert share > 0.4
    c = Combination("forbid, no margin", "box", "spring", "soft")
    row = summary({c: {"energy": "why"}}, {(c.role, c.geometry, 0): (share, places)})["pairs"]
    assert row == [{"role": c.role, "geometry": c.geometry, "rejected_share": share, "places": places,
                    "combinations": 1, "failed": 1}]  # fmt: skip


def test_combinations_of_boxes_have_an_axis():
    c = Combination("orient along the axis", "union of boxes", "spring", "soft")
    assert not c.meaningless
    assert examine(c) == {}


@pytest.mark.parametrize("c", [EDGE, HARD, replace(EDGE, law="admittance")], ids=str)
def test_rejected_places_pass(c):
    assert rejected_poses(c)
    assert rejected.rejected_places(c) == ""


def mutated(monkeypatch, change):
    run = Bench.run
    monkeypatch.setattr(Bench, "run", lambda self, *given: change(run(self, *given)))


def test_wrong_stiffness_at_rejected_places_is_found(monkeypatch):
    mutated(monkeypatch, lambda a: Answer(1.05 * a.F, a.X, a.B))
    assert "by finite differences" in rejected.rejected_places(EDGE)


def test_step_at_rejected_places_is_found(monkeypatch):
    def step(a):
        a.F[len(a.F) // 2 :, 1] += 0.1
        return a

    mutated(monkeypatch, step)
    assert "a step of" in rejected.rejected_places(HARD)


def test_energy_at_rejected_places_is_found(monkeypatch):
    """The force around an edge, which turns with the tool, comes 20 ticks early: that yields energy."""
    monkeypatch.setattr(rejected, "_step_failure", lambda *_: "")
    mutated(monkeypatch, lambda a: Answer(np.roll(a.F, -20, axis=0) if len(a.F) > 300 else a.F, a.X, a.B))
    assert "without the rate limit" in rejected.rejected_places(EDGE)


def test_entry_of_a_hard_goal_at_rejected_places_is_found(monkeypatch):
    monkeypatch.setattr(rejected, "_step_failure", lambda *_: "")
    run = Bench.run
    monkeypatch.setattr(Bench, "run", lambda self, motion, *more: replace(run(self, motion, *more), X=motion.X))
    assert "the goal enters" in rejected.rejected_places(HARD)


def pushed():
    """A force of 1 N along a circle of 3 mm, which gives 19 mJ in one turn, and that motion."""
    phase = np.linspace(0.0, 2.0 * np.pi, 401)
    X = np.tile(np.eye(4), (401, 1, 1))
    X[:, 0, 3], X[:, 1, 3] = 0.003 * np.cos(phase), 0.003 * np.sin(phase)
    V = np.zeros((401, 6))
    V[:, :2] = np.gradient(X[:, :2, 3], DT, axis=0)
    return V / np.linalg.norm(V, axis=1)[:, None], Motion(X, V)


def test_energy_that_is_not_withheld_is_found(monkeypatch):
    assert billing.billing_failure(*pushed()) == ""
    options = _core.StabilityOptions

    def without():
        o = options()
        o.passivity = "off"
        return o

    monkeypatch.setattr(_core, "StabilityOptions", without)
    assert "the passivity layer returns" in billing.billing_failure(*pushed())


@pytest.mark.parametrize("row", [0, 1])
def test_energy_that_is_not_billed_is_found(monkeypatch, row):
    """The ledger is given half of the wanted wrench, or half of the rendered one."""
    ledger = _verify.Ledger

    class Half:
        def __init__(self):
            self.ledger = ledger()

        def step(self, p, F, damping, cut, spring, R, source):
            return self.ledger.step(
                p, F * (0.5 if row else 1.0), damping, cut, spring, R, source * (1.0 if row else 0.5)
            )

    monkeypatch.setattr(_verify, "Ledger", Half)
    assert "in the ledger" in billing.billing_failure(*pushed())


def test_energy_of_the_rate_limit_alone_must_be_billed(monkeypatch):
    """A potential whose normal jumps inside a box: the rate limit yields energy there, which the ledger has."""
    c = Combination("keep-in", "box", "potential", "hard", seed=7)
    assert in_motion.energy(c) == ""
    monkeypatch.setattr(in_motion, "billing_failure", lambda *_: "not billed")
    assert in_motion.energy(c) == "not billed"
