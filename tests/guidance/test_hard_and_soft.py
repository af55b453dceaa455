"""The stage: soft fixtures pull, hard fixtures also correct the goal; a tool behind its servo stays outside."""

import numpy as np
import pytest
from fixtures import DT, LINE, RESERVE, Stage, fixture, placed, plane, point_at_height, pose, sphere
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance

GUIDED, CORRECTED, CONFLICT = 1 << 20, 1 << 21, 1 << 22


def test_goal_without_fixtures_is_the_mapped_goal_bit_for_bit():
    stage, rng = Stage(bandwidth=30.0), np.random.default_rng(0)
    for _ in range(50):
        X = pose(rng.normal(size=3), Rotation.random(random_state=rng).as_matrix())
        out = stage.step(X)
        np.testing.assert_array_equal(out["X_WT_goal"], X)
        np.testing.assert_array_equal(out["F_T_W"], 0.0)
        assert out["status"] == 0


def test_soft_fixture_renders_its_spring_to_a_resting_hand():
    stage = Stage(fixture(plane(), law_={"K": 400.0}))
    out = stage.settle(point_at_height(-0.005))
    np.testing.assert_allclose(out["F_T_W"][:3], [0, 0, 2.0], atol=1e-9)
    np.testing.assert_array_equal(out["X_WT_goal"][:3, 3], point_at_height(-0.005))
    assert (out["strongest"], out["gap"], out["status"]) == (0, pytest.approx(-0.005), GUIDED)


def test_hard_fixture_keeps_the_goal_outside_and_renders_the_deviation():
    stage = Stage(fixture(plane(), law_={"K": 400.0}, hard=True))
    stage.settle(point_at_height(0.01))
    for z in np.linspace(0.01, -0.005, 300):
        out = stage.step(point_at_height(z))
        assert out["X_WT_goal"][2, 3] >= 0.0
    out = stage.settle(point_at_height(-0.005))
    np.testing.assert_allclose(out["X_WT_goal"][:3, 3], [0, 0, RESERVE], atol=1e-9)
    np.testing.assert_allclose(out["F_T_W"][:3], [0, 0, 400.0 * (0.005 + RESERVE)], atol=1e-6)
    np.testing.assert_allclose(out["correction"], [0, 0, 0.005 + RESERVE], atol=1e-9)
    assert out["status"] == GUIDED | CORRECTED


def test_hard_guide_keeps_the_goal_on_the_line():
    stage = Stage(fixture(placed(LINE), "guide", hard=True))
    out = stage.settle(np.array([0.03, 0.004, -0.003]), ticks=2000)
    np.testing.assert_allclose(out["X_WT_goal"][:3, 3], [0.03, 0.0, 0.0], atol=1e-9)


def test_hard_orient_rotates_the_goal():
    R = Rotation.from_rotvec([0.3, 0.0, 0.0]).as_matrix()
    stage = Stage(fixture(plane(), "orient", hard=True))
    out = stage.settle(pose(point_at_height(0.05), R), ticks=3000)
    np.testing.assert_allclose(out["X_WT_goal"][:3, 2], [0, 0, 1], atol=1e-5)
    np.testing.assert_allclose(out["F_T_W"][3:], [-0.5 * 0.3, 0, 0], atol=1e-3)


def test_hard_rcm_keeps_the_shaft_through_the_point():
    X = pose([0.003, 0.0, 0.1])
    stage = Stage(fixture(placed(_guidance.PointGeometry()), "rcm", hard=True))
    goal = stage.settle(X, ticks=3000)["X_WT_goal"]
    a, p = goal[:3, 2], goal[:3, 3]
    assert np.linalg.norm(p - a * (a @ p)) < 1e-5


def test_goal_at_three_hard_planes_is_the_nearest_feasible_point():
    walls = [
        fixture(plane(pose(R=Rotation.align_vectors([n], [[0, 0, 1]])[0].as_matrix())), name=str(n), hard=True)
        for n in np.eye(3)
    ]
    out = Stage(*walls).settle(np.array([-0.003, -0.004, -0.005]), ticks=1000)
    np.testing.assert_allclose(out["X_WT_goal"][:3, 3], RESERVE, atol=1e-9)
    assert out["status"] & CONFLICT == 0


def test_contradicting_hard_fixtures_yield_by_priority_and_report_it():
    up = fixture(plane(pose(point_at_height(0.002))), name="above", hard=True, priority=1)  # z >= 2 mm
    down = fixture(
        plane(pose(point_at_height(-0.002), np.diag([1.0, -1.0, -1.0]))), name="below", hard=True
    )  # z <= -2 mm
    out = Stage(up, down).settle(point_at_height(0.0), ticks=1000)
    assert out["X_WT_goal"][2, 3] == pytest.approx(0.002 + RESERVE)
    assert out["status"] & CONFLICT


