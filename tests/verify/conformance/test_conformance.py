"""The conformance suite: a seeded handful of its combinations, and proof that each of its judges can fail."""

from dataclasses import replace

import numpy as np
import pytest

from palpate import _core, guidance
from palpate.scene.rig import build
from palpate.verify.conformance import (
    activation,
    at_rest,
    combinations,
    entry,
    examine,
    in_motion,
    live,
    master,
    roles,
    summary,
)
from palpate.verify.conformance.bench import Answer, Bench, fixture
from palpate.verify.conformance.combinations import POLICIES, Combination, unjudged
from palpate.verify.conformance.laws import LAWS
from palpate.verify.conformance.run import CHECKS, NO_JUDGE
from palpate.verify.conformance.specimens import SPECIMENS

FEW = 40
ALL = combinations()
MEANT = [c for c in ALL if not c.meaningless]
SOFT = Combination("forbid", "sphere", "spring", "soft")


def test_every_role_law_geometry_and_policy_of_the_core_is_in_it():
    assert unjudged() == []
    assert {roles.ROLES[c.role].role for c in ALL} == set(_core.guidance_roles())
    assert {c.law for c in ALL} == set(_core.guidance_laws())
    assert len(ALL) == len(roles.ROLES) * len(SPECIMENS) * len(LAWS) * len(POLICIES)
    assert set(activation.JUDGES) == set(POLICIES)


@pytest.mark.parametrize("name", SPECIMENS)
def test_distances_and_axes_are_those_of_the_formulas(name):
    s = SPECIMENS[name]
    p = np.random.default_rng(5).uniform(-0.03, 0.03, (40, 3))
    X = np.tile(np.eye(4), (len(p), 1, 1))
    X[:, :3, 3] = p
    geometry = s.make()
    assert geometry.solid == s.solid
    told = geometry.query(X, np.zeros(len(p)))
    np.testing.assert_allclose(told["distance"], s.distance(p), atol=s.near)
    np.testing.assert_allclose(told["attitude"][:, :, 2], [s.axis(one) for one in p], atol=1e-6)


def some():
    """Thinned with a seed, every role with every law at least once."""
    rng = np.random.default_rng(2)
    chosen = {(c.role, c.law): c for c in (MEANT[i] for i in rng.permutation(len(MEANT)))}
    rest = [MEANT[i] for i in rng.choice(len(MEANT), FEW, replace=False)]
    return list(dict.fromkeys([*chosen.values(), *rest]))[: len(chosen) + FEW]


@pytest.mark.parametrize("c", some(), ids=str)
def test_combination(c):
    assert examine(c) == {}


