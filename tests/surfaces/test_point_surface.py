"""The surface through a point cloud against the closed forms of the shapes that were sampled."""

import numpy as np
import pytest

import palpate
from palpate.base.errors import PalpateWarning, SurfaceError
from palpate.scene.contact import render
from palpate.world import surfaces
from palpate.world.clouds.neighbourhoods import sampling
from palpate.world.registration.clouds import sampled
from palpate.world.shapes import analytic

STIFFNESS, RADIUS = 1000.0, 3e-3


def sampled_shape(shape, spacing, noise, seed=1):
    vertices, triangles = shape.mesh(40_000)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    points = sampled(vertices, triangles, int(area / spacing**2), seed=3)
    return points + noise * np.random.default_rng(seed).normal(size=points.shape)


def errors(surface, shape):
    """Relative rms error of the force's size, and the 95 % angle [deg] to the exact force, along a slide."""
    tips = shape.curve(np.linspace(0.0, 1.0, 400), -1e-3)
    depth, normal = shape.held(tips, RADIUS)
    exact = STIFFNESS * depth[:, None] * normal
    force = render(surface, tips, radius=RADIUS, stiffness=STIFFNESS).force
    size, true = np.linalg.norm(force, axis=1)[20:], np.linalg.norm(exact, axis=1)[20:]
    cosine = np.einsum("ni,ni->n", force[20:], exact[20:]) / np.maximum(size * true, 1e-12)
    return np.sqrt(np.mean((size - true) ** 2)) / true.mean(), np.percentile(
        np.degrees(np.arccos(cosine.clip(-1, 1))), 95
    )


@pytest.mark.parametrize(
    ("shape", "spacing", "noise", "size", "angle"),
    [
        (analytic.Sphere(), 1e-3, 0.0, 0.01, 1.0),
        (analytic.Sphere(), 1e-3, 0.3e-3, 0.03, 5.0),
        (analytic.Sphere(), 1e-3, 1e-3, 0.08, 8.0),
        (analytic.Sphere(), 2e-3, 3e-3, 0.12, 8.0),
        (analytic.Sphere(), 4e-3, 1e-3, 0.10, 5.0),
        (analytic.Torus(), 2e-3, 0.3e-3, 0.05, 8.0),
    ],
)
def test_force_agrees_with_the_closed_form(shape, spacing, noise, size, angle):
    found = errors(palpate.PointCloud(sampled_shape(shape, spacing, noise)), shape)
    assert found[0] < size
    assert found[1] < angle


def test_the_comparison_sees_each_kind_of_wrong_surface():
    shape = analytic.Sphere()
    points = sampled_shape(shape, 1e-3, 0.0)
    inwards = -points / np.linalg.norm(points, axis=1, keepdims=True)
    assert errors(palpate.PointCloud(points, inwards), shape)[1] > 90.0
    assert errors(palpate.PointCloud(1.03 * points), shape)[0] > 0.1  # a unit or scale that is wrong
    torus = analytic.Torus()
    cloud = palpate.PointCloud(sampled_shape(torus, 2e-3, 0.0))
    assert errors(cloud, torus)[0] < 0.01
    assert errors(surfaces.PointSurface(cloud, support=0.03), torus)[0] > 0.05  # smoothed too much


def test_half_of_the_view_is_felt_as_the_whole():
    shape = analytic.Sphere()
    points = sampled_shape(shape, 1e-3, 0.3e-3)
    seen = points[points[:, 2] > 0.0]
    surface = surfaces.PointSurface(palpate.PointCloud(seen, viewpoint=[0.0, 0.0, 0.4]))
    angle = np.linspace(-0.9, 0.9, 200)
    tips = 0.032 * np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
    depth, normal = shape.held(tips, RADIUS)
    force = render(surface, tips, radius=RADIUS, stiffness=STIFFNESS).force
    assert force[5:] == pytest.approx((STIFFNESS * depth[:, None] * normal)[5:], abs=0.2)


def test_the_surface_ends_at_its_rim_and_has_a_back():
    x, y = (a.ravel() for a in np.meshgrid(np.arange(-0.03, 0.0301, 1e-3), np.arange(-0.03, 0.0301, 1e-3)))
    plane = palpate.PointCloud(np.stack([x, y, 0 * x], axis=1), viewpoint=[0, 0, 0.5])
    surface = surfaces.PointSurface(plane, thickness=0.02)
    bridge = surface.scales.bridge
    distance, _, normal = surface.nearest([[0, 0, 0.004], [0, 0, -0.004], [0, 0, -0.025], [0.05, 0, 0.0]])
    assert distance == pytest.approx([0.004, -0.004, 0.005, 0.02 - bridge], abs=1e-4)
    assert normal[:, 2] == pytest.approx([1.0, 1.0, -1.0, 0.0], abs=1e-3)


@pytest.mark.parametrize(("width", "closed"), [(0.002, True), (0.016, False)])
def test_small_holes_are_closed_and_wide_ones_are_open(width, closed):
    x, y = (a.ravel() for a in np.meshgrid(np.arange(-0.03, 0.0301, 1e-3), np.arange(-0.03, 0.0301, 1e-3)))
    keep = np.hypot(x, y) > 0.5 * width
    cloud = palpate.PointCloud(np.stack([x, y, 0 * x], axis=1)[keep], viewpoint=[0, 0, 0.5])
    distance = surfaces.PointSurface(cloud).nearest([[0.0, 0.0, -1e-3]])[0][0]
    assert (distance < 0.0) == closed


def test_flying_pixels_are_left_out():
    rng = np.random.default_rng(0)
    xy = rng.uniform(-0.03, 0.03, (4000, 2))
    surface = np.c_[xy, np.zeros(4000)]
    flying = np.c_[rng.uniform(-0.03, 0.03, (30, 2)), rng.uniform(0.01, 0.2, 30)]
    core = surfaces.PointSurface(palpate.PointCloud(np.r_[surface, flying], viewpoint=[0, 0, 0.5])).core
    assert core.rejected >= 25
    assert core.averaged()[0][:, 2].max() < 0.005


@pytest.mark.parametrize(("spacing", "noise"), [(1e-3, 0.3e-3), (2e-3, 1e-3), (1e-3, 2e-3)])
def test_spacing_and_noise_are_measured(spacing, noise):
    found = sampling(sampled_shape(analytic.Sphere(0.05), spacing, noise))
    assert found.spacing == pytest.approx(spacing, rel=0.15)
    assert found.noise == pytest.approx(noise, rel=0.3)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((1, 3)), "one point is no surface"),
        (np.zeros((5, 3)), "5 points are no surface"),
        (np.outer(np.linspace(0, 0.1, 100), [1.0, 0.0, 0.0]), "lie on a line"),
    ],
)
def test_points_that_are_no_surface_are_refused(points, message):
    with pytest.raises(SurfaceError, match=message):
        surfaces.PointSurface(palpate.PointCloud(points))


def test_a_flat_cloud_without_viewpoint_warns_of_its_side():
    xy = np.random.default_rng(0).uniform(-0.03, 0.03, (2000, 2))
    with pytest.warns(PalpateWarning, match="which side"):
        surfaces.PointSurface(palpate.PointCloud(np.c_[xy, np.zeros(2000)]))


def test_the_direction_does_not_depend_on_the_radius(monkeypatch):
    cloud = palpate.PointCloud(sampled_shape(analytic.Sphere(), 2e-3, 1e-3))
    for radius in (0.5e-3, 8e-3):
        monkeypatch.setitem(globals(), "RADIUS", radius)
        assert errors(cloud, analytic.Sphere())[1] < 3.0
