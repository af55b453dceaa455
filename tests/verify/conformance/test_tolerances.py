"""Judges of the conformance suite accept errors just below their tolerance and refuse errors just above it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate_lab.verify.conformance import (
    at_rest,
    bench,
    damping,
    entry,
    in_motion,
    live,
    master,
    probes,
    rejected,
    roles,
)
from palpate_lab.verify.conformance.bench import Answer, Bench, Motion, constant_pose, fixture
from palpate_lab.verify.conformance.combinations import Combination
from palpate_lab.verify.conformance.laws import B_TURN, B
from palpate_lab.verify.conformance.probes import Probe, is_smooth, smooth
from palpate_lab.verify.conformance.roles import ROLES, gradient, nearest
from palpate_lab.verify.conformance.specimens import BOX, SPECIMENS, TUBE, _curve

BALL = Combination("forbid", "sphere", "spring", "soft")
HARD = replace(BALL, policy="hard")
TURNS = Combination("orient against the normal", "sphere", "spring", "soft")
FRAME = Combination("orient as the frame", "plane", "spring", "soft")


def added(monkeypatch, error, where=lambda bench, X_WG: True, goal=0.0):
    """Every answer of the benches has an additional wrench (6,) and a goal that is shifted along x [m]."""
    run = Bench.run

    def changed(self, motion, X_WG=None):
        out = run(self, motion, X_WG)
        if not where(self, X_WG):
            return out
        X = out.X.copy()
        X[:, 0, 3] += goal
        return Answer(out.F + error, X, out.B)

    monkeypatch.setattr(Bench, "run", changed)


@pytest.mark.parametrize("factor", [0.9, 1.1])
@pytest.mark.parametrize(
    ("c", "allowed"),
    [(BALL, 1e-6 + 1e-4 * 0.6), (HARD, 8e-5 + 1e-4 * 0.6), (replace(BALL, geometry="distance grid"), 3.2e-4 + 6e-5)],
    ids=str,
)
def test_a_wrench_in_another_frame_may_differ_by_a_tenth_of_a_per_mille(monkeypatch, c, allowed, factor):
    """For 0.6 N; and by 400 N/m times 0.2 um of a correction, or 0.8 um of a sampled distance."""
    X = np.eye(4)
    X[0, 3] = 0.02 + 0.004 - 0.0015 + 5e-5 * (c is HARD)
    one = Probe(X, np.zeros(6), -0.0015, np.array([1.0, 0, 0, 0, 0, 0]))
    monkeypatch.setattr(at_rest, "probes", lambda c: (one,))
    error = np.array([-factor * allowed, 0, 0, 0, 0, 0])
    R = Rotation.from_rotvec([0.7, -1.1, 0.4]).as_matrix()
    added(monkeypatch, np.r_[R @ error[:3], 0.0, 0.0, 0.0], lambda b, X_WG: X_WG is not None)
    assert bool(at_rest.frame_change(c)) == (factor > 1.0)


@pytest.mark.parametrize("share", [0.99, 1.01])
@pytest.mark.parametrize("c", [BALL, TURNS], ids=str)
def test_damping_may_differ_by_1_percent(monkeypatch, c, share):
    for error, found in ((0.9, False), (1.1, True)):
        with monkeypatch.context() as patch:
            wrong = {key: (1.0 + (share - 1.0) * error) * full for key, full in (("B", B), ("B_turn", B_TURN))}
            patch.setattr(bench, "fixture", lambda c, law=wrong, **more: fixture(c, law=law, **more))
            assert bool(damping.damping(c)) == found, error


@pytest.mark.parametrize("error", [0.9, 1.1])
@pytest.mark.parametrize("c", [replace(BALL, geometry="box"), replace(BALL, geometry="distance grid")], ids=str)
def test_a_wrench_at_a_rejected_place_may_differ_by_1_percent(monkeypatch, c, error):
    """And by 400 N/m times the error of a sampled distance, 8 mN for the grid."""
    X = np.eye(4)
    X[:3, 3] = [0.0165, 0.0, 0.0] if c.geometry == "box" else [0.0225, 0.0, 0.0]
    size = np.linalg.norm(at_rest.expected(c, probes.probe_at(c.role, c.geometry, X))[:3])
    genuine = Bench(c, quick=True).begin(X).run(constant_pose(X, 60)).F[-1, 0]
    allowed = 0.01 * size + 400.0 * SPECIMENS[c.geometry].near + 1e-5
    added(monkeypatch, np.array([size + error * allowed - genuine, 0, 0, 0, 0, 0]))
    assert bool(rejected._at_rest(c, X)) == (error > 1.0)


@pytest.mark.parametrize("error", [0.9, 1.1])
@pytest.mark.parametrize("policy", ["soft", "ramp by pedal"])
def test_a_wrench_at_rest_may_change_by_a_per_mille(monkeypatch, policy, error):
    c, run = replace(BALL, policy=policy), Bench.run

    def wobbling(self, motion, *more):
        out = run(self, motion, *more)
        out.F[len(out.F) // 2] *= 1.0 + 1e-3 * error
        return out

    X = np.eye(4)
    X[0, 3] = 0.02
    monkeypatch.setattr(at_rest, "unfiltered_poses", lambda *_: (X,))
    monkeypatch.setattr(Bench, "run", wobbling)
    assert bool(at_rest.steady(c)) == (error > 1.0)


def test_only_targets_that_turn_with_the_path_are_bounded():
    """The product bounds the rate of an axis and of a frame; normals are means over 10 mm, and turn slowly anyway."""
    bounded = [role for role in ROLES if rejected._bounded(role)]
    assert bounded == ["orient along the axis", "orient as the frame"]


@pytest.mark.parametrize(("rate", "is_exact"), [(99.0, True), (101.0, False)])
def test_a_wrench_is_exact_where_its_target_turns_by_less_than_100_rad_per_metre(monkeypatch, rate, is_exact):
    monkeypatch.setattr(rejected, "_steepness", lambda *_: np.array([[1.0, 1.0], [rate, 1.0]]))
    assert rejected.exact(FRAME, np.eye(4)) == is_exact
    assert rejected.exact(TURNS, np.eye(4)), "a normal has no bound"
    assert not rejected.exact(replace(TURNS, policy="hard"), np.eye(4)), "a correction"


def test_steepness_of_a_bounded_target_counts_up_to_100_rad_per_metre(monkeypatch):
    """The gradient is 300 rad/m at one tick of the loop, and counts for its neighbours too."""
    calls = iter(range(400))

    def steep(case, s, X):
        return np.r_[300.0 if next(calls) % 200 == 50 else 1.0, 0.0, 0.0, 0.0, 0.0, 2.0]

    monkeypatch.setattr(rejected, "gradient", steep)
    X = np.eye(4)
    X[0, 3] = 0.0123  # a place of its own in the cache
    for role, most in (("orient as the frame", 100.0), ("orient against the normal", 300.0)):
        per = rejected._steepness(role, "plane", X.tobytes())
        np.testing.assert_allclose(per[:, 0], np.where(np.isin(np.arange(200), [49, 50, 51]), most, 1.0))
        np.testing.assert_allclose(per[:, 1], 2.0)
    rejected._steepness.cache_clear()


def test_a_correction_that_turns_may_step_as_if_its_mean_normal_had_length_one(monkeypatch):
    """0.5 N m/rad times 10 mrad are 5 mN m a tick; a spring's mean normal of length 0.1 explains 0.05 mN m."""
    monkeypatch.setattr(rejected, "_steepness", lambda *_: np.tile([0.0, 0.1], (200, 1)))
    X = np.tile(np.eye(4), (4, 1, 1))
    X[:, :3, :3] = Rotation.from_rotvec(1e-2 * np.outer(np.arange(4), [0.0, 0.0, 1.0])).as_matrix()
    motion, steps = Motion(X, np.zeros((4, 6))), np.zeros((3, 2))
    steps[1, 1] = 1.01 * 5e-3
    hard = replace(TURNS, policy="hard")
    assert rejected._step_failure(hard, np.eye(4), steps, motion) == ""
    assert "5.05 N m" in rejected._step_failure(TURNS, np.eye(4), 1e3 * steps, motion)
    assert rejected._step_failure(TURNS, np.eye(4), steps, motion)
    assert rejected._step_failure(hard, np.eye(4), 1.2 * steps, motion)


