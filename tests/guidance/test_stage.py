"""The stage: hard and soft, authority, hysteresis, priority; never a step; a tool that stays out, come what may."""

import numpy as np
import pytest
from fixtures import DT, Stage, fixture, placed, plane, pose, sphere
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from palpate import _core

GUIDED, CORRECTED, CONFLICT = 1 << 20, 1 << 21, 1 << 22
RESERVE = _core.GuidanceOptions().reserve
LINE = _core.LineGeometry(np.zeros(3), np.array([0.1, 0.0, 0.0]), True)


def at(z, x=0.0):
    return np.array([x, 0.0, z])


def test_without_fixtures_the_goal_is_the_mapped_one_to_the_bit():
    stage, rng = Stage(bandwidth=30.0), np.random.default_rng(0)
    for _ in range(50):
        X = pose(rng.normal(size=3), Rotation.random(random_state=rng).as_matrix())
        out = stage.step(X)
        np.testing.assert_array_equal(out["X_WT_goal"], X)
        np.testing.assert_array_equal(out["F_T_W"], 0.0)
        assert out["status"] == 0


def test_soft_a_hand_that_rests_inside_feels_the_spring():
    stage = Stage(fixture(plane(), law_={"K": 400.0}))
    out = stage.settle(at(-0.005))
    np.testing.assert_allclose(out["F_T_W"][:3], [0, 0, 2.0], atol=1e-9)
    np.testing.assert_array_equal(out["X_WT_goal"][:3, 3], at(-0.005))
    assert (out["strongest"], out["gap"], out["status"]) == (0, pytest.approx(-0.005), GUIDED)


def test_hard_the_goal_stays_out_and_the_hand_feels_the_rest():
    stage = Stage(fixture(plane(), law_={"K": 400.0}, hard=True))
    stage.settle(at(0.01))
    for z in np.linspace(0.01, -0.005, 300):
        out = stage.step(at(z))
        assert out["X_WT_goal"][2, 3] >= 0.0
    out = stage.settle(at(-0.005))
    np.testing.assert_allclose(out["X_WT_goal"][:3, 3], [0, 0, RESERVE], atol=1e-9)
    np.testing.assert_allclose(out["F_T_W"][:3], [0, 0, 400.0 * (0.005 + RESERVE)], atol=1e-6)
    np.testing.assert_allclose(out["correction"], [0, 0, 0.005 + RESERVE], atol=1e-9)
    assert out["status"] == GUIDED | CORRECTED


def test_hard_guide_leads_the_goal_along_the_line():
    stage = Stage(fixture(placed(LINE), "guide", hard=True))
    out = stage.settle(np.array([0.03, 0.004, -0.003]), ticks=2000)
    np.testing.assert_allclose(out["X_WT_goal"][:3, 3], [0.03, 0.0, 0.0], atol=1e-9)


def test_hard_orient_turns_the_goal():
    R = Rotation.from_rotvec([0.3, 0.0, 0.0]).as_matrix()
    stage = Stage(fixture(plane(), "orient", hard=True))
    out = stage.settle(pose(at(0.05), R), ticks=3000)
    np.testing.assert_allclose(out["X_WT_goal"][:3, 2], [0, 0, 1], atol=1e-5)
    np.testing.assert_allclose(out["F_T_W"][3:], [-0.5 * 0.3, 0, 0], atol=1e-3)


def test_hard_rcm_keeps_the_shaft_through_the_point():
    X = pose([0.003, 0.0, 0.1])
    stage = Stage(fixture(placed(_core.PointGeometry()), "rcm", hard=True))
    goal = stage.settle(X, ticks=3000)["X_WT_goal"]
    a, p = goal[:3, 2], goal[:3, 3]
    assert np.linalg.norm(p - a * (a @ p)) < 1e-5


def test_a_corner_of_three_hard_planes_is_the_nearest_point_of_all():
    walls = [
        fixture(plane(pose(R=Rotation.align_vectors([n], [[0, 0, 1]])[0].as_matrix())), name=str(n), hard=True)
        for n in np.eye(3)
    ]
    out = Stage(*walls).settle(np.array([-0.003, -0.004, -0.005]), ticks=1000)
    np.testing.assert_allclose(out["X_WT_goal"][:3, 3], RESERVE, atol=1e-9)
    assert out["status"] & CONFLICT == 0