def test_what_has_no_meaning_is_refused_and_counts_neither_as_judged_nor_as_passed():
    without = [c for c in ALL if c.meaningless]
    assert len(without) > 100
    few = without[:: len(without) // 20]
    found = {c: examine(c) for c in few}
    assert not any(found.values())
    three = {SOFT: {}, replace(SOFT, policy="hard"): {NO_JUDGE: "why"}, replace(SOFT, law="x"): {"e": "f"}}
    told = summary(found | three)
    assert (told["combinations"], told["passed"], told["refused"]) == (3, 1, len(few))
    assert told["unjudged"] == [f"{replace(SOFT, policy='hard')}: why"]


def mutated(monkeypatch, change):
    """Every answer of the bench goes through `change` first."""
    run = Bench.run
    monkeypatch.setattr(Bench, "run", lambda self, *given: change(run(self, *given)))


def test_a_wrong_sign_is_found(monkeypatch):
    mutated(monkeypatch, lambda a: Answer(-a.F, a.X, a.B))
    assert at_rest.sign_and_direction(SOFT)


def test_a_wrong_moment_beside_a_right_force_is_found(monkeypatch):
    mutated(monkeypatch, lambda a: Answer(a.F * [0, 0, 0, 1, 1, 1], a.X, a.B))
    assert at_rest.sign_and_direction(Combination("rcm", "point", "spring", "soft"))
    assert at_rest.sign_and_direction(Combination("orient against the normal", "sphere", "spring", "soft"))


def test_a_wrench_that_does_not_stand_still_is_found(monkeypatch):
    mutated(monkeypatch, lambda a: Answer(a.F * (1.0 + 0.1 * (np.arange(len(a.F)) % 2))[:, None], a.X, a.B))
    assert at_rest.steady(SOFT)


def test_a_step_on_the_way_is_found(monkeypatch):
    def step(a):
        a.F[len(a.F) // 2 :, 0] += 0.3
        return a

    mutated(monkeypatch, step)
    assert in_motion.continuity(SOFT)


def test_a_stiffness_that_flips_is_found(monkeypatch):
    """From 0 to K and back at every tick: the limit of the wrench's rate must not hide it."""
    mutated(monkeypatch, lambda a: Answer(a.F * (np.arange(len(a.F)) % 2)[:, None], a.X, a.B))
    assert in_motion.continuity(SOFT)


def test_energy_out_of_nothing_is_found(monkeypatch):
    """A spring that comes late gives energy: here by 40 ticks."""
    mutated(monkeypatch, lambda a: Answer(np.roll(a.F, 40, axis=0), a.X, a.B))
    assert in_motion.energy(SOFT)


def test_a_moment_without_its_force_makes_energy(monkeypatch):
    """Of orient against a sphere: over loops of place and attitude only both together are a gradient."""
    c = Combination("orient against the normal", "sphere", "spring", "soft")
    assert in_motion.energy(c) == ""
    mutated(monkeypatch, lambda a: Answer(a.F * [0, 0, 0, 1, 1, 1], a.X, a.B))
    assert in_motion.energy(c)


def elsewhere(monkeypatch, change):
    """Answers of a bench whose geometry is at X_WG, and they alone, go through `change` first."""
    run = Bench.run

    def spoilt(self, motion, X_WG=None):
        out = run(self, motion, X_WG)
        return out if X_WG is None else change(out, X_WG)

    monkeypatch.setattr(Bench, "run", spoilt)


def test_a_wrench_that_is_not_carried_to_another_frame_is_found(monkeypatch):
    assert at_rest.frame_change(SOFT) == ""
    elsewhere(monkeypatch, lambda a, X: Answer(a.F @ np.kron(np.eye(2), X[:3, :3]), a.X, a.B))
    assert "here" in at_rest.frame_change(SOFT)


def test_a_geometry_that_leaves_its_attitude_behind_is_found(monkeypatch):
    """A box that goes to another place and is not turned there."""
    c = replace(SOFT, geometry="box")
    assert at_rest.frame_change(c) == ""

    def unturned(c, X_WG):
        X = np.eye(4)
        X[:3, 3] = X_WG[:3, 3]
        return fixture(c, X_WG=X)

    monkeypatch.setattr(at_rest, "fixture", unturned)
    assert at_rest.frame_change(c)


def test_a_corrected_goal_that_is_not_carried_to_another_frame_is_found(monkeypatch):
    c = replace(SOFT, policy="hard")
    assert at_rest.frame_change(c) == ""
    shift = np.zeros((4, 4))
    shift[0, 3] = 0.01
    elsewhere(monkeypatch, lambda a, X: Answer(a.F, a.X + shift, a.B))
    assert at_rest.frame_change(c) == "the goal is corrected otherwise in another frame"


def test_a_fixture_that_stays_where_its_frame_was_is_found(monkeypatch):
    assert in_motion.moving(SOFT) == ""
    monkeypatch.setattr(in_motion, "fixture", lambda c, frame=None, law=None: fixture(c, law=law))
    assert "of the same at rest" in in_motion.moving(SOFT)


def test_damping_against_a_fixture_whose_velocity_is_ignored_is_found(monkeypatch):
    """The hand is told to rest in the world while it is carried along: what is felt is the fixture's own speed."""
    assert in_motion.moving(SOFT) == ""
    carried = in_motion.Motion.carried
    monkeypatch.setattr(in_motion.Motion, "carried", lambda self, X, V=None: carried(self, X))
    assert "of the same at rest" in in_motion.moving(SOFT)


def test_a_law_of_motions_that_pushes_whom_it_carries_is_found(monkeypatch):
    c = replace(SOFT, law="admittance")
    assert in_motion.moving(c) == ""
    velocity = in_motion._carriage()[2]
    elsewhere(monkeypatch, lambda a, X: Answer(a.F + 2.0 * velocity[-len(a.F) :], a.X, a.B))
    assert "W to a hand that it carries" in in_motion.moving(c)


def test_a_corrected_goal_that_does_not_move_along_is_found(monkeypatch):
    c = replace(SOFT, policy="hard")
    assert in_motion.moving(c) == ""
    elsewhere(monkeypatch, lambda a, X: Answer(a.F, np.repeat(a.X[-1:], len(a.X), axis=0), a.B))
    assert in_motion.moving(c) == "its corrected goal does not move along"


@pytest.mark.parametrize(
    "c", [SOFT, replace(SOFT, law="potential"), Combination("orient along the axis", "line", "spring", "soft")]
)
def test_edits_are_steps_where_nothing_limits_the_rate(monkeypatch, c):
    """The limit gone, every edit is a step; the policy's ramp gone, a switch is one though the rate is limited."""
    assert not live.live_edit(replace(c, law="potential"))
    monkeypatch.setattr(live, "Bench", lambda *given, **more: Bench(*given, **more | {"quick": True}))
    assert "a step of" in live.live_edit(c)


def test_a_switch_that_is_faster_than_rise_and_fall_is_found(monkeypatch):
    monkeypatch.setattr(live, "fixture", lambda *given, **more: fixture(*given, **more | {"rise": 0.02}))
    assert "at rest, switched on: a step of" in live.live_edit(SOFT)


@pytest.mark.parametrize("name", POLICIES)
def test_a_policy_that_does_nothing_is_found(monkeypatch, name):
    """With another policy in its place each judge of a policy complains; of two, when this one comes last."""
    c = replace(SOFT, policy=name)
    assert activation.policy(c) == ""
    other = "part of the authority" if name in ("soft", "hard", "first of two") else "soft"
    plain = replace(c, policy=other)
    monkeypatch.setattr(activation, "Bench", lambda c, *given, **more: Bench(c, *(given or [fixture(plain)]), **more))
    last = {"policy": replace(POLICIES[name], priority=-5, hard=False)}
    monkeypatch.setattr(activation, "fixture", lambda c, **more: fixture(c, **more | last))
    assert activation.policy(c) != ""


def test_damping_that_is_felt_twice_is_found(monkeypatch):
    c = replace(SOFT, law="admittance")
    assert master.admittance_master(c) == ""
    mutated(monkeypatch, lambda a: Answer(a.F * (2.0 if a.B.any() else 1.0), a.X, a.B))
    assert "the two masters" in master.admittance_master(c)


def test_each_property_is_looked_at():
    names = "sign and direction, quiet, continuity, energy, frame change, moving, live edit, policy, admittance master"
    assert ", ".join(CHECKS) == names


def test_the_tool_stays_out_of_hard_regions_and_goes_into_soft_ones_as_certified(monkeypatch):
    few = ("floor that breathes", "planes of any tilt", "inside of a sphere of 2 cm", "box")
    monkeypatch.setattr(entry, "REGIONS", {name: entry.REGIONS[name] for name in few})
    told = [{"region": r, "fixture": f, **entry.hard(r, 0, f)} for r in entry.REGIONS for f in (True, False)]
    hard, soft = entry.hard_rows(told), [entry.soft(2.0)]
    assert entry.passed(hard, soft), (hard, soft)
    for wrong in ({"entry_mm": 0.2}, {"held_share": 0.0}, {"entry_without_mm": 1.0}):
        assert not entry.passed([{**hard[0], **wrong}], soft)
    for key in ("measured_mm", "certified_N_per_m"):
        assert not entry.passed(hard, [{**soft[0], key: 1.1 * soft[0][key]}])


def test_a_region_is_judged_where_it_has_breathed_to_and_as_it_lies():
    """Against the core's own answer, for poses and times of all kinds."""
    rng = np.random.default_rng(6)
    for region in entry.REGIONS.values():
        X_WG, t = region.pose(np.array([0.01, 0.02, 0.03]), rng), rng.uniform(0.0, 3.0, 20)
        p, f = X_WG[:3, 3] + rng.uniform(-0.02, 0.02, (20, 3)), region.fixture(X_WG, True)
        X = np.tile(np.eye(4), (20, 1, 1))
        X[:, :3, 3] = p
        gap = [f.ask(one, when)["gap"] for one, when in zip(X, t, strict=True)]
        here = (p - region.shift(t) - X_WG[:3, 3]) @ X_WG[:3, :3]
        np.testing.assert_allclose(region.outside(here), gap, atol=2e-5)


def test_the_certified_stiffness_is_measured_and_not_the_number_of_the_file(monkeypatch):
    """With a law that gives a tenth more than it says the certificate sees it, and tells the entry accordingly."""
    rig, wall = entry._pressed()
    scene = entry._scene(guidance=[rig.scene.guidance[0].model_copy(update={"law": guidance.Law(stiffness=440.0)})])
    monkeypatch.setattr(entry, "_pressed", lambda: (build(scene), wall))
    entry._certified.cache_clear()
    told = entry.soft(2.0)
    entry._certified.cache_clear()
    assert told["certified_N_per_m"] == pytest.approx(440.0, rel=0.01)
    assert told["measured_mm"] == pytest.approx(told["certified_mm"], rel=entry.WITHIN)
    assert not entry.passed([], [told])
