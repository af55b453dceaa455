"""Queries of surfaces other than meshes, against closed forms, dense sampling and finite differences."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core
from palpate.world.shapes.analytic import SHAPES

POINTS = np.random.default_rng(3).uniform(-0.06, 0.06, (3000, 3))
PILLOW = _core.ImplicitSurface(np.array([0.03, 0.02, 0.04]) ** [-4.0, -2.0, -6.0], [4, 2, 6], 1.0)
ROUND = {
    "plane": (_core.Plane(), lambda p: p[:, 2]),
    "sphere": (_core.Sphere(0.03), lambda p: np.linalg.norm(p, axis=1) - 0.03),
    "box": (_core.Box(np.array([0.04, 0.04, 0.04])), lambda p: SHAPES["box"].distance(p)[0]),
    "cylinder": (_core.Cylinder(0.02, 0.05), lambda p: box_2d(np.hypot(p[:, 0], p[:, 1]) - 0.02, abs(p[:, 2]) - 0.025)),
    "capsule": (
        _core.Capsule(0.01, 0.05),
        lambda p: np.hypot(np.hypot(p[:, 0], p[:, 1]), np.maximum(abs(p[:, 2]) - 0.025, 0.0)) - 0.01,
    ),
}


def box_2d(x, y):
    return np.hypot(np.maximum(x, 0.0), np.maximum(y, 0.0)) + np.minimum(np.maximum(x, y), 0.0)


def sampled(shape, spacing, low, high):
    """A sampled grid of an analytic shape."""
    low, high = np.array(low), np.array(high)
    nodes = np.round((high - low) / spacing).astype(int) + 1
    axes = np.meshgrid(*(low[a] + spacing * np.arange(nodes[a]) for a in range(3)), indexing="ij")
    values = SHAPES[shape].distance(np.stack(axes, axis=-1).reshape(-1, 3))[0].reshape(nodes).astype(np.float32)
    return _core.DistanceGrid(low, np.full(3, spacing), values)


@pytest.mark.parametrize("name", ROUND)
def test_primitives_have_their_closed_forms(name):
    surface, exact = ROUND[name]
    distance, point, normal = surface.nearest(POINTS)
    np.testing.assert_allclose(distance, exact(POINTS), rtol=0, atol=1e-16)
    np.testing.assert_allclose(exact(point), 0.0, atol=1e-16)
    np.testing.assert_allclose(point + distance[:, None] * normal, POINTS, atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-15)


@pytest.mark.parametrize("name", ROUND)
def test_normal_exists_on_the_medial_axis_and_on_the_surface(name):
    surface, exact = ROUND[name]
    on_axis = np.array([[0, 0, 0], [0, 0, 0.001], [0, 0, -0.06], [0, 0, 0.0], [0.01, 0.01, 0.01]])
    on_surface = surface.nearest(POINTS[:200])[1]
    distance, _, normal = surface.nearest(np.concatenate([on_axis, on_surface]))
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-9)
    np.testing.assert_allclose(distance[:5], exact(on_axis), atol=1e-16)


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), half=st.lists(st.floats(1e-3, 1.0), min_size=3, max_size=3))
def test_gradient_of_an_implicit_surface_matches_finite_differences(seed, half):
    """Eq 15: the analytic gradient and central differences agree to 1e-7 of its length."""
    rng = np.random.default_rng(seed)
    exponents = rng.choice([2, 4, 6, 8], 3)
    u = _core.ImplicitSurface(np.array(half) ** -exponents.astype(float), exponents.tolist(), 1.0)
    p = np.array(half) * rng.uniform(0.2, 1.2, 3) * rng.choice([-1, 1], 3)
    steps = 1e-5 * np.diag(half)
    numeric = [(u.value(p + e) - u.value(p - e)) / (2 * np.abs(e).max()) for e in steps]
    np.testing.assert_allclose(numeric, u.gradient(p), rtol=0, atol=1e-7 * np.linalg.norm(u.gradient(p)))


def test_implicit_surface_finds_the_global_nearest_point():
    """Reference: 40 000 points of the surface; queries outside and inside, near and beyond its medial axis."""
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(40_000, 3)) * [0.03, 0.02, 0.04]
    low, high = np.zeros(len(directions)), np.full(len(directions), 100.0)
    for _ in range(60):  # bisection along each direction
        middle = 0.5 * (low + high)
        beyond = ((middle[:, None] * directions / [0.03, 0.02, 0.04]) ** [4, 2, 6]).sum(axis=1) > 1.0
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    samples = low[:, None] * directions
    points = POINTS[:120]
    distance, point, normal = PILLOW.nearest(points)
    best = np.array([np.linalg.norm(samples - p, axis=1).min() for p in points])
    assert (abs(distance) <= best + 1e-9).all()
    assert (abs(distance) >= best - 1e-3).all()  # tolerance for the spacing of the samples
    np.testing.assert_allclose([PILLOW.value(q) for q in point], 0.0, atol=1e-12)
    np.testing.assert_allclose(point + distance[:, None] * normal, points, atol=1e-8)
    assert (np.sign(distance) == [np.sign(PILLOW.value(p)) for p in points]).all()


def test_ellipsoid_of_equal_axes_is_a_sphere():
    ball = _core.ImplicitSurface(np.full(3, 0.03**-2.0), [2, 2, 2], 1.0)
    distance, point, normal = ball.nearest(POINTS)
    exact = _core.Sphere(0.03).nearest(POINTS)
    np.testing.assert_allclose(distance, exact[0], atol=1e-12)
    unique = np.linalg.norm(POINTS, axis=1) > 1e-3  # near the centre all surface points are equally near
    np.testing.assert_allclose(point[unique], exact[1][unique], atol=1e-9)
    np.testing.assert_allclose(normal[unique], exact[2][unique], atol=1e-7)


def test_grid_gradient_matches_finite_differences():
    grid = sampled("torus", 0.002, (-0.0603, -0.0603, -0.02), (0.06, 0.06, 0.02))
    rng = np.random.default_rng(2)
    for p in rng.uniform([-0.05, -0.05, -0.018], [0.05, 0.05, 0.018], (100, 3)):
        steps = 1e-7 * np.eye(3)
        numeric = [(grid.value(p + e)[0] - grid.value(p - e)[0]) / 2e-7 for e in steps]
        np.testing.assert_allclose(numeric, grid.value(p)[1], atol=1e-6)


@pytest.mark.parametrize(("spacing", "distance_error", "degrees"), [(0.002, 5e-6, 0.5), (0.001, 5e-7, 0.1)])
def test_grid_converges_to_the_shape(spacing, distance_error, degrees):
    """Third order: half the spacing gives an eighth of the error."""
    grid = sampled("torus", spacing, (-0.0603, -0.0603, -0.02), (0.06, 0.06, 0.02))
    s = np.random.default_rng(4).uniform(0, 5, 500)
    for offset in (-0.005, 0.0, 0.003):
        points = SHAPES["torus"].curve(s, offset)
        distance, point, normal = grid.nearest(points)
        exact, n = SHAPES["torus"].distance(points)
        np.testing.assert_allclose(distance, exact, atol=distance_error)
        assert np.degrees(np.arccos(np.clip((normal * n).sum(axis=1), -1, 1))).max() < degrees
        np.testing.assert_allclose(SHAPES["torus"].distance(point)[0], 0.0, atol=distance_error)


def test_distance_outside_a_grid_is_continuous_and_a_lower_bound():
    grid = sampled("sphere", 0.002, (-0.034, -0.034, -0.034), (0.034, 0.034, 0.034))
    points = POINTS * 3
    distance, _, normal = grid.nearest(points)
    exact = SHAPES["sphere"].distance(points)[0]
    outside = np.abs(points).max(axis=1) > 0.034
    assert (distance[outside] <= exact[outside] + 1e-6).all()
    assert (distance[outside] >= 0.5 * exact[outside]).all()
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-12)
    edge = np.clip(points, -0.034, 0.034)
    step = 1e-6 * (edge / np.abs(edge).max(axis=1, keepdims=True))
    inner, outer = grid.nearest(edge * (1 - 1e-9))[0], grid.nearest(edge + step)[0]
    assert np.abs(outer - inner).max() < 5e-6


def test_solid_ends_at_the_edge_of_its_grid():
    """A grid of a half-space is closed at the sides of the grid."""
    z = np.linspace(-0.01, 0.01, 21)
    values = np.broadcast_to(z, (21, 21, 21)).astype(np.float32)
    patch = _core.DistanceGrid(np.full(3, -0.01), np.full(3, 0.001), np.ascontiguousarray(values))
    top, side, outside, below = patch.nearest(
        np.array([[0, 0, 0.002], [0.0095, 0, -0.005], [0.012, 0, -0.005], [0, 0, -0.013]])
    )[0]
    np.testing.assert_allclose([top, side, outside, below], [0.002, -0.0005, 0.002, 0.003], atol=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: _core.Sphere(0.0), "radius of a sphere must be a positive length"),
        (lambda: _core.Box(np.array([0.1, -1.0, 0.1])), "side of a box must be a positive length"),
        (lambda: _core.Cylinder(0.1, np.inf), "length of a cylinder must be a positive length"),
        (lambda: _core.Capsule(np.nan, 0.1), "radius of a capsule must be a positive length"),
        (lambda: _core.ImplicitSurface(np.ones(3), [2, 3, 2], 1.0), "exponents .* must be 2, 4, ... 12, got 3"),
        (lambda: _core.ImplicitSurface(np.array([1.0, 0, 1]), [2, 2, 2], 1.0), "coefficients .* must be positive"),
        (lambda: _core.ImplicitSurface(np.ones(3), [2, 2, 2], 0.0), "level .* must be positive"),
        (lambda: grid_of(np.ones((5, 5, 5))), "no surface inside"),
        (lambda: grid_of(np.full((5, 5, 5), np.nan)), "values must be finite"),
        (lambda: grid_of(np.ones((3, 5, 5))), "at least 4 nodes along each axis, got 3 x 5 x 5"),
        (lambda: grid_of(np.random.default_rng(0).normal(size=(5, 5, 5))), "a distance by 1 at most"),
    ],
)
def test_invalid_surfaces_are_rejected(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def grid_of(values):
    return _core.DistanceGrid(np.zeros(3), np.full(3, 0.001), values.astype(np.float32))


@pytest.mark.parametrize("wall", [0.025, 0.028])
def test_distant_query_of_a_small_ball_finds_the_nearest_surface(wall):
    """At ten times the radius the search along tangent planes deviates; surfaces beyond the grid do not count."""
    nodes = np.moveaxis(np.indices((81, 81, 61)), 0, -1) * 0.0005 - [0.02, 0.02, 0.004]
    distance = lambda p: np.minimum(np.linalg.norm(p, axis=-1) - 0.002, wall - p[..., 2])  # noqa: E731
    grid = _core.DistanceGrid(nodes[0, 0, 0], np.full(3, 0.0005), distance(nodes).astype(np.float32))
    points = np.random.default_rng(1).uniform(nodes[0, 0, 0], nodes[-1, -1, -1] - [0, 0, 0.002], (20_000, 3))
    outside = distance(points) > 0
    found = grid.nearest(points)[0]
    np.testing.assert_allclose(found[outside], distance(points)[outside], atol=0.001)  # two cells, away from the ridge
