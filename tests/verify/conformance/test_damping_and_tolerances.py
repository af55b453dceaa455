"""Wrong damping and wrong stiffness of any kind fail the judges of the conformance suite."""

from dataclasses import replace

import pytest

from palpate_lab.verify.conformance import activation, at_rest, bench, damping, master
from palpate_lab.verify.conformance.bench import Answer, Bench, Motion, fixture
from palpate_lab.verify.conformance.combinations import Combination
from palpate_lab.verify.conformance.laws import B_TURN, K_TURN, B, K

BALL = Combination("forbid", "sphere", "spring", "soft")
RCM = Combination("rcm", "point", "spring", "hard")
TURNS = Combination("orient against the normal", "sphere", "spring", "soft")
LAWS = [replace(c, law=law) for c in (BALL, TURNS) for law in ("spring", "potential", "optimise", "admittance")]
PATH = Combination("guide", "path", "admittance", "soft")
FEW = [
    *LAWS,
    *(replace(c, policy="hard") for c in (BALL, TURNS)),
    RCM,
    replace(RCM, law="admittance"),
    PATH,
    replace(PATH, geometry="sphere"),
]


def planted(monkeypatch, **law):
    """Every fixture of the benches has these options of the law."""
    monkeypatch.setattr(bench, "fixture", lambda c, **more: fixture(c, law=law, **more))


@pytest.mark.parametrize("share", [0.0, 0.5, 1.05])
@pytest.mark.parametrize("c", FEW, ids=str)
def test_damping_of_another_size_is_found(monkeypatch, c, share):
    assert damping.damping(c) == ""
    planted(monkeypatch, B=share * B, B_turn=share * B_TURN)
    assert "by its formula" in damping.damping(c)


@pytest.mark.parametrize("c", FEW, ids=str)
def test_damping_of_the_wrong_sign_is_found(monkeypatch, c):
    run = Bench.run
    monkeypatch.setattr(Bench, "run", lambda self, motion, *more: run(self, Motion(motion.X, -motion.V), *more))
    assert "by its formula" in damping.damping(c)


def test_damping_that_brakes_all_directions_alike_is_found(monkeypatch):
    """`admittance` with the ratio 1 does not distinguish free directions."""
    planted(monkeypatch, ratio=1.0)
    assert damping.damping(PATH)


@pytest.mark.parametrize("share", [0.95, 1.05])
@pytest.mark.parametrize(
    "c",
    [replace(c, law=law, policy=policy) for c in (BALL, TURNS, RCM) for law in ("spring", "optimise")
     for policy in ("soft", "hard", "hard, part of the authority")],
    ids=str,
)  # fmt: skip
def test_stiffness_that_is_wrong_by_5_percent_is_found(monkeypatch, c, share):
    assert at_rest.sign_and_direction(c) == ""
    planted(monkeypatch, K=share * K, K_turn=share * K_TURN)
    assert "by finite differences" in at_rest.sign_and_direction(c)


def test_goal_that_keeps_half_of_the_reserve_is_found(monkeypatch):
    c = replace(BALL, policy="hard")
    monkeypatch.setattr(at_rest, "Bench", lambda *given, **more: Bench(*given, **more, reserve=2.5e-5))
    assert "promised" in at_rest.sign_and_direction(c) or "by finite differences" in at_rest.sign_and_direction(c)


def test_soft_fixtures_solved_jointly_must_add(monkeypatch):
    c = replace(BALL, law="optimise")
    assert activation.policy(c) == ""
    run = Bench.run

    def exaggerated(self, *given):
        out = run(self, *given)
        return Answer(out.F * (1.02 if self.fixtures > 1 else 1.0), out.X, out.B)

    init = Bench.__init__

    def counted(self, c, *fixtures, **more):
        init(self, c, *fixtures, **more)
        self.fixtures = len(fixtures)

    monkeypatch.setattr(Bench, "__init__", counted)
    monkeypatch.setattr(Bench, "run", exaggerated)
    assert "priorities 0 and 0" in activation.policy(c)


def test_damping_matrix_that_is_not_symmetric_is_found(monkeypatch):
    c = replace(BALL, law="admittance")
    run = Bench.run

    def skewed(self, *given):
        out = run(self, *given)
        out.B[:, 0, 1] *= 1.5
        return out

    monkeypatch.setattr(Bench, "run", skewed)
    assert "not symmetric" in master.admittance_master(c)
