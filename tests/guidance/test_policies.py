"""The stage: activation of fixtures by authority, engagement and ramps, and combinations of fixtures."""

import numpy as np
import pytest
from fixtures import DT, LINE, RESERVE, Stage, fixture, placed, plane, point_at_height, pose
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance


def test_authority_scales_the_force_and_rises_at_its_rate():
    stage = Stage(fixture(plane(), law_={"K": 400.0}, authority=0.5, rise=0.1))
    seen = [stage.step(point_at_height(-0.005)) and stage.core.authority(0) for _ in range(100)]
    assert np.diff(seen).max() <= DT / 0.1 + 1e-12
    assert seen[-1] == 0.5
    assert stage.settle(point_at_height(-0.005))["F_T_W"][2] == pytest.approx(1.0)


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
def test_ramps_halve_the_authority_at_their_middle(ramp, half):
    stage = Stage(fixture(plane(), ramps=[_core.Ramp(*ramp)]))
    stage.settle(point_at_height(-0.005), **half)
    assert stage.core.authority(0) == pytest.approx(0.5)


def test_time_ramp_starts_at_the_engagement():
    stage = Stage(
        fixture(placed(LINE), "guide", engage=0.01, release=0.01, rise=0.01, ramps=[_core.Ramp("time", 0, 1)])
    )
    stage.settle(np.array([0, 0.05, 0.0]), 500)
    stage.settle(np.array([0, 0.005, 0.0]), 500)
    assert stage.core.authority(0) == pytest.approx(0.5, abs=5e-3)


def test_soft_fixtures_add_and_a_hard_one_dominates():
    guide = fixture(placed(LINE, pose(point_at_height(-0.01))), "guide", name="down", law_={"K": 100.0})
    other = fixture(placed(LINE, pose(point_at_height(-0.01))), "guide", name="too", law_={"K": 50.0})
    np.testing.assert_allclose(
        Stage(guide, other).settle(point_at_height(-0.002))["F_T_W"][:3], [0, 0, -150 * 0.008], atol=1e-9
    )
    wall = fixture(plane(), name="wall", law_={"K": 400.0}, hard=True)
    out = Stage(guide, other, wall).settle(point_at_height(-0.002), 1000)
    np.testing.assert_allclose(out["F_T_W"][:3], [0, 0, 400.0 * (0.002 + RESERVE)], atol=1e-6)


def test_lower_priority_never_pulls_against_a_higher_one():
    """A thousandth of the force is left, so that the goal which the wall leaves is determined."""
    high = fixture(plane(), name="wall", law_={"K": 400.0}, priority=1)
    low = fixture(placed(_guidance.PointGeometry(), pose([0.01, 0, -0.01])), "guide", name="goal", law_={"K": 100.0})
    F = Stage(high, low).settle(point_at_height(-0.002))["F_T_W"][:3]
    np.testing.assert_allclose(F, [1.0, 0, 0.8], atol=2e-3)


def test_optimise_finds_the_deviation_for_all_walls_at_once():
    """Two walls meet at 45 degrees: the spring pulls to the nearest point outside both walls."""
    tilt = Rotation.from_rotvec([0, np.pi / 4, 0]).as_matrix()
    walls = [fixture(plane(pose(R=R)), law="optimise", name=n) for n, R in (("a", np.eye(3)), ("b", tilt))]
    p = point_at_height(-0.004, -0.001)
    out = Stage(*walls).settle(p, 1000)
    n = np.array([[0, 0, 1.0], tilt[:, 2]])
    lam = np.linalg.solve(n @ n.T, -(n @ p))
    nearest = p + n.T @ np.maximum(lam, 0.0) if (lam > 0).all() else p - n[0] * (n[0] @ p)
    np.testing.assert_allclose(out["F_T_W"][:3], 400.0 * (nearest - p), atol=1e-6)
    np.testing.assert_array_equal(out["X_WT_goal"][:3, 3], p)


def test_admittance_master_receives_the_damping_matrix():
    f = fixture(placed(LINE), "guide", "admittance", law_={"B": 3.0, "ratio": 0.2})
    V = np.array([0.01, 0.02, 0, 0, 0, 0])
    as_wrench, as_damping = Stage(f), Stage(f)
    for _ in range(400):
        one = as_wrench.step(point_at_height(0.0), V=V)
        other = as_damping.step(point_at_height(0.0), V=V, takes_damping=True)
    np.testing.assert_allclose(one["F_T_W"][:3], -other["B_W"] @ V[:3], atol=1e-9)
    np.testing.assert_array_equal(other["F_T_W"][:3], 0.0)


def test_released_handle_gets_no_force_but_the_goal_stays_outside():
    stage = Stage(fixture(plane(), hard=True))
    stage.settle(point_at_height(-0.005), 2000)
    out = stage.step(point_at_height(-0.005), engaged=False)
    np.testing.assert_array_equal(out["F_T_W"], 0.0)
    assert out["X_WT_goal"][2, 3] >= 0.0


def test_optimise_keeps_its_force_at_rest_where_borders_nearly_oppose_each_other():
    """Two walls at 176 degrees: their common correction grows with their authority, and so does the force at rest."""
    a = np.radians(88.0)
    walls = []
    for k, n in enumerate(([np.sin(a), 0.0, np.cos(a)], [-np.sin(a), 0.0, np.cos(a)])):
        R = Rotation.align_vectors([n], [[0.0, 0.0, 1.0]])[0].as_matrix()
        walls.append(fixture(plane(pose(R=R)), law="optimise", name=f"wall {k}", law_={"B": 0.0, "force": 1.0}))
    stage = Stage(*walls)
    stage.settle(point_at_height(-0.001), 2000)
    forces = [np.linalg.norm(stage.core.wrench(k)[:3]) for k in range(2)]
    assert min(forces) > 0.1
