"""Hard fixtures beside a guiding surface leave the nearest place that all allow, and the goal follows by a map."""

import numpy as np
import pytest
from fixtures import RESERVE, Stage, fixture, placed, plane, pose
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance

R = 0.0115
WALL = Rotation.align_vectors([(-0.4, 0.1, 0.9)], [[0.0, 0.0, 1.0]])[0].as_matrix()


def stage():
    """A guide to a ball of radius R, and a wall through it."""
    guide = fixture(placed(_guidance.SurfaceGeometry(_core.Sphere(R))), "guide", name="ball", hard=True)
    return Stage(guide, fixture(plane(pose((0.0, 0.0, 0.002), WALL)), name="wall", hard=True))


def nearest(x, start):
    """The nearest place on the ball and outside the wall, by SciPy."""
    n = WALL[:, 2]
    found = minimize(
        lambda y: 1e6 * ((y - x) ** 2).sum(), start, method="SLSQP", options={"ftol": 1e-14, "maxiter": 500},
        constraints=[{"type": "eq", "fun": lambda y: 1e3 * (np.linalg.norm(y) - R)},
                     {"type": "ineq", "fun": lambda y: 1e3 * ((y - (0, 0, 0.002)) @ n - RESERVE)}],
    )  # fmt: skip
    return found.x


@pytest.mark.parametrize("x", [(0.004, 0.003, -0.002), (-0.003, 0.005, -0.003), (0.006, -0.002, -0.001)])
def test_goal_is_the_nearest_place_and_follows_by_its_derivative(x):
    """Cutting planes alone left it up to some millimetres away."""
    one = stage()
    one.settle(x, 3000)
    step, found = 2e-5 * np.array([0.6, -0.5, 0.6]), []
    for y in (x, x + step):
        out = one.settle(y, 40)
        found.append(out["X_WT_goal"][:3, 3])
        np.testing.assert_allclose(found[-1], nearest(np.array(y), found[-1]), atol=2e-6)
    np.testing.assert_allclose(found[1] - found[0], out["J_goal"][:3, :3] @ step, atol=2e-7)
