"""The proxy on implicit surfaces: the exact law, thin plates, corners, energy, and agreement with the mesh proxy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core
from palpate.scene.contact import render
from palpate.world import surfaces
from palpate.world.shapes.analytic import SHAPES

RADIUS, K = 2e-3, 500.0
PILLOW = surfaces.ImplicitSurface.of_half_lengths((0.03, 0.02, 0.04), (4, 2, 6))
SMOOTH = [surfaces.Plane(), surfaces.Sphere(0.03), surfaces.Capsule(0.01, 0.05), PILLOW]
EDGED = [surfaces.Box((0.04, 0.03, 0.05)), surfaces.Cylinder(0.02, 0.05)]


def render_path(surface, tips, **options):
    return render(surface, tips, **({"radius": RADIUS, "stiffness": K} | options))


def law(surface, tips):
    distance, _, normal = surface.nearest(tips)
    return K * np.maximum(RADIUS - distance, 0.0)[:, None] * normal


def around(surface, offset, n=4000):
    """A tool path from above onto the surface, then around it at a signed distance [m], in small steps."""
    t = np.linspace(0, 2 * np.pi, n)[:, None]
    far = 0.1 * np.concatenate([np.cos(t), np.sin(t) * 0.8, 1.0 + 0.5 * np.sin(2 * t)], axis=1)
    _, foot, normal = surface.nearest(far)
    slide = foot + offset * normal
    return np.concatenate([slide[0] + normal[0] * np.linspace(0.02, 0.0, 300)[:, None], slide])


def random_path(seed, reach=0.035, n=5000):
    """A smooth random path that enters, leaves and crosses the surface."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 2 * np.pi, n)[:, None]
    path = sum(rng.normal(size=3) * np.sin(k * t + rng.uniform(0, 6, 3)) for k in range(1, 6))
    path *= reach / np.abs(path).max()
    return np.concatenate([np.linspace([0, 0, 0.2], path[0], 1500), path])


@pytest.mark.parametrize("offset", [1e-3, -0.5e-3, -3e-3])
@pytest.mark.parametrize("surface", SMOOTH, ids=lambda s: s.name)
def test_smooth_surfaces_obey_the_law_exactly(surface, offset):
    tips = around(surface, offset)
    r = render_path(surface, tips)
    np.testing.assert_allclose(r.force, law(surface, tips), atol=1e-9)
    assert not r.started_inside


