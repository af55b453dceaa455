"""The conformance suite: a random sample of its combinations, and proof that each of its checks can fail."""

from dataclasses import replace

import numpy as np
import pytest

from palpate import _guidance
from palpate.scene import guidance
from palpate.scene.rig import build
from palpate_lab.verify.conformance import (
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
from palpate_lab.verify.conformance.bench import Answer, Bench, fixture
from palpate_lab.verify.conformance.combinations import POLICIES, Combination, unjudged
from palpate_lab.verify.conformance.laws import LAWS
from palpate_lab.verify.conformance.run import CHECKS, NO_JUDGE
from palpate_lab.verify.conformance.specimens import SPECIMENS

FEW = 8
ALL = combinations()
MEANT = [c for c in ALL if not c.meaningless]
SOFT = Combination("forbid", "sphere", "spring", "soft")


def test_every_role_law_geometry_and_policy_of_the_core_is_included():
    assert unjudged() == []
    assert {roles.ROLES[c.role].role for c in ALL} == set(_guidance.guidance_roles())
    assert {c.law for c in ALL} == set(_guidance.guidance_laws())
    assert len(ALL) == len(roles.ROLES) * len(SPECIMENS) * len(LAWS) * len(POLICIES)
    assert set(activation.JUDGES) == set(POLICIES)


@pytest.mark.parametrize("name", SPECIMENS)
def test_distances_and_axes_agree_with_the_formulas(name):
    s = SPECIMENS[name]
    p = np.random.default_rng(5).uniform(-0.03, 0.03, (40, 3))
    X = np.tile(np.eye(4), (len(p), 1, 1))
    X[:, :3, 3] = p
    geometry = s.make()
    assert geometry.solid == s.solid
    found = geometry.query(X, np.zeros(len(p)))
    np.testing.assert_allclose(found["distance"], s.distance(p), atol=s.near)
    np.testing.assert_allclose(found["attitude"][:, :, 2], [s.axis(one) for one in p], atol=1e-6)


def sampled():
    """A random sample with a fixed seed, which has every role with every law, at the places of ten seeds."""
    rng = np.random.default_rng(2)
    chosen = {(c.role, c.law): c for c in (MEANT[i] for i in rng.permutation(len(MEANT)))}
    rest = [MEANT[i] for i in rng.choice(len(MEANT), FEW, replace=False)]
    found = list(dict.fromkeys([*chosen.values(), *rest]))[: len(chosen) + FEW]
    return [replace(c, seed=k % 10) for k, c in enumerate(found)]


SAMPLE = sampled()


def values(c):
    return {(name, getattr(c, name)) for name in ("role", "law", "geometry", "policy")}


def short():
    """A few of the sample that together have every role, law, geometry and policy; the others run long.

    Each has the most new values for its time: roles that orient the tool take three times as long as the others.
    """
    left, chosen = set().union(*map(values, SAMPLE)), set()
    while left:
        best = max(SAMPLE, key=lambda c: len(values(c) & left) / (3 if c.role.startswith("orient") else 1))
        left -= values(best)
        chosen.add(best)
    return chosen


SHORT = short()


def test_short_sample_has_every_role_law_geometry_and_policy():
    for name, known in (("role", roles.ROLES), ("law", LAWS), ("geometry", SPECIMENS), ("policy", POLICIES)):
        assert {getattr(c, name) for c in SHORT} == {getattr(c, name) for c in SAMPLE} <= set(known)


@pytest.mark.parametrize(
    "c", [pytest.param(c, id=str(c), marks=[] if c in SHORT else pytest.mark.long) for c in SAMPLE]
)
def test_combination_passes(c):
    assert examine(c) == {}


def test_meaningless_combinations_are_refused_and_not_counted():
    without = [c for c in ALL if c.meaningless]
    assert len(without) > 100
    few = without[:: len(without) // 20]
    found = {c: examine(c) for c in few}
    assert not any(found.values())
    three = {SOFT: {}, replace(SOFT, policy="hard"): {NO_JUDGE: "why"}, replace(SOFT, law="x"): {"e": "f"}}
    totals = summary(found | three)
    assert (totals["combinations"], totals["passed"], totals["refused"]) == (3, 1, len(few))
    assert totals["unjudged"] == [f"{replace(SOFT, policy='hard')}: why"]


def mutated(monkeypatch, change):
    """Replace every result of the bench by `change` of it."""
    run = Bench.run
    monkeypatch.setattr(Bench, "run", lambda self, *given: change(run(self, *given)))


def test_wrong_sign_is_found(monkeypatch):
    mutated(monkeypatch, lambda a: Answer(-a.F, a.X, a.B))
    assert at_rest.sign_and_direction(SOFT)


def test_wrong_moment_with_a_right_force_is_found(monkeypatch):
    mutated(monkeypatch, lambda a: Answer(a.F * [0, 0, 0, 1, 1, 1], a.X, a.B))
    assert at_rest.sign_and_direction(Combination("rcm", "point", "spring", "soft"))
    assert at_rest.sign_and_direction(Combination("orient against the normal", "sphere", "spring", "soft"))


def test_unsettled_wrench_is_found(monkeypatch):
    mutated(monkeypatch, lambda a: Answer(a.F * (1.0 + 0.1 * (np.arange(len(a.F)) % 2))[:, None], a.X, a.B))
    assert at_rest.steady(SOFT)


def test_step_during_a_motion_is_found(monkeypatch):
    def step(a):
        a.F[len(a.F) // 2 :, 0] += 0.3
        return a

    mutated(monkeypatch, step)
    assert in_motion.continuity(SOFT)


def test_alternating_stiffness_is_found(monkeypatch):
    """A stiffness that alternates between 0 and K at every tick is found despite the rate limit."""
    mutated(monkeypatch, lambda a: Answer(a.F * (np.arange(len(a.F)) % 2)[:, None], a.X, a.B))
    assert in_motion.continuity(SOFT)


def test_energy_gain_is_found(monkeypatch):
    """A spring delayed by 40 ticks generates energy."""
    mutated(monkeypatch, lambda a: Answer(np.roll(a.F, 40, axis=0), a.X, a.B))
    assert in_motion.energy(SOFT)


def test_moment_without_its_force_is_found(monkeypatch):
    """Orient against a sphere: on loops of position and attitude only force and moment together are a gradient."""
    c = Combination("orient against the normal", "sphere", "spring", "soft")
    assert in_motion.energy(c) == ""
    mutated(monkeypatch, lambda a: Answer(a.F * [0, 0, 0, 1, 1, 1], a.X, a.B))
    assert in_motion.energy(c)


def mutated_in_another_frame(monkeypatch, change):
    """Replace the results of benches with a geometry at X_WG by `change` of them."""
    run = Bench.run

    def changed(self, motion, X_WG=None):
        out = run(self, motion, X_WG)
        return out if X_WG is None else change(out, X_WG)

    monkeypatch.setattr(Bench, "run", changed)


def test_wrench_not_transformed_to_another_frame_is_found(monkeypatch):
    assert at_rest.frame_change(SOFT) == ""
    mutated_in_another_frame(monkeypatch, lambda a, X: Answer(a.F @ np.kron(np.eye(2), X[:3, :3]), a.X, a.B))
    assert "here" in at_rest.frame_change(SOFT)


def test_geometry_without_the_rotation_of_its_frame_is_found(monkeypatch):
    """A box that is moved but not rotated."""
    c = replace(SOFT, geometry="box")
    assert at_rest.frame_change(c) == ""

    def unrotated(c, X_WG):
        X = np.eye(4)
        X[:3, 3] = X_WG[:3, 3]
        return fixture(c, X_WG=X)

    monkeypatch.setattr(at_rest, "fixture", unrotated)
    assert at_rest.frame_change(c)


def test_goal_not_transformed_to_another_frame_is_found(monkeypatch):
    c = replace(SOFT, policy="hard")
    assert at_rest.frame_change(c) == ""
    shift = np.zeros((4, 4))
    shift[0, 3] = 0.01
    mutated_in_another_frame(monkeypatch, lambda a, X: Answer(a.F, a.X + shift, a.B))
    assert at_rest.frame_change(c) == "the goal is corrected otherwise in another frame"


def test_fixture_that_does_not_follow_its_frame_is_found(monkeypatch):
    assert in_motion.moving(SOFT) == ""
    monkeypatch.setattr(in_motion, "fixture", lambda c, frame=None, law=None: fixture(c, law=law))
    assert "of the same at rest" in in_motion.moving(SOFT)


def test_damping_without_the_velocity_of_the_fixture_is_found(monkeypatch):
    """The hand moves with the fixture but is given zero velocity, so the damping is that of the fixture's speed."""
    assert in_motion.moving(SOFT) == ""
    carried = in_motion.Motion.carried
    monkeypatch.setattr(in_motion.Motion, "carried", lambda self, X, V=None: carried(self, X))
    assert "of the same at rest" in in_motion.moving(SOFT)


def test_admittance_force_on_a_hand_that_moves_along_is_found(monkeypatch):
    c = replace(SOFT, law="admittance")
    assert in_motion.moving(c) == ""
    velocity = in_motion._carriage()[2]
    mutated_in_another_frame(monkeypatch, lambda a, X: Answer(a.F + 2.0 * velocity[-len(a.F) :], a.X, a.B))
    assert "W to a hand that it carries" in in_motion.moving(c)


def test_goal_that_does_not_move_along_is_found(monkeypatch):
    c = replace(SOFT, policy="hard")
    assert in_motion.moving(c) == ""
    mutated_in_another_frame(monkeypatch, lambda a, X: Answer(a.F, np.repeat(a.X[-1:], len(a.X), axis=0), a.B))
    assert in_motion.moving(c) == "its corrected goal does not move along"


@pytest.mark.parametrize(
    "c", [SOFT, replace(SOFT, law="potential"), Combination("orient along the axis", "line", "spring", "soft")]
)
def test_edits_without_a_rate_limit_are_steps(monkeypatch, c):
    """Without the rate limit every edit is a step."""
    assert not live.live_edit(replace(c, law="potential"))
    monkeypatch.setattr(live, "Bench", lambda *given, **more: Bench(*given, **more | {"quick": True}))
    assert "a step of" in live.live_edit(c)


def test_switch_faster_than_rise_and_fall_is_found(monkeypatch):
    monkeypatch.setattr(live, "fixture", lambda *given, **more: fixture(*given, **more | {"rise": 0.02}))
    assert "at rest, switched on: a step of" in live.live_edit(SOFT)


@pytest.mark.parametrize("name", POLICIES)
def test_policy_without_effect_is_found(monkeypatch, name):
    """The check of a policy fails with another policy, and for two fixtures with the wrong order."""
    c = replace(SOFT, policy=name)
    assert activation.policy(c) == ""
    other = "part of the authority" if name in ("soft", "hard", "first of two") else "soft"
    plain = replace(c, policy=other)
    monkeypatch.setattr(activation, "Bench", lambda c, *given, **more: Bench(c, *(given or [fixture(plain)]), **more))
    last = {"policy": replace(POLICIES[name], priority=-5, hard=False)}
    monkeypatch.setattr(activation, "fixture", lambda c, **more: fixture(c, **more | last))
    assert activation.policy(c) != ""


def test_damping_applied_twice_is_found(monkeypatch):
    c = replace(SOFT, law="admittance")
    assert master.admittance_master(c) == ""
    mutated(monkeypatch, lambda a: Answer(a.F * (2.0 if a.B.any() else 1.0), a.X, a.B))
    assert "the two masters" in master.admittance_master(c)


def test_each_property_is_checked():
    names = (
        "sign and direction, quiet, damping, continuity, energy, frame change, moving, live edit, rejected places, "
        "policy, admittance master"
    )
    assert ", ".join(CHECKS) == names


def test_tool_stays_outside_hard_regions_and_enters_soft_ones_as_certified(monkeypatch):
    few = ("floor that breathes", "planes of any tilt", "inside of a sphere of 2 cm", "box")
    monkeypatch.setattr(entry, "REGIONS", {name: entry.REGIONS[name] for name in few})
    trials = [{"region": r, "fixture": f, **entry.hard(r, 0, f)} for r in entry.REGIONS for f in (True, False)]
    hard, soft = entry.hard_rows(trials), [entry.soft(2.0)]
    assert entry.passed(hard, soft), (hard, soft)
    for failure in ({"entry_mm": 0.2}, {"held_share": 0.0}, {"entry_without_mm": 1.0}):
        assert not entry.passed([{**hard[0], **failure}], soft)
    for key in ("measured_mm", "certified_N_per_m"):
        assert not entry.passed(hard, [{**soft[0], key: 1.1 * soft[0][key]}])


def test_region_check_uses_its_present_pose():
    """Reference: the gap from the core, for random poses and times. Allowed places far from the border have a bound."""
    rng = np.random.default_rng(6)
    for region in entry.REGIONS.values():
        X_WG, t = region.pose(np.array([0.01, 0.02, 0.03]), rng), rng.uniform(0.0, 3.0, 20)
        p, f = X_WG[:3, 3] + rng.uniform(-0.02, 0.02, (20, 3)), region.fixture(X_WG, True)
        X = np.tile(np.eye(4), (20, 1, 1))
        X[:, :3, 3] = p
        gap = [f.evaluate(one, when)["gap"] for one, when in zip(X, t, strict=True)]
        p_G = (p - region.shift(t) - X_WG[:3, 3]) @ X_WG[:3, :3]
        outside, bound = region.outside(p_G), np.array(gap)
        far = outside > 0.003
        assert not far.all()
        np.testing.assert_allclose(outside[~far], bound[~far], atol=2e-5)
        assert (bound[far] > 15.0 / 16.0 * outside[far] - 2e-5).all()
        assert (bound[far] < outside[far] + 2e-5).all()


def test_certified_stiffness_is_measured_and_not_that_of_the_file(monkeypatch):
    """For a law with 10 % more stiffness than stated, certificate and expected entry use the measured stiffness."""
    rig, wall = entry._pressed()
    scene = entry._scene(guidance=[rig.scene.guidance[0].model_copy(update={"law": guidance.Law(stiffness=440.0)})])
    monkeypatch.setattr(entry, "_pressed", lambda: (build(scene), wall))
    entry._certified.cache_clear()
    soft = entry.soft(2.0)
    entry._certified.cache_clear()
    assert soft["certified_N_per_m"] == pytest.approx(440.0, rel=0.01)
    assert soft["measured_mm"] == pytest.approx(soft["certified_mm"], rel=entry.WITHIN)
    assert not entry.passed([], [soft])