def test_hard_ones_that_contradict_each_other_yield_by_priority_and_say_so():
    up = fixture(plane(pose(at(0.002))), name="above", hard=True, priority=1)  # z >= 2 mm
    down = fixture(plane(pose(at(-0.002), np.diag([1.0, -1.0, -1.0]))), name="below", hard=True)  # z <= -2 mm
    out = Stage(up, down).settle(at(0.0), ticks=1000)
    assert out["X_WT_goal"][2, 3] == pytest.approx(0.002 + RESERVE)
    assert out["status"] & CONFLICT


def test_a_thin_forbidden_plate_is_not_gone_through_by_the_goal():
    """Its side is remembered, though the other side is nearer to the hand."""
    plate = placed(_core.SurfaceGeometry(_core.Box(np.array([0.2, 0.2, 0.002]))))
    stage = Stage(fixture(plate, hard=True))
    stage.settle(at(0.005))
    for z in np.concatenate([np.linspace(0.005, -0.02, 50), np.full(300, -0.02)]):
        out = stage.step(at(z))
        assert out["X_WT_goal"][2, 3] >= 0.001 - 1e-9
    assert out["F_T_W"][2] > 1.0


@pytest.mark.parametrize("kind", ["plane", "sphere", "cavity", "corner"])
@pytest.mark.parametrize("moving", [False, True])
def test_the_tool_behind_a_servo_stays_out_whatever_the_hand_does(kind, moving):
    """30 Hz behind its goal, thrown at the border with 0.4 m/s and more: entry at most 0.1 mm."""
    waves = [_core.Wave(shift=np.array([0.002, 0.0, 0.004]), turn=np.zeros(3), period=0.8)]
    motion = _core.Motion(waves=waves) if moving else None
    made = {
        "plane": [fixture(plane(motion=motion), hard=True)],
        "sphere": [fixture(sphere(0.02, pose(at(-0.004)), motion), hard=True)],
        "cavity": [fixture(sphere(0.03, pose(at(0.03)), motion), "keep-in", hard=True)],
        "corner": [
            fixture(plane(motion=motion), hard=True),
            fixture(plane(pose(R=Rotation.from_rotvec([0, np.pi / 2, 0]).as_matrix()), motion), name="b", hard=True),
        ],
    }[kind]
    stage, rng = Stage(*made, bandwidth=30.0), np.random.default_rng(4)
    t = np.arange(4000) * DT
    waves = [(rng.uniform(0.5, 12.0), rng.uniform(0, 6.3, 3), rng.uniform(0.3, 1.0)) for _ in range(8)]
    hand = sum(a * 0.02 * np.sin(2 * np.pi * f * t[:, None] + phase) / max(f / 3, 1) for f, phase, a in waves)
    hand = np.array([0.01, 0.0, 0.02]) + np.clip(t, 0.0, 1.0)[:, None] * (hand - np.array([0.01, 0.0, 0.02]))
    stage.settle(hand[0])
    start = stage.k
    assert np.linalg.norm(np.diff(hand, axis=0), axis=1).max() / DT > 0.4
    deepest = touched = 0.0
    for k, p in enumerate(hand):
        stage.step(p)
        for f in made:
            gap = f.ask(stage.X_tool, stage.k * DT)["gap"]
            deepest, touched = min(deepest, gap), touched + (gap < 5e-4)
        assert deepest > -1e-4, f"{1e3 * -deepest:.3f} mm in at {k + start} ms"
    assert touched > 100, "control: it was at the border"


def test_speed_is_limited_and_the_lag_is_felt():
    stage = Stage(fixture(sphere(0.1), "limit", role_={"speed": 0.02}, hard=True), force_rate=1e3)
    z = 0.0
    stage.settle(at(z), ticks=400)
    before = at(z)
    for _ in range(100):
        z += 0.1 * DT
        out = stage.step(at(z))
        after = out["X_WT_goal"][:3, 3]
        assert np.linalg.norm(after - before) <= 0.02 * DT + 1e-12
        before = after
    assert out["F_T_W"][2] < -0.5
    out = stage.settle(at(z), ticks=2000)
    np.testing.assert_allclose(out["X_WT_goal"][:3, 3], at(z), atol=1e-12)


# ---- policy


def test_authority_counts_and_comes_at_its_pace():
    stage = Stage(fixture(plane(), law_={"K": 400.0}, authority=0.5, rise=0.1))
    seen = [stage.step(at(-0.005)) and stage.core.authority(0) for _ in range(100)]
    assert np.diff(seen).max() <= DT / 0.1 + 1e-12
    assert seen[-1] == 0.5
    assert stage.settle(at(-0.005))["F_T_W"][2] == pytest.approx(1.0)