@pytest.mark.parametrize("surface", EDGED, ids=lambda s: s.name)
def test_convex_edges_are_rounded_by_the_radius(surface):
    tips = around(surface, 1e-3)
    np.testing.assert_allclose(render_path(surface, tips).force, law(surface, tips), atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("size", [(0.04, 0.04, 0.04), (0.06, 0.06, 0.001)], ids=["box", "plate"])
def test_mesh_proxy_agrees_on_a_box(size, seed):
    """Both algorithms agree, except for single ticks in which one passes an edge sooner."""
    tips = random_path(seed)
    name = "box" if size[2] > 0.01 else "plate"
    field, mesh = render_path(surfaces.Box(size), tips), render_path(_core.Mesh(*SHAPES[name].mesh(12)), tips)
    apart = np.abs(field.force - mesh.force).max(axis=1) > 1e-4
    assert (field.depth > 0).mean() > 0.3
    assert apart.mean() < 0.003


@pytest.mark.parametrize("speed", [0.01, 1.0])
@pytest.mark.parametrize("thickness", [1e-3, 0.5e-3])
def test_tool_never_pops_through_a_thin_plate(speed, thickness):
    """Pressed slowly by 10 mm or fast by 20 mm at 1 m/s, the tool is always pushed back to its own side."""
    top, depth = thickness / 2, 0.01 if speed < 0.1 else 0.02
    z = np.arange(top + 0.015, top - depth, -speed * 1e-3)
    down = np.stack([np.full_like(z, 0.0041), np.full_like(z, -0.0023), z], axis=1)
    tips = np.concatenate([down, np.repeat(down[-1:], 50, axis=0), down[::-1]])
    r = render_path(surfaces.Box((0.06, 0.06, thickness)), tips)
    expected = K * np.maximum(top + RADIUS - tips[:, 2], 0.0)[:, None] * [0.0, 0.0, 1.0]
    np.testing.assert_allclose(r.force, expected, atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    thickness=st.floats(2e-4, 2e-3),
    speed=st.floats(0.01, 2.0),
    radius=st.floats(5e-4, 5e-3),
)
def test_plate_cannot_be_penetrated(seed, thickness, speed, radius):
    """For any position, inclination, speed and radius the force points up while the tool is over the plate."""
    rng = np.random.default_rng(seed)
    start = np.array([*rng.uniform(-0.01, 0.01, 2), 0.008])
    end = start + np.array([*rng.uniform(-0.01, 0.01, 2), -0.028])
    n = max(2, int(np.linalg.norm(end - start) / speed * 1000))
    tips = np.linspace(start, end, n)
    r = render_path(surfaces.Box((0.08, 0.08, thickness)), tips, radius=radius)
    below = tips[:, 2] < thickness / 2 + radius
    np.testing.assert_allclose(r.force[below, 2], K * (thickness / 2 + radius - tips[below, 2]), rtol=1e-6)


def test_grid_of_a_groove_gives_forces_of_both_walls():
    """A concave right angle in a grid: the force is that of the corner of both offset planes, without jitter."""
    x, z = np.arange(-0.02, 0.0205, 0.001), np.arange(-0.01, 0.0205, 0.001)
    nodes = np.stack(np.meshgrid(x, np.arange(-0.01, 0.0105, 0.001), z, indexing="ij"), axis=-1)
    values = SHAPES["groove"].distance(nodes.reshape(-1, 3))[0].reshape(nodes.shape[:3])
    groove = surfaces.DistanceGrid(values, nodes[0, 0, 0], 0.001)
    t = np.linspace(0, 9, 3000)
    tips = np.stack([1.2e-3 * np.cos(t), 3e-3 * np.sin(t), np.full_like(t, 0.5e-3)], axis=1)
    tips = np.concatenate([np.linspace(tips[0] + [0, 0, 0.015], tips[0], 400), tips])
    r = render_path(groove, tips)
    corner = np.stack([np.zeros_like(t), tips[400:, 1], np.full_like(t, RADIUS * 2**0.5)], axis=1)
    np.testing.assert_allclose(r.force[400:], K * (corner - tips[400:]), atol=1e-4)


@pytest.mark.parametrize("degrees", [40.0, 80.0, 120.0])
def test_two_faces_of_a_grid_are_exact_at_any_angle(degrees):
    """The tool moves to and fro in a concave edge of two planes. The proxy is the nearest point r above one or both.

    The sphere touches both faces at least two cells from the edge; closer to it the grid rounds the edge.
    """
    radius = 6e-3
    x = np.arange(-0.0205, 0.021, 0.001)
    nodes = np.stack(np.meshgrid(x, x[::4], x, indexing="ij"), axis=-1)
    n = np.array([[0.0, 0.0, 1.0], [-np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))]])
    edge = surfaces.DistanceGrid((nodes @ n.T).min(axis=-1), nodes[0, 0, 0], (0.001, 0.004, 0.001))
    middle = n.sum(axis=0) / np.linalg.norm(n.sum(axis=0))
    t = np.linspace(0, 9, 1500)
    tips = 1e-3 * np.sin(t)[:, None] * [middle[2], 0.0, -middle[0]] + [0.0, 0.001, 0.0] + 2e-4 * middle
    tips = np.concatenate([tips[0] + middle * np.linspace(0.015, 0.0, 300)[:, None], tips])
    force = render_path(edge, tips, radius=radius).force[300:]
    short = radius - tips[300:] @ n.T
    both = np.linalg.solve(n @ n.T, short.T).T
    one = short.argmax(axis=1)
    delta = np.where((both > 0).all(axis=1)[:, None], both @ n, short.max(axis=1)[:, None] * n[one])
    np.testing.assert_allclose(force, K * delta, atol=1e-4)


