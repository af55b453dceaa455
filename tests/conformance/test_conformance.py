"""The conformance suite: a seeded handful of its combinations, and proof that its judges can fail."""

import numpy as np
import pytest

from palpate import _core
from palpate.conformance import checks, combinations, entry, examine, judges, summary
from palpate.conformance.combinations import POLICIES, Combination, unjudged
from palpate.conformance.specimens import SPECIMENS

FEW = 48
ALL = combinations()
MEANT = [c for c in ALL if not c.meaningless]


def test_every_role_law_geometry_and_policy_of_the_core_is_in_it():
    assert unjudged() == []
    assert {judges.ROLES[c.role].role for c in ALL} == set(_core.guidance_roles())
    assert {c.law for c in ALL} == set(_core.guidance_laws())
    assert len(ALL) == len(judges.ROLES) * len(SPECIMENS) * len(judges.LAWS) * len(POLICIES)


@pytest.mark.parametrize("name", SPECIMENS)
def test_distances_are_those_of_the_formulas(name):
    s = SPECIMENS[name]
    p = np.random.default_rng(5).uniform(-0.03, 0.03, (40, 3))
    X = np.tile(np.eye(4), (len(p), 1, 1))
    X[:, :3, 3] = p
    geometry = s.make()
    assert geometry.solid == s.solid
    np.testing.assert_allclose(geometry.query(X, np.zeros(len(p)))["distance"], s.distance(p), atol=s.near)


def some():
    """Thinned with a seed, every role with every law at least once."""
    rng = np.random.default_rng(2)
    chosen = {(c.role, c.law): c for c in (MEANT[i] for i in rng.permutation(len(MEANT)))}
    rest = [MEANT[i] for i in rng.choice(len(MEANT), FEW, replace=False)]
    return list(dict.fromkeys([*chosen.values(), *rest]))[:FEW]


@pytest.mark.parametrize("c", some(), ids=str)
def test_combination(c):
    assert examine(c) == {}


def test_what_has_no_meaning_is_refused_and_counts_as_examined():
    without = [c for c in ALL if c.meaningless]
    assert len(without) > 100
    for c in without[:: len(without) // 20]:
        assert examine(c) == {}
        assert "has no inside" in c.meaningless
    told = summary({}, without)
    assert told["passed"] == told["combinations"] == told["refused"] == len(without)


SOFT = Combination("forbid", "sphere", "spring", "soft")


def test_a_wrong_sign_is_found(monkeypatch):
    run = checks.Bench.run
    monkeypatch.setattr(checks.Bench, "run", lambda self, m: checks.Answer(-(a := run(self, m)).F, a.X))
    assert set(examine(SOFT)) >= {"sign and direction"}


def test_a_step_is_found(monkeypatch):
    run = checks.Bench.run

    def stepping(self, motion):
        answer = run(self, motion)
        answer.F[len(answer.F) // 2 :, 0] += 0.3
        return answer

    monkeypatch.setattr(checks.Bench, "run", stepping)
    assert set(examine(SOFT)) >= {"continuity", "live edit"}


def test_energy_out_of_nothing_is_found(monkeypatch):
    """A spring that comes late gives energy: here by 40 ticks."""
    run = checks.Bench.run

    def late(self, motion):
        answer = run(self, motion)
        return checks.Answer(np.roll(answer.F, 40, axis=0), answer.X)

    monkeypatch.setattr(checks.Bench, "run", late)
    assert set(examine(SOFT)) >= {"energy"}


def test_the_tool_stays_out_of_hard_regions_and_goes_into_soft_ones_as_certified(monkeypatch):
    monkeypatch.setattr(entry, "REGIONS", ("sphere", "box"))
    monkeypatch.setattr(entry, "SEEDS", 1)
    hard, soft = entry.hard(), entry.soft()
    assert entry.passed(hard, soft), (hard, soft)
    assert not entry.passed([{**hard[0], "entry_mm": 0.2}], soft)
    assert not entry.passed([{**hard[0], "held_share": 0.0}], soft)
    assert not entry.passed(hard, [{**soft[0], "measured_mm": 1.1 * soft[0]["certified_mm"]}])