def test_engagement_has_hysteresis():
    stage = Stage(fixture(placed(LINE), "guide", engage=0.01, release=0.02, rise=0.05, fall=0.05))
    for y, on in ((0.015, 0.0), (0.009, 1.0), (0.015, 1.0), (0.021, 0.0), (0.015, 0.0)):
        stage.settle(np.array([0.0, y, 0.0]), 100)
        assert stage.core.authority(0) == pytest.approx(on), y


@pytest.mark.parametrize(
    ("ramp", "half"),
    [
        (("pedal", 0.0, 1.0), {"pedal": 0.5}),
        (("distance", 0.01, 0.0), {}),
        (("force", 4.0, 2.0), {"F_hand": 3.0}),
    ],
)
def test_ramps_halve_the_authority_half_way(ramp, half):
    stage = Stage(fixture(plane(), ramps=[_core.Ramp(*ramp)]))
    stage.settle(at(-0.005), **half)
    assert stage.core.authority(0) == pytest.approx(0.5)


def test_a_ramp_of_time_runs_from_the_engagement():
    stage = Stage(
        fixture(placed(LINE), "guide", engage=0.01, release=0.01, rise=0.01, ramps=[_core.Ramp("time", 0, 1)])
    )
    stage.settle(np.array([0, 0.05, 0.0]), 500)
    stage.settle(np.array([0, 0.005, 0.0]), 500)
    assert stage.core.authority(0) == pytest.approx(0.5, abs=5e-3)


def test_soft_ones_add_and_a_hard_one_dominates():
    guide = fixture(placed(LINE, pose(at(-0.01))), "guide", name="down", law_={"K": 100.0})
    other = fixture(placed(LINE, pose(at(-0.01))), "guide", name="too", law_={"K": 50.0})
    np.testing.assert_allclose(Stage(guide, other).settle(at(-0.002))["F_T_W"][:3], [0, 0, -150 * 0.008], atol=1e-9)
    wall = fixture(plane(), name="wall", law_={"K": 400.0}, hard=True)
    out = Stage(guide, other, wall).settle(at(-0.002), 1000)
    np.testing.assert_allclose(out["F_T_W"][:3], [0, 0, 400.0 * (0.002 + RESERVE)], atol=1e-6)


def test_of_two_soft_ones_the_lower_priority_never_pulls_against_the_higher():
    high = fixture(plane(), name="wall", law_={"K": 400.0}, priority=1)
    low = fixture(placed(_core.PointGeometry(), pose([0.01, 0, -0.01])), "guide", name="goal", law_={"K": 100.0})
    F = Stage(high, low).settle(at(-0.002))["F_T_W"][:3]
    np.testing.assert_allclose(F, [1.0, 0, 0.8], atol=1e-9)


def test_optimise_finds_its_deviation_for_all_at_once():
    """Two walls that meet at 45 degrees: the spring pulls to the nearest place outside both, not by their sum."""
    tilt = Rotation.from_rotvec([0, np.pi / 4, 0]).as_matrix()
    walls = [fixture(plane(pose(R=R)), law="optimise", name=n) for n, R in (("a", np.eye(3)), ("b", tilt))]
    p = at(-0.004, -0.001)
    out = Stage(*walls).settle(p, 1000)
    n = np.array([[0, 0, 1.0], tilt[:, 2]])
    lam = np.linalg.solve(n @ n.T, -(n @ p))
    nearest = p + n.T @ np.maximum(lam, 0.0) if (lam > 0).all() else p - n[0] * (n[0] @ p)
    np.testing.assert_allclose(out["F_T_W"][:3], 400.0 * (nearest - p), atol=1e-6)
    np.testing.assert_array_equal(out["X_WT_goal"][:3, 3], p)


def test_an_admittance_master_is_given_the_damping_itself():
    f = fixture(placed(LINE), "guide", "admittance", law_={"B": 3.0, "ratio": 0.2})
    V = np.array([0.01, 0.02, 0, 0, 0, 0])
    as_wrench, as_damping = Stage(f), Stage(f)
    for _ in range(400):
        one = as_wrench.step(at(0.0), V=V)
        other = as_damping.step(at(0.0), V=V, takes_damping=True)
    np.testing.assert_allclose(one["F_T_W"][:3], -other["B_W"] @ V[:3], atol=1e-9)
    np.testing.assert_array_equal(other["F_T_W"][:3], 0.0)


def test_while_the_hand_is_let_go_nothing_is_felt_and_the_goal_is_still_kept_out():
    stage = Stage(fixture(plane(), hard=True))
    stage.settle(at(-0.005), 2000)
    out = stage.step(at(-0.005), engaged=False)
    np.testing.assert_array_equal(out["F_T_W"], 0.0)
    assert out["X_WT_goal"][2, 3] >= 0.0