@pytest.mark.parametrize("role", ROLES)
def test_each_role_attracts_or_repels_as_its_potential_does(role):
    """A potential that attracts vanishes at a satisfied pose, and one that repels starts at its range."""
    geometry = "point" if role == "rcm" else "plane"
    c = Combination(role, geometry, "potential", "soft")
    assert at_rest.sign_and_direction(c) == ""


@pytest.mark.parametrize("role", ["orient as the frame", "orient along the axis"])
@pytest.mark.parametrize("geometry", ["path", "line"])
def test_wrench_and_frame_of_axial_geometries(role, geometry):
    c, s = Combination(role, geometry, "spring", "soft"), SPECIMENS[geometry]
    assert at_rest.sign_and_direction(c) == ""
    p = np.array([0.004, 0.01, 0.002])
    np.testing.assert_allclose(s.attitude(p)[:, 2], s.axis(p), atol=1e-6)
    assert s._made is s._made


def test_a_swinging_hand_exceeds_a_speed_limit_2_5_times():
    """50 mm/s across, and sqrt(1.25) times as much where the three components have their extremes."""
    c = Combination("limit of speed", "sphere", "spring", "soft")
    speed = np.linalg.norm(live._swinging(c, probes.probes(c)[0]).V[:, :3], axis=1)
    assert [speed.min(), speed.max()] == pytest.approx([0.05, 0.05 * np.sqrt(1.25)], rel=1e-3)


