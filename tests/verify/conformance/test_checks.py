"""Each check of the conformance suite finds small errors, and its bounds are those written down by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate_lab.verify.conformance import (
    activation,
    damping,
    entry,
    in_motion,
    live,
    master,
    rejected,
    run,
)
from palpate_lab.verify.conformance.bench import DT, Answer, Bench, Motion, constant_pose, fixture
from palpate_lab.verify.conformance.combinations import ENGAGE, POLICIES, RELEASE, Combination
from palpate_lab.verify.conformance.probes import Probe, moved_to_gap, pool, probes, satisfied_pose
from palpate_lab.verify.conformance.roles import ROLES, angle
from palpate_lab.verify.conformance.run import NO_JUDGE, examine
from palpate_lab.verify.conformance.specimens import SPECIMENS

BALL = Combination("forbid", "sphere", "spring", "soft")
TURNS = Combination("orient against the normal", "sphere", "spring", "soft")
N = np.array([0.6, 0.8, 0.0, 0.0, 0.0, 0.0])
Z = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])


def altered(monkeypatch, change):
    """Replace every answer of the benches by `change(bench, motion, answer)`."""
    genuine = Bench.run

    def changed(self, motion, *more):
        return change(self, motion, genuine(self, motion, *more))

    monkeypatch.setattr(Bench, "run", changed)


@pytest.mark.parametrize("c", [BALL, TURNS], ids=str)
@pytest.mark.parametrize("name", [name for name in POLICIES if name not in ("soft", "hard", "first of two")])
def test_a_share_of_the_wrench_that_is_wrong_by_4_percent_is_found(monkeypatch, name, c):
    c = replace(c, policy=name)
    assert activation.policy(c) == ""
    altered(monkeypatch, lambda b, _, a: Answer(a.F * (1.04 if b.c.policy == name else 1.0), a.X, a.B))
    assert "wrench" in activation.policy(c)


@pytest.mark.parametrize("c", [BALL, TURNS, Combination("limit of speed", "sphere", "spring", "soft")], ids=str)
@pytest.mark.parametrize("name", ["soft", "first of two"])
def test_a_sum_of_two_fixtures_that_is_wrong_by_1_percent_is_found(monkeypatch, name, c):
    c = replace(c, policy=name)
    assert activation.policy(c) == ""
    init = Bench.__init__

    def counted(self, c, *fixtures, **more):
        init(self, c, *fixtures, **more)
        self.several = len(fixtures) > 1

    monkeypatch.setattr(Bench, "__init__", counted)
    altered(monkeypatch, lambda b, _, a: Answer(a.F * (1.01 if b.several else 1.0), a.X, a.B))
    assert "priorities" in activation.policy(c)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("ramp by pedal", {"ramp": ("pedal", 0.0, 1.1)}), ("ramp by distance", {"ramp": ("distance", 0.0, 0.0044)}),
        ("ramp by time", {"ramp": ("time", 0.0, 0.55)}), ("ramp by force", {"ramp": ("force", 0.0, 4.4)}),
        ("part of the authority", {"authority": 0.62}), ("hard, part of the authority", {"authority": 0.62}),
        ("engages and releases", {"engage": 0.9 * ENGAGE}), ("engages and releases", {"engage": 1.1 * ENGAGE}),
        ("engages and releases", {"release": 0.9 * RELEASE}), ("engages and releases", {"release": 1.1 * RELEASE}),
    ],
)  # fmt: skip
def test_a_policy_with_other_numbers_is_found(monkeypatch, name, changes):
    c, other = replace(BALL, policy=name), replace(POLICIES[name], **changes)
    genuine = activation.Bench

    def planted(c, *fixtures, **more):
        return genuine(c, *(fixtures or ([fixture(c, policy=other)] if c.policy == name else [])), **more)

    monkeypatch.setattr(activation, "Bench", planted)
    assert activation.policy(c) != ""


@pytest.mark.parametrize("c", [BALL, TURNS, replace(BALL, law="admittance")], ids=str)
def test_energy_of_a_late_spring_and_of_a_damper_of_the_wrong_sign_is_found(monkeypatch, c):
    """A spring that is 10 ticks late on loops of 200 and 600 ticks."""
    assert in_motion.energy(c) == ""
    altered(monkeypatch, lambda b, m, a: Answer(-a.F if b.c.law == "admittance" else np.roll(a.F, 10, 0), a.X, a.B))
    assert "mJ in a loop" in in_motion.energy(c)


@pytest.mark.parametrize("unit", [0, 3])
def test_a_small_jump_in_a_motion_is_found(monkeypatch, unit):
    """2 % of the largest force, in the middle of the way."""
    c = TURNS if unit else BALL
    assert in_motion.continuity(c) == ""

    def jump(b, m, a):
        a.F[len(a.F) // 2 :, unit] += 0.02 * np.abs(a.F).max()
        return a

    altered(monkeypatch, jump)
    assert ("N m a tick" if unit else "N a tick") in in_motion.continuity(c)


@pytest.mark.parametrize(
    "c", [BALL, TURNS, Combination("rcm", "point", "spring", "soft"), Combination("keep-in", "box", "spring", "soft")],
    ids=str,
)  # fmt: skip
def test_paths_lead_from_a_satisfied_place_a_few_millimetres_into_violation(c):
    case, s = ROLES[c.role], SPECIMENS[c.geometry]
    for a, b in in_motion.paths(c):
        assert case.gap(s, a) > -3e-5
        assert case.gap(s, b) < 0.0
        assert np.linalg.norm(b[:3, 3] - a[:3, 3]) < 0.006
        assert angle(a, b) < (0.7 if case.turns else 0.1)


def test_energy_that_only_the_rate_limit_yields_counts_in_the_ledger_alone(monkeypatch):
    """A force along the motion, in runs with a rate limit: it is billed, and no gain of the fixture."""
    c = Combination("forbid", "box", "spring", "soft")
    monkeypatch.setattr(rejected, "_step_failure", lambda *_: "")
    billed = []
    monkeypatch.setattr(rejected, "billing_failure", lambda F, motion: billed.append(F) or "")
    genuine = Bench.__init__

    def noted(self, *given, quick=False, **more):
        genuine(self, *given, quick=quick, **more)
        self.limited = not quick

    monkeypatch.setattr(Bench, "__init__", noted)
    altered(monkeypatch, lambda b, m, a: Answer(a.F + m.V if b.limited else a.F, a.X, a.B))
    assert rejected.rejected_places(c) == ""
    assert billed
    altered(monkeypatch, lambda b, m, a: Answer(a.F if b.limited else a.F + m.V, a.X, a.B))
    assert "without the rate limit" in rejected.rejected_places(c)


@pytest.mark.parametrize(("deep", "found"), [(0.9e-4, False), (1.1e-4, True)])
def test_a_hard_goal_may_enter_by_a_tenth_of_a_millimetre(deep, found):
    inside = np.eye(4)
    inside[2, 3] = 0.02 + 0.004 - deep
    goals = np.repeat(inside[None], 11, axis=0)
    assert bool(rejected._entry_failure(replace(BALL, policy="hard"), goals)) == found
    assert rejected._entry_failure(BALL, goals) == ""


def test_damping_of_laws_that_turn():
    """2 rad/s: 5 mN m s/rad that rise over 5 mrad; the velocity law brakes all turns, and worse ones tenfold."""

    def change(law, gap, w):
        V = np.r_[0.0, 0.0, 0.0, w]
        return damping.expected(replace(TURNS, law=law), Probe(np.eye(4), np.zeros(6), gap, Z), V)[3:]

    z, x = np.array([0.0, 0.0, 2.0]), np.array([2.0, 0.0, 0.0])
    for w, size in ((-z, 0.01), (z, -0.01), (x, 0.0)):
        for gap, share in ((-0.1, 1.0), (-0.0025, 0.5 if size >= 0.0 else 0.125), (0.1, 0.0)):
            np.testing.assert_allclose(change("spring", gap, w), [0.0, 0.0, share * size], atol=1e-12)
    np.testing.assert_allclose(change("optimise", -1.0, -z), 0.0, atol=1e-12)
    for w, factor in ((z, 1.0), (x, 1.0), (-z, 10.0)):
        np.testing.assert_allclose(change("admittance", -0.1, w), -0.005 * factor * w, atol=1e-12)
    np.testing.assert_allclose(change("admittance", -0.0025, -z), 0.005 * 5.5 * z, atol=1e-12)


def test_damping_of_a_velocity_law_that_attracts():
    """20 N s/m across a line and 2 along it, or towards it; beyond its end and around a point all is across."""
    a, t = np.array([-0.03, -0.01, 0.0]), np.array([6.0, 2.0, 1.0]) / np.sqrt(41.0)
    n = np.cross(t, [0.0, 0.0, 1.0])
    n /= np.linalg.norm(n)
    b = np.cross(t, n)

    def change(p, gap, v, geometry="line", gradient=-n):
        X = np.eye(4)
        X[:3, 3] = p
        c = Combination("guide", geometry, "admittance", "soft")
        return damping.expected(c, Probe(X, np.zeros(6), gap, np.r_[gradient, np.zeros(3)]), np.r_[v, np.zeros(3)])[:3]

    beside = a + 0.03 * t + 0.002 * n
    for v, B in ((t, 2.0), (b, 20.0), (n, 20.0), (-n, 2.0)):
        np.testing.assert_allclose(change(beside, -0.0015, 0.02 * v), -0.02 * B * v, atol=1e-6)
    np.testing.assert_allclose(change(beside, -0.0001, -0.02 * n), 0.02 * 11.0 * n, atol=1e-6)
    beyond = a - 0.003 * t
    np.testing.assert_allclose(change(beyond, -0.0015, 0.02 * n, gradient=t), -0.4 * n, atol=1e-6)
    np.testing.assert_allclose(change(0.003 * n, -0.0025, 0.02 * t, "point"), -0.4 * t, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "down"),
    [("floor", 0.02), ("6 mm around a line", 0.02), ("sphere", 0.02), ("box", 0.02),
     ("planes of any tilt", 0.005), ("inside of a sphere of 2 cm", -0.02)],
)  # fmt: skip
def test_the_tool_starts_20_mm_above_its_region_5_mm_from_a_tilted_one_or_in_its_middle(name, down):
    region, start = entry.REGIONS[name], np.array([0.1, 0.2, 0.3])
    X_WG = region.pose(start, np.random.default_rng(3))
    up = X_WG[:3, 2] if region.tilted else np.array([0.0, 0.0, 1.0])
    border = (start - down * up - X_WG[:3, 3]) @ X_WG[:3, :3]
    assert region.outside(border[None])[0] == pytest.approx(0.0, abs=5e-5)
    assert region.outside(((start - X_WG[:3, 3]) @ X_WG[:3, :3])[None])[0] > 0.004


def test_breathing_regions_move_3_mm_up_in_a_quarter_of_their_period_and_others_rest():
    t = np.array([0.0, 0.375, 0.75])
    for name, region in entry.REGIONS.items():
        moves = np.array([[0, 0, 0], [1e-3, 0, 3e-3], [0, 0, 0]]) * ("breath" in name)
        np.testing.assert_allclose(region.shift(t), moves, atol=1e-12)


@pytest.mark.parametrize(("law", "force"), [("potential", 6e-3 + 6e-3), ("spring", 6e-3 + 60e-3)])
def test_a_motion_explains_its_steps_by_the_stiffest_and_most_damped_setting(law, force):
    """600 N/m times 10 um, and 6 N s/m times 1 mm/s a tick, or 60 N s/m where an edit makes it a velocity law."""
    n = 4
    X, V = np.tile(np.eye(4), (n, 1, 1)), np.zeros((n, 6))
    X[:, :3, 3], V[:, :3] = 1e-5 * np.arange(n)[:, None] * N[:3], 1e-3 * np.arange(n)[:, None] * N[:3]
    bound = live._motion_bound(replace(BALL, law=law), Probe(np.eye(4), np.zeros(6), -0.001, N), Motion(X, V))
    np.testing.assert_allclose(bound, [force, 0.0], atol=1e-9)


@pytest.mark.parametrize(
    ("edit", "policy", "rests", "step"),
    [("switched off", "soft", True, 0.005), ("switched off", "ramp by time", True, 0.007),
     ("given half the authority", "part of the authority", True, 0.005 / 0.6), ("made stiffer", "soft", True, 0.02),
     ("switched off", "soft", False, 0.02 + 600.0 * 1e-5), ("switched off", "hard", True, 0.02)],
)  # fmt: skip
def test_a_fixture_at_rest_fades_within_its_rise_and_any_edit_within_the_rates(edit, policy, rests, step):
    """1 N fades in 0.2 s, and twice as far if a ramp over 0.5 s begins again; the rate of any edit is 20 N/s."""
    c, probe = replace(BALL, law="potential", policy=policy), Probe(np.eye(4), np.zeros(6), -0.001, N)
    motion = constant_pose(np.eye(4), 3)
    if not rests:
        motion.X[1:, :3, 3] = 1e-5 * N[:3]
    always = Answer(np.tile([1.0, 0, 0, 0, 0, 0], (4, 1)), np.tile(np.eye(4), (4, 1, 1)), np.zeros((4, 3, 3)))
    corrects = replace(c, law="spring")
    for one in (c, corrects) if policy == "hard" else (corrects,):
        if policy != "hard" and live.LAWS[live.OTHER[one.law]].together:
            continue
        bound = live._step_bound(one, edit, (probe, probe), motion, always, always)
        assert bound[0] == pytest.approx(step, rel=1e-6)


def test_edits_move_the_fixture_by_07_and_its_frame_by_25_millimetres():
    c = replace(BALL, law="potential", policy="part of the authority")
    settings = live.edits(c, probes(c)[0])
    far = {name: np.linalg.norm(one.X_FG[:3, 3]) for name, one in settings.items()}
    assert far == pytest.approx({name: 7e-4 * (k > 2) for k, name in enumerate(settings)})
    assert list(settings)[3] == "moved by 0.7 mm"
    leapt = [name for name, one in settings.items() if np.linalg.norm(one.X_WF[:3, 3]) > 0.0]
    assert leapt == ["its frame leapt by 2.5 mm", "given half the authority"]
    assert np.linalg.norm(settings[leapt[0]].X_WF[:3, 3]) == pytest.approx(2.5e-3)
    assert [name for name, one in settings.items() if not one.on] == ["switched off"]
    assert settings["made stiffer"].law == {"K": 600.0, "K_turn": 0.75}
    assert settings["damped more"].law == {"K": 600.0, "K_turn": 0.75, "B": 6.0, "B_turn": 0.015}
    assert settings["given another law"].law_name == "optimise"
    assert settings["given half the authority"].authority == pytest.approx(0.3)


def test_a_swinging_hand_returns_in_160_ticks_with_the_velocity_of_its_poses():
    probe = probes(BALL)[0]
    motion = live._swinging(BALL, probe)
    assert len(motion.X) == 160
    away = motion.X[:, :3, 3] - probe.X[:3, 3]
    assert np.linalg.norm(away, axis=1).max() == pytest.approx(3e-4 * np.sqrt(1.25), rel=1e-3)
    central = (np.roll(away, -1, axis=0) - np.roll(away, 1, axis=0)) / (2.0 * DT)
    np.testing.assert_allclose(motion.V[:, :3], central, atol=1e-9)
    speed = Combination("limit of speed", "sphere", "spring", "soft")
    fast = np.linalg.norm(live._swinging(speed, probes(speed)[0]).V[:, :3], axis=1)
    assert fast.min() > 0.02, "always above its limit"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda b, B: B if b.damping else B + np.eye(3), "cannot render it"),
        (lambda b, B: 1.01 * B, "eigenvalues"), (lambda b, B: -B, "eigenvalues"), (lambda b, B: 0.0 * B, "no damping"),
    ],
)  # fmt: skip
def test_a_wrong_damping_matrix_of_a_master_is_found(monkeypatch, change, words):
    c = replace(BALL, law="admittance")
    altered(monkeypatch, lambda b, _, a: Answer(a.F, a.X, change(b, a.B)))
    assert words in master.admittance_master(c)


@pytest.mark.parametrize("c", [BALL, TURNS, Combination("guide", "line", "spring", "soft")], ids=str)
def test_a_satisfied_pose_is_just_inside_its_bound(c):
    case, s = ROLES[c.role], SPECIMENS[c.geometry]
    for probe in pool(c.role, c.geometry, 0).violated:
        gap = case.gap(s, satisfied_pose(c.role, c.geometry, probe.X))
        assert gap == pytest.approx(0.03 if case.turns else 2e-4, abs=1.1e-5)


def test_a_limit_of_force_moves_with_its_ground():
    c = Combination("limit of force", "plane", "spring", "soft")
    assert in_motion.moving(c) == in_motion.moving(replace(c, law="admittance")) == ""


def test_results_say_whether_the_core_refused_or_accepted_against_the_meaning(monkeypatch):
    without = Combination("keep-in", "path", "spring", "soft")
    assert examine(without) == {}
    with monkeypatch.context() as patch:
        patch.setattr(run, "Bench", lambda c: SimpleNamespace())
        assert "it has no meaning: a path has no inside" in examine(without)["accepted"]

    def refuse(c):
        raise ValueError("why")

    with monkeypatch.context() as patch:
        patch.setattr(run, "Bench", refuse)
        assert examine(BALL) == {"refused": "why"}

    def nowhere(c):
        raise LookupError("no place")

    checks = {"a": lambda c: "", "b": nowhere, "c": lambda c: "wrong"}
    monkeypatch.setattr(run, "CHECKS", checks)
    assert examine(BALL) == {NO_JUDGE: "b: no place", "c": "wrong"}


@pytest.mark.parametrize("role", ["rcm", "orient along the axis", "guide"])
def test_a_move_to_a_gap_only_shifts_or_only_turns(role):
    case, s = ROLES[role], SPECIMENS["point" if role == "rcm" else "line"]
    X = np.eye(4)
    X[:3, 3], X[:3, :3] = [0.004, 0.006, 0.003], Rotation.from_rotvec([0.9, -0.7, 0.3]).as_matrix()
    Y = moved_to_gap(case, s, X, case.gap(s, X) - 1e-3)
    assert case.gap(s, Y) == pytest.approx(case.gap(s, X) - 1e-3, abs=1.1e-5)
    kept, changed = (slice(3, 4), slice(0, 3)) if case.turns else (slice(0, 3), slice(3, 4))
    np.testing.assert_array_equal(Y[:3, kept], X[:3, kept])
    assert np.abs(Y[:3, changed] - X[:3, changed]).max() > 1e-5


def test_a_goal_may_not_jump_at_an_edit():
    """The goal before the edit is 0.2 mm from that after it, which does not move; 0.1 mm are promised."""
    F, X = np.zeros((3, 6)), np.tile(np.eye(4), (3, 1, 1))
    later = X.copy()
    later[:, 0, 3] = 2e-4
    now, after = (Answer(F, poses, np.zeros((3, 3, 3))) for poses in (X, later))
    hard = replace(BALL, policy="hard")
    assert "the goal jumps by 0.2 mm" in live._step_failure(hard, now, after, np.ones(2), 1e-4)
    assert live._step_failure(hard, now, now, np.ones(2), 1e-4) == ""


@pytest.mark.parametrize("law", ["spring", "admittance"])
def test_damping_at_a_sampled_distance_is_judged_within_the_error_of_its_normal(law):
    assert damping.damping(Combination("forbid", "distance grid", law, "soft")) == ""


@pytest.mark.parametrize("c", [BALL, TURNS], ids=str)
def test_edits_of_a_fixture_that_engages_begin_a_little_nearer_than_that(c):
    """It engages within 1.5 mm, or 0.225 rad."""
    probe = live._edit_probe(replace(c, policy="engages and releases"))
    assert -probe.gap == pytest.approx(0.85 * (0.225 if c is TURNS else 1.5e-3), abs=1.1e-5)


@pytest.mark.parametrize("role", ["limit of speed", "limit of force"])
@pytest.mark.parametrize("geometry", ["box", "sphere", "plane"])
def test_places_of_a_limit_lie_well_within_its_region(role, geometry):
    """The region reaches 30 mm; places are within 15 mm of the geometry."""
    found = pool(role, geometry, 0)
    p = np.array([probe.X[:3, 3] for probe in (*found.violated, *found.satisfied)])
    assert np.abs(SPECIMENS[geometry].distance(p)).max() < 0.015


def test_a_turning_motion_explains_its_moments():
    """0.75 N m/rad times 0.1 mrad, and 15 mN m s/rad times 10 mrad/s a tick."""
    V = np.zeros((4, 6))
    V[:, 5] = 0.01 * np.arange(4)
    X = np.tile(np.eye(4), (4, 1, 1))
    X[:, :3, :3] = Rotation.from_rotvec(1e-4 * np.arange(4)[:, None] * Z[3:]).as_matrix()
    bound = live._motion_bound(replace(TURNS, law="potential"), Probe(np.eye(4), np.zeros(6), -0.1, Z), Motion(X, V))
    np.testing.assert_allclose(bound, [0.0, 0.75e-4 + 1.5e-4], rtol=1e-6)


def test_steps_at_rejected_places_are_judged_by_the_steepness_of_their_own_place(monkeypatch):
    """The gradient of the moment is 1 in the first half of a loop and 0.1 in the second, on two loops."""
    per = np.tile([0.0, 1.0], (200, 1))
    per[100:, 1] = 0.1
    monkeypatch.setattr(rejected, "_steepness", lambda *_: per)
    X = np.tile(np.eye(4), (400, 1, 1))
    X[:, :3, :3] = Rotation.from_rotvec(1e-2 * np.arange(400)[:, None] * Z[3:]).as_matrix()
    motion = Motion(X, np.zeros((400, 6)))
    for tick, found in ((50, False), (150, True), (250, False), (350, True)):
        steps = np.zeros((399, 2))
        steps[tick, 1] = 0.5 * 1e-2
        assert bool(rejected._step_failure(TURNS, np.eye(4), steps, motion)) == found, tick


def test_sizes_of_an_answer_are_its_largest_force_and_moment():
    F = np.zeros((3, 6))
    F[0, 2], F[1, 3:5] = 5.0, [0.3, 0.4]
    np.testing.assert_allclose(live._sizes(Answer(F, np.zeros((3, 4, 4)), np.zeros((3, 3, 3)))), [5.0, 0.5])
