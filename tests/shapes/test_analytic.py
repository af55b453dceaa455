"""Closed-form shapes: gradients against differences, convergence of tessellations, offsets of tool paths."""

import numpy as np
import pytest

from palpate.world.shapes.analytic import SHAPES
from palpate.world.shapes.paths import SLIDE, tool_path


@pytest.mark.parametrize("name", sorted(SHAPES))
def test_normal_is_the_gradient_of_the_distance(name):
    shape = SHAPES[name]
    points = shape.curve(np.random.default_rng(0).random(200), 0.4e-3 if name == "plate" else 1e-3)
    phi, normal = shape.distance(points)
    h = 1e-7
    for k in range(3):
        step = np.eye(3)[k] * h
        slope = (shape.distance(points + step)[0] - shape.distance(points - step)[0]) / (2 * h)
        smooth = np.abs(points[:, 0]) > 1e-3 if name == "groove" else np.full(len(phi), True)
        np.testing.assert_allclose(slope[smooth], normal[smooth, k], atol=1e-5)


@pytest.mark.parametrize("name", sorted(SHAPES))
@pytest.mark.parametrize("n", [12, 1000, 20_000])
def test_tessellation_lies_on_the_surface_and_faces_out(name, n):
    shape = SHAPES[name]
    vertices, faces = shape.mesh(n)
    assert np.abs(shape.distance(vertices)[0]).max() < 1e-12
    if n >= 1000:
        assert abs(len(faces) / n - 1) < 0.2
        corners = vertices[faces]
        out = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert ((out * shape.distance(corners.mean(axis=1))[1]).sum(axis=1) > 0).all()


@pytest.mark.parametrize("name", ["sphere", "torus", "box", "wavy"])
@pytest.mark.parametrize(("offset", "speed"), [(-2e-3, 0.05), (1e-3, 0.05), (-2e-3, 0.2)])
def test_tool_path_has_its_depth_and_speed(name, offset, speed):
    shape = SHAPES[name]
    path = tool_path(shape, offset, speed, 2e-3)
    assert path.tips.shape == (20_000, 3)
    slide = path.tips[path.steady]
    assert len(slide) == SLIDE - 100
    np.testing.assert_allclose(shape.distance(slide)[0], offset, atol=1e-6)
    steps = np.linalg.norm(np.diff(slide, axis=0), axis=1)
    assert abs(steps / (speed / 1000) - 1).max() < 0.05
    assert shape.distance(path.tips[[0, -1]])[0].min() > 0.01


def test_groove_pushes_a_sphere_with_both_walls():
    """Karush-Kuhn-Tucker: the sphere is outside both walls, and only touched walls push it."""
    r, points = 2e-3, np.random.default_rng(2).uniform(-8e-3, 8e-3, (500, 3))
    depth, direction = SHAPES["groove"].held(points, r)
    centre = points + depth[:, None] * direction
    walls = np.array([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0]]) / 2**0.5
    gap = centre @ walls.T - r
    push = (depth[:, None] * direction) @ walls.T  # the walls are perpendicular, so components are multipliers
    assert gap.min() > -1e-12
    assert push.min() > -1e-12
    assert np.abs(gap * push).max() < 1e-15
    np.testing.assert_allclose(push @ walls, depth[:, None] * direction, atol=1e-15)