def box_probe(p, role="forbid"):
    X = np.eye(4)
    X[:3, 3] = p
    return probes.probe_at(role, "box", X)


def test_a_path_starts_at_the_border_where_an_edge_lies_between_both_poses():
    """Deep inside a box, beside its edge, the satisfied pose of another wall is replaced by one 20 um inside."""
    c, s = Combination("limit of the workspace", "box", "spring", "soft"), SPECIMENS["box"]
    case, probe = ROLES[c.role], box_probe([0.0165, 0.0, 0.0], c.role)
    other = box_probe([0.0, 0.0, 0.0099], c.role).X
    same = box_probe([0.0149, 0.0, 0.0], c.role).X
    start = in_motion._smooth_start(case, s, probe, other)
    np.testing.assert_allclose(start[:3, 3], [0.01502, 0.0, 0.0], atol=1.1e-5)
    assert case.gap(s, start) < 0.0
    assert in_motion._smooth_start(case, s, probe, same) is same
    for role in ("orient as the frame", "limit of force", "rcm"):
        assert in_motion._smooth_start(ROLES[role], s, probe, other) is other


def test_a_repelling_role_needs_a_smooth_distance_at_a_satisfied_pose():
    """Exactly between two walls of a box the slope of the distance is shorter than one."""
    s = SPECIMENS["box"]
    edge, face = np.eye(4), np.eye(4)
    edge[:3, 3], face[:3, 3] = [0.012, 0.009, 0.0], [0.012, 0.0, 0.0]
    kept, force, guide = (ROLES[name] for name in ("keep-in", "limit of force", "guide"))
    for X, found in ((edge, False), (face, True)):
        p = Probe(X, np.zeros(6), kept.gap(s, X), gradient(kept, s, X))
        assert is_smooth(kept, s, p, False) == found
        assert is_smooth(force, SPECIMENS["box"], p, False)
    near = np.eye(4)
    near[:3, 3] = [0.0152, 0.0122, 0.0]
    p = Probe(near, np.zeros(6), guide.gap(s, near), gradient(guide, s, near))
    assert is_smooth(guide, s, p, False)


@pytest.mark.parametrize(("distance", "found"), [(1.5e-3, False), (2.2e-3, True), (3e-5, False)])
def test_the_normal_around_a_place_turns_by_less_than_acos_of_07(distance, found):
    """Around a point, 1.2 mm aside: by 53 degrees at a distance of 1.5 mm, and by 32 degrees at 2.2 mm."""
    case, s, X = ROLES["forbid"], SPECIMENS["point"], np.eye(4)
    X[0, 3] = distance
    assert smooth(case, s, X, gradient(case, s, X)) == found


def test_damping_of_rcm_rises_over_a_fifth_of_a_millimetre():
    """A tool along z, beside the point: 20 N s/m across its shaft, 2 along, and 2 while the violation shrinks."""
    c = Combination("rcm", "point", "admittance", "soft")

    def change(gap, v):
        J = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        return damping.expected(c, Probe(np.eye(4), np.zeros(6), gap, J), np.r_[v, np.zeros(3)])[:3]

    x, y, z = 0.02 * np.eye(3)
    np.testing.assert_allclose(change(-0.001, z), -2.0 * z, atol=1e-9)
    np.testing.assert_allclose(change(-0.001, y), -20.0 * y, atol=1e-9)
    np.testing.assert_allclose(change(-0.001, -x), 20.0 * x, atol=1e-9)
    np.testing.assert_allclose(change(-0.0001, x), -(20.0 - 18.0 * 0.5) * x, atol=1e-9)
    np.testing.assert_allclose(change(-0.001, x), -2.0 * x, atol=1e-9)