def test_goal_does_not_pass_through_a_thin_forbidden_plate():
    """The goal keeps its side, although the other side is closer to the hand."""
    plate = placed(_guidance.SurfaceGeometry(_core.Box(np.array([0.2, 0.2, 0.002]))))
    stage = Stage(fixture(plate, hard=True))
    stage.settle(point_at_height(0.005))
    for z in np.concatenate([np.linspace(0.005, -0.02, 50), np.full(300, -0.02)]):
        out = stage.step(point_at_height(z))
        assert out["X_WT_goal"][2, 3] >= 0.001 - 1e-9
    assert out["F_T_W"][2] > 1.0


@pytest.mark.parametrize("kind", ["plane", "sphere", "cavity", "corner"])
@pytest.mark.parametrize("moving", [False, True])
def test_tool_behind_a_servo_stays_outside_for_any_hand_motion(kind, moving):
    """With a 30 Hz servo and at least 0.4 m/s towards the border, the tool enters by at most 0.1 mm."""
    waves = [_core.Wave(shift=np.array([0.002, 0.0, 0.004]), turn=np.zeros(3), period=0.8)]
    motion = _core.Motion(waves=waves) if moving else None
    made = {
        "plane": [fixture(plane(motion=motion), hard=True)],
        "sphere": [fixture(sphere(0.02, pose(point_at_height(-0.004)), motion), hard=True)],
        "cavity": [fixture(sphere(0.03, pose(point_at_height(0.03)), motion), "keep-in", hard=True)],
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
            gap = f.evaluate(stage.X_tool, stage.k * DT)["gap"]
            deepest, touched = min(deepest, gap), touched + (gap < 5e-4)
        assert deepest > -1e-4, f"{1e3 * -deepest:.3f} mm in at {k + start} ms"
    assert touched > 100, "control: the tool reached the border"


def test_speed_is_limited_and_the_lag_is_rendered():
    stage = Stage(fixture(sphere(0.1), "limit", role_={"speed": 0.02}, hard=True), force_rate=1e3)
    z = 0.0
    stage.settle(point_at_height(z), ticks=400)
    before = point_at_height(z)
    for _ in range(100):
        z += 0.1 * DT
        out = stage.step(point_at_height(z))
        after = out["X_WT_goal"][:3, 3]
        assert np.linalg.norm(after - before) <= 0.02 * DT + 1e-12
        before = after
    assert out["F_T_W"][2] < -0.5
    out = stage.settle(point_at_height(z), ticks=2000)
    np.testing.assert_allclose(out["X_WT_goal"][:3, 3], point_at_height(z), atol=1e-12)


@pytest.mark.parametrize("law", ["spring", "optimise"])
def test_goal_in_a_corner_keeps_all_walls_and_the_wrench_is_constant(law):
    """With the hand beyond a corner of a keep-in box, the goal is in the corner; the force is that of the deviation."""
    box = placed(_guidance.SurfaceGeometry(_core.Box(np.full(3, 0.04))))
    hard = law == "spring"
    stage = Stage(fixture(box, "keep-in", law, law_={"K": 400.0, "B": 0.0, "force": 9.0}, hard=hard))
    hand = np.array([0.024, 0.023, -0.022])
    stage.settle(np.zeros(3))
    stage.settle(hand, ticks=2000)
    outputs = [stage.step(hand) for _ in range(20)]
    corner = 0.02 * np.sign(hand) - hard * RESERVE * np.sign(hand)
    for out in outputs:
        np.testing.assert_allclose(out["F_T_W"][:3], 400.0 * (corner - hand), atol=1e-6)
        np.testing.assert_allclose(out["X_WT_goal"][:3, 3], corner if hard else hand, atol=1e-9)


@pytest.mark.parametrize("authority", [1.0, 0.5])
def test_hard_force_limit_allows_the_penetration_of_its_force(authority):
    """The tool is on a spring of 1000 N/m: 4 mm are commanded, 2 N allow 2 mm, the hand feels the rest."""
    limit = fixture(sphere(0.1), "limit", role_={"force": 2.0}, law_={"K": 400.0}, hard=True, authority=authority)
    stage, depth = Stage(limit), 0.004
    for _ in range(2000):
        touched = 0.0 if stage.X_tool is None else max(-stage.X_tool[2, 3], 0.0)
        out = stage.step(point_at_height(-depth), F_T_W=np.array([0.0, 0.0, 1000.0 * touched]), stiffness=1000.0)
    left = depth - authority * (depth - 0.002)
    assert out["X_WT_goal"][2, 3] == pytest.approx(-left, abs=2 * RESERVE)
    assert out["F_T_W"][2] == pytest.approx(authority * 400.0 * 0.002, abs=400.0 * 2 * RESERVE)
