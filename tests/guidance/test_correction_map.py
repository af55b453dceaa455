"""The map from mapped to corrected goal: its Jacobian against differences of settled goals, and closed forms."""

import numpy as np
import pytest
from fixtures import LINE, Stage, fixture, placed, plane, point_at_height, pose, sphere
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance

PRESS = {"F_T_W": np.array([0.3, -0.2, 0.5])}
TURNED = Rotation.from_rotvec([0.3, 0.1, -0.2]).as_matrix()
BOX = placed(_guidance.SurfaceGeometry(_core.Box(np.full(3, 0.04))))
POINT = placed(_guidance.PointGeometry())
CASES = {  # fixtures, mapped goal, where the goal starts
    "plane": ([fixture(plane(), hard=True)], (0.001, 0.002, -0.004), (0, 0, 0.003)),
    "plane, authority 0.6": ([fixture(plane(), hard=True, authority=0.6)], (0.001, 0.002, -0.004), (0, 0, 0.003)),
    "ball": ([fixture(sphere(0.02), hard=True)], (0.005, 0.001, 0.014), (0, 0, 0.023)),
    "room": ([fixture(sphere(0.02), "keep-in", hard=True)], (0.005, 0.001, 0.024), (0, 0, 0.013)),
    "line": ([fixture(placed(LINE), "guide", hard=True)], (0.005, 0.001, 0.004), (0, 0, 0)),
    "point": ([fixture(POINT, "guide", hard=True)], (0.005, 0.001, 0.004), (0, 0, 0)),
    "line with a margin": (
        [fixture(placed(LINE), "guide", role_={"margin": 0.002}, hard=True)], (0.005, 0.001, 0.004), (0, 0, 0),
    ),
    "edge of a box": ([fixture(BOX, "keep-in", hard=True)], (0.024, 0.023, -0.003), (0, 0, 0)),
    "plane and ball": (
        [fixture(plane(), name="a", hard=True), fixture(sphere(0.02, pose((0.03, 0, 0.01))), name="b", hard=True)],
        (0.017, 0.002, -0.004), (0.0, 0.0, 0.005),
    ),
}  # fmt: skip


def turned(X, step):
    out = X.copy()
    out[:3, 3] += step[:3]
    out[:3, :3] = Rotation.from_rotvec(step[3:]).as_matrix() @ X[:3, :3]
    return out


def difference(X_a, X_b):
    return np.r_[X_b[:3, 3] - X_a[:3, 3], Rotation.from_matrix(X_b[:3, :3] @ X_a[:3, :3].T).as_rotvec()]


@pytest.mark.parametrize("name", CASES)
def test_jacobian_is_the_derivative_of_the_settled_goal(name):
    made, p, start = CASES[name]
    stage, X, h = Stage(*made), pose(p), 5e-4
    stage.settle(np.array(start, float), 300)
    J = stage.settle(X, 1500, **PRESS)["J_goal"]
    found = np.zeros((6, 6))
    for k, step in enumerate(h * np.eye(6)):
        goals = [stage.settle(turned(X, sign * step), 500, **PRESS)["X_WT_goal"] for sign in (-1.0, 1.0)]
        found[:, k] = difference(*goals) / (2 * h)
    np.testing.assert_allclose(J, found, atol=6e-3)


def test_jacobian_on_curved_borders_is_the_closed_form():
    """R / (R - d) along a ball entered by d, R / (R + d) along a room left by d; zero across."""
    for made, p, start, factor in (
        (fixture(sphere(0.02), hard=True), 0.015, 0.023, 20.05 / 15.0),
        (fixture(sphere(0.02), "keep-in", hard=True), 0.024, 0.013, 19.95 / 24.0),
    ):
        stage = Stage(made)
        stage.settle(point_at_height(start), 300)
        J = stage.settle(point_at_height(p), 1500, **PRESS)["J_goal"]
        np.testing.assert_allclose(J[:3, :3], np.diag([factor, factor, 0.0]), atol=2e-3)
        np.testing.assert_allclose(J[3:, 3:], np.eye(3), atol=1e-9)


def test_hard_orient_turns_the_goal_about_its_target_alone():
    stage = Stage(fixture(plane(), "orient", hard=True))
    J = stage.settle(pose(point_at_height(0.05), TURNED), 3000, **PRESS)["J_goal"]
    z = np.array([0.0, 0.0, 1.0])
    assert np.abs(J[3:5, 3:]).max() < 5e-3, "the target axis stays"
    assert z @ J[3:, 3:] @ z == pytest.approx(1.0, abs=1e-3)