def test_specimens_lie_around_the_origin_and_bend_less_than_their_tube():
    """Probes keep within 32 mm. Around a path they lie up to 6 + 4 mm away, on loops of 1.8 mm."""
    p = np.random.default_rng(5).uniform(-0.03, 0.03, (12, 3))
    for name, s in SPECIMENS.items():
        assert max(np.linalg.norm(nearest(s, one)) for one in p) < 0.042, name
    u, _, spline = _curve()
    v, a = spline(u, 1), spline(u, 2)
    radius = np.linalg.norm(v, axis=1) ** 3 / np.linalg.norm(np.cross(v, a), axis=1)
    assert radius.min() > TUBE + 0.004 + 0.0018


def test_a_control_run_is_that_of_a_hand_that_has_swung_for_long():
    """Its last turn, and the tick before, as after 30 turns."""
    for c in (HARD, BALL):
        probe = probes.probes(c)[0]
        motion, setting, shape = live._swinging(c, probe), live.Setting(), SPECIMENS["sphere"].make()
        control = live._control(c, setting, shape, motion, False)
        bench_ = Bench(c, quick=True).begin(motion.X[0])
        long = live._run(bench_, setting, motion, 30 * 160)
        assert len(control.F) == 161
        np.testing.assert_allclose(control.F, long.F[-161:], atol=1e-6)
        np.testing.assert_allclose(control.X, long.X[-161:], atol=1e-9)