# ---- never a step

RATE, MOMENT_RATE = 20.0, 0.35
EDITS = ["off", "gone", "gains", "law", "moved", "role", "hard", "authority", "other"]


def edited(what, rng):
    base = {"law_": {"K": 400.0}, "role_": {}}
    where = pose(at(0.0))
    if what == "off":
        return [fixture(plane(where), on=False, **base)]
    if what == "gone":
        return []
    if what == "gains":
        return [fixture(plane(where), law_={"K": rng.uniform(0, 2000)})]
    if what == "law":
        return [fixture(plane(where), law=str(rng.choice(["potential", "admittance", "optimise"])))]
    if what == "moved":
        return [fixture(plane(pose(rng.uniform(-0.01, 0.01, 3), Rotation.random(random_state=rng).as_matrix())))]
    if what == "role":
        return [fixture(sphere(0.02, where), str(rng.choice(["guide", "keep-in", "forbid", "orient"])))]
    if what == "hard":
        return [fixture(plane(where), hard=True, **base)]
    if what == "authority":
        return [fixture(plane(where), authority=rng.uniform(), rise=0.01, fall=0.01, **base)]
    return [fixture(plane(where), **base), fixture(sphere(0.02, where), "guide", name="two", law_={"K": 800.0})]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.lists(st.sampled_from(EDITS), min_size=2, max_size=5))
def test_a_still_hand_feels_no_step_whatever_is_switched_moved_or_edited(seed, edits):
    """The wrench changes by the rate at most, the goal by the return speed, in every tick."""
    rng = np.random.default_rng(seed)
    X = pose(rng.uniform(-0.006, 0.006, 3), Rotation.random(random_state=rng).as_matrix())
    stage = Stage(*edited("gains", rng))
    before, slowest = stage.settle(X, 100), _core.GuidanceOptions().return_speed
    for what in edits:
        stage.give(*edited(what, rng))
        for _ in range(60):
            out = stage.step(X)
            change = out["F_T_W"] - before["F_T_W"]
            assert np.linalg.norm(change[:3]) <= RATE * DT * (1 + 1e-9), what
            assert np.linalg.norm(change[3:]) <= MOMENT_RATE * DT * (1 + 1e-9), what
            moved = np.linalg.norm(out["X_WT_goal"][:3, 3] - before["X_WT_goal"][:3, 3])
            assert moved <= slowest * DT + RESERVE + 1e-12, what
            before = out


def test_a_hand_that_moves_feels_no_more_than_its_motion_explains():
    stage, rng = Stage(fixture(sphere(0.01), law_={"K": 500.0, "B": 0.0})), np.random.default_rng(1)
    before, p = stage.settle(at(0.02)), at(0.02)
    for _ in range(3000):
        last, p = p, 0.99 * p + rng.normal(size=3) * 2e-4
        out = stage.step(p)
        change = np.linalg.norm((out["F_T_W"] - before["F_T_W"])[:3])
        assert change <= 500.0 * np.linalg.norm(p - last) + RATE * DT + 1e-9
        before = out


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e300])
def test_numbers_that_are_none_are_answered_by_finite_ones(bad):
    """Of touch and operator; poses are checked before the stage."""
    made = [
        fixture(sphere(0.1), "limit", name="f", role_={"force": 1.0}, hard=True),
        fixture(plane(), ramps=[_core.Ramp("force", 4.0, 2.0)]),
    ]
    out = Stage(*made).settle(at(-0.003), 50, F_T_W=np.full(3, bad), stiffness=bad, F_hand=bad, pedal=bad)
    assert np.isfinite(out["F_T_W"]).all()
    assert np.isfinite(out["X_WT_goal"]).all()


def test_springs_and_potentials_give_no_energy_around_a_closed_motion():
    """What the hand gets back over many rounds in and out of soft fixtures is no more than it put in."""
    made = [
        fixture(sphere(0.02), law_={"K": 400.0}),
        fixture(placed(LINE, pose(at(0.01))), "guide", "potential", name="two"),
    ]
    stage = Stage(*made)
    stage.settle(at(0.03))
    s = np.linspace(0, 10 * np.pi, 20001)
    hand = np.stack([0.01 * np.sin(2 * s), 0.012 * np.sin(s), 0.012 + 0.018 * np.cos(s)], axis=1)
    F = np.array([stage.step(p)["F_T_W"][:3] for p in hand])
    work = (F[:-1] * np.diff(hand, axis=0)).sum()
    exchanged = np.abs(F[:-1] * np.diff(hand, axis=0)).sum()
    assert work < 2e-3 * exchanged