@pytest.mark.parametrize(("spacing", "degrees", "newton"), [(0.002, 0.3, 1.5e-3), (0.001, 0.1, 2e-4)])
def test_grid_of_a_torus_obeys_the_law(spacing, degrees, newton):
    low, nodes = np.array([-0.0603, -0.0603, -0.0203]), (np.array([0.12, 0.12, 0.04]) / spacing).astype(int) + 2
    at = np.stack(np.meshgrid(*(low[a] + spacing * np.arange(nodes[a]) for a in range(3)), indexing="ij"), axis=-1)
    exact = SHAPES["torus"]
    grid = surfaces.DistanceGrid(exact.distance(at.reshape(-1, 3))[0].reshape(nodes), low, spacing)
    slide = exact.curve(np.linspace(0, 2, 4001), -2e-3)
    phi, n = exact.distance(slide)
    tips = np.concatenate([slide[0] + n[0] * np.linspace(0.02, 0, 400)[:, None], slide])
    force = render_path(grid, tips).force[400:]
    assert np.degrees(np.arccos(np.clip((force * n).sum(1) / np.linalg.norm(force, axis=1), -1, 1))).max() < degrees
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), K * (RADIUS - phi), atol=newton)


@pytest.mark.parametrize("surface", SMOOTH[1:], ids=lambda s: s.name)
def test_forces_do_no_work_on_a_closed_path(surface):
    """The path starts and ends in free space; the trapezoidal sum of F dx vanishes with the step."""
    tips = around(surface, -1e-3, 20_000)
    tips = np.concatenate([tips, tips[:300][::-1] - tips[299] + tips[-1]])
    force = render_path(surface, tips).force
    done = (0.5 * (force[1:] + force[:-1]) * np.diff(tips, axis=0)).sum()
    assert abs(done) < 2e-7  # the stored energy is 2.25 mJ
    assert np.linalg.norm(force, axis=1).max() > 1.49


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_forces_do_not_depend_on_the_scale(scale):
    tips = random_path(7)
    one = render_path(surfaces.Box((0.04, 0.03, 0.05)), tips).force
    other = render_path(
        surfaces.Box(scale * np.array([0.04, 0.03, 0.05])),
        tips * scale,
        radius=RADIUS * scale,
        release=0.05 * scale,
        stiffness=K / scale,
    ).force
    np.testing.assert_allclose(other, one, rtol=0, atol=1e-9 * np.abs(one).max())


def test_tool_that_starts_inside_is_moved_outside_and_reported():
    tips = np.repeat([[0.0, 0.001, 0.015]], 5, axis=0)
    r = render_path(surfaces.Box((0.04, 0.04, 0.04)), tips)
    assert r.started_inside
    np.testing.assert_allclose(r.force, np.tile([0, 0, K * 0.007], (5, 1)), atol=1e-9)


def test_force_is_zero_after_release_and_friction_stays_in_its_cone():
    ball, mu = surfaces.Sphere(0.03), 0.3
    tips = np.concatenate([around(ball, -1e-3, 500), np.linspace([0, 0, 0.06], [0, 0, 0.07], 20)])
    r = render_path(ball, tips, friction=mu)
    free = ball.nearest(tips)[0] > RADIUS
    assert (r.force[free] == 0.0).all()
    along = np.linalg.norm(r.force - (r.force * r.normal).sum(1)[:, None] * r.normal, axis=1)
    assert (along <= mu * K * r.depth * (1 + 1e-9)).all()
    assert along.max() > 0.1


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_rough_grids_and_wild_paths_give_finite_bounded_forces(seed):
    """With noisy samples and jumps of the tool, forces are finite, along the deflection, and zero in free space."""
    rng = np.random.default_rng(seed)
    x = np.linspace(-0.02, 0.02, 21)
    at = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1)
    values = np.linalg.norm(at, axis=-1) - 0.012 + rng.uniform(-2e-4, 2e-4, (21, 21, 21))
    tips = rng.uniform(-0.03, 0.03, (10, 3)).repeat(20, axis=0) + rng.normal(0, 3e-4, (200, 3))
    r = render_path(surfaces.DistanceGrid(values, np.full(3, -0.02), 0.002), tips)
    assert np.isfinite(r.force).all()
    assert (np.linalg.norm(r.force, axis=1) <= K * 0.1).all()
    np.testing.assert_allclose(r.force, np.where(r.depth[:, None] > 0, K * (r.proxy - tips), 0.0), atol=1e-9)