def test_loops_run_at_two_speeds_in_both_directions_around_two_places():
    found = in_motion._loops(BALL)
    assert [len(loop.X) for _, loop in found] == [601, 601, 201, 201]
    for k, (approach, loop) in enumerate(found):
        place = probes.probes(BALL)[k // 2].X
        np.testing.assert_allclose(approach.X[[0, -1]], [place, loop.X[0]], atol=1e-12)
        assert len(approach.X) == 200
    np.testing.assert_allclose(found[0][1].X, found[1][1].X[::-1], atol=1e-12)


@pytest.mark.parametrize(("gain", "found"), [(0.0038, False), (0.0042, True)])
def test_a_loop_may_yield_4_per_mille_of_the_energy_that_it_moves(monkeypatch, gain, found):
    """A force of 1 N along x with the position's phase, and a part of it along the velocity."""
    approach, loop = in_motion.approached_loop(np.eye(4).tobytes(), 200, 1.0)
    phase = 2.0 * np.pi * np.arange(201) / 200
    F = np.zeros((201, 6))
    s = gain * 2.0 / np.pi  # the power is -sin cos + s sin^2: s / 2 on average, and 1 / pi without its sign
    F[:, 0] = 1e3 * (np.cos(phase) - s * np.sin(phase))
    monkeypatch.setattr(Bench, "run", lambda self, motion: Answer(F, motion.X, np.zeros((len(F), 3, 3))))
    assert bool(in_motion._gain(BALL, approach, loop, False, True)[0]) == found


def test_a_fixture_that_engages_does_so_in_another_frame_and_in_a_moving_one():
    c = replace(BALL, policy="engages and releases")
    assert at_rest.frame_change(c) == in_motion.moving(c) == ""


@pytest.mark.parametrize("error", [0.9, 1.1])
def test_wrenches_on_both_masters_may_differ_by_a_tenth_of_a_per_mille(monkeypatch, error):
    """Of the largest wrench of the path, in one tick of it, at which the wrench is small."""
    c = replace(BALL, law="admittance")
    largest, run = [], Bench.run

    def changed(self, motion, *more):
        out = run(self, motion, *more)
        if len(motion.X) == 200:
            if self.damping:
                out.F[1, 2] += error * (1e-6 + 1e-4 * largest[-1])
            else:
                largest.append(np.linalg.norm(out.F * at_rest.WEIGHTS, axis=1).max())
        return out

    assert master.admittance_master(c) == ""
    monkeypatch.setattr(Bench, "run", changed)
    assert bool(master.admittance_master(c)) == (error > 1.0)


@pytest.mark.parametrize("verdict", ["stable", "marginal", "unstable"])
def test_only_a_wall_that_is_certified_as_stable_has_a_certified_stiffness(monkeypatch, verdict):
    found = [SimpleNamespace(name="object 1", k_max=1.0, verdict="stable"),
             SimpleNamespace(name="fixture wall", k_max=700.0, verdict=verdict)]  # fmt: skip
    monkeypatch.setattr(entry, "certify_all", lambda *_, **__: found)
    monkeypatch.setattr(entry, "entries", lambda *_: None)
    monkeypatch.setattr(entry, "stiffness", lambda *_: 400.0)
    entry._certified.cache_clear()
    np.testing.assert_equal(entry._certified(), (700.0, 400.0 if verdict == "stable" else np.nan))
    entry._certified.cache_clear()


def test_edits_without_a_smooth_place_are_not_judged(monkeypatch):
    c = replace(BALL, policy="engages and releases")
    for name, value in (("smooth", False), ("moved_to_gap", None)):
        with monkeypatch.context() as patch:
            patch.setattr(live, name, lambda *_, value=value: value)
            with pytest.raises(LookupError, match="no smooth point"):
                live._edit_probe(c)


def test_a_carried_hand_may_be_braked_by_20_newton_seconds_per_metre_but_never_driven():
    """By a velocity law. 1 mN and 2 % for all laws; 400 N/m times the way of two ticks if the pose is corrected."""
    x, y = np.eye(6)[:2]
    V, rests = np.tile(0.02 * x, (3, 1)), np.tile(0.5 * y, (3, 1))
    limit = Combination("limit of force", "plane", "spring", "soft")
    cases = ((BALL, 0.011), (HARD, 0.027), (limit, 0.027), (replace(BALL, law="admittance"), 0.411),
             (replace(BALL, geometry="distance grid"), 0.011 + 0.032))  # fmt: skip
    for c, allowed in cases:
        for error, found in ((0.95, False), (1.05, True)):
            assert bool(in_motion._carried_failure(c, rests - error * allowed * x, rests, V)) == found, (c, error)
    driven = rests + 1e-4 * x
    assert "gives 2e-06 W" in in_motion._carried_failure(replace(BALL, law="admittance"), driven, rests, V)
    assert in_motion._carried_failure(BALL, driven, rests, V) == ""


@pytest.mark.parametrize(("factor", "size", "found"), [(0.61, 0.0, False), (0.61, 1e-3, True), (0.59, 1e-3, False)])
def test_steps_shrink_to_60_percent_with_a_quarter_of_the_tick(monkeypatch, factor, size, found):
    """Steps of 1 N, and 2 per mille of the largest force, which is that of these steps or far larger."""
    c, run = replace(BALL, law="spring"), Bench.run

    def stepped(self, motion, *more):
        out = run(self, motion, *more)
        out.F[:] = 0.0
        out.F[50] = 1.0 if len(out.F) == 400 else factor
        out.F[50, 1:] = 0.0
        out.F[:, 3] = 0.0 if size else 100.0
        return out

    monkeypatch.setattr(Bench, "run", stepped)
    assert bool(in_motion.continuity(c)) == found


@pytest.mark.parametrize(("policy", "step", "found"), [("hard", 1.9e-3, False), ("hard", 2.1e-3, True),
                                                       ("soft", 1e-4, True)])  # fmt: skip
def test_a_corrected_goal_may_wander_5_um_on_a_cloud(monkeypatch, policy, step, found):
    """400 N/m times 5 um; a soft fixture's force does not."""
    c, run = Combination("keep-in", "cloud", "spring", policy), Bench.run

    def stepped(self, motion, *more):
        out = run(self, motion, *more)
        out.F[:] = 0.0
        out.F[50:, 0] = 0.0 if len(out.F) == 400 else step
        return out

    monkeypatch.setattr(Bench, "run", stepped)
    assert bool(in_motion.continuity(c)) == found


def test_a_rejected_place_has_no_wall_within_the_finite_differences():
    """Between two walls the reference would be the mean of two directions."""
    s, X = SPECIMENS["box"], np.eye(4)
    y, z = 0.5 * BOX[1], 0.5 * BOX[2]
    X[:3, 3] = [0.0, y - 0.006, z - 0.006]
    between = [probes._aside(s, X, np.random.default_rng(seed))[:3, 3] for seed in range(200)]
    apart = np.abs([(y - p[1]) - (z - p[2]) for p in between])
    assert apart.min() > roles.H
    assert apart.max() < 2.0 * probes.ASIDE


def test_beside_an_edge_a_limit_is_not_judged_by_one_wall():
    """Its goal keeps its reserve to both walls, 0.06 mm beside the edge of a box."""
    s, case = SPECIMENS["box"], ROLES["limit of the workspace"]
    for beside, accepted in ((6e-5, False), (1.3e-3, True)):
        X = np.eye(4)
        X[:3, 3] = [0.0, 0.5 * BOX[1] - beside, 0.5 * BOX[2] + 0.002]
        assert smooth(case, s, X, gradient(case, s, X)) == accepted
