"""The proxy against second algorithms: concave edges and corners, equilibria, energy, release, motion, scale."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import minimize

from palpate import _core
from palpate.scene.contact import render
from palpate.world.shapes.analytic import MM, SHAPES, Box, Sphere

RADIUS, K = 2e-3, 500.0


def angle_deg(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(axis=-1)))


def along(*knots, step=5e-5):
    """A path (n, 3) through the knots in equal steps [m]."""
    legs = [np.linspace(a, b, max(2, int(np.linalg.norm(np.subtract(b, a)) / step)))[:-1] for a, b in pairwise(knots)]
    return np.concatenate([*legs, np.array(knots[-1:])])


def valley(dihedral, n=12):
    """Two planes that meet at the y axis with a dihedral angle, open above; each is a grid of n x n cells."""
    half = np.radians(dihedral) / 2
    s = np.linspace(0, 0.05, n + 1)
    x = np.concatenate([-s[:0:-1], s])
    across, y = (c.ravel() for c in np.meshgrid(x, np.linspace(-0.03, 0.03, n + 1), indexing="ij"))
    i, j = (c.ravel() for c in np.meshgrid(np.arange(2 * n), np.arange(n), indexing="ij"))
    a = i * (n + 1) + j
    faces = np.concatenate([np.stack([a, a + n + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + 1], 1)])
    vertices = np.stack([across * np.sin(half), y, np.abs(across) * np.cos(half)], axis=1)
    return _core.Mesh(vertices, faces.astype(np.int32)), half


@pytest.mark.parametrize("dihedral", [30, 60, 90, 120, 145, 150])
def test_contact_with_two_walls_is_exact(dihedral):
    """Sliding along and across the bottom of a valley: the proxy is at the corner of both offsets, without jitter."""
    mesh, half = valley(dihedral)
    lowest = np.array([0.0, 0.0, RADIUS / np.sin(half)])
    tips = along([0.001, -0.02, 0.03], [0.0004, -0.02, -0.001], [0.0004, 0.017, -0.001], [-0.0006, 0.013, -0.0012])
    r = render(mesh, tips, radius=RADIUS, stiffness=K)
    exact = K * (lowest + tips * [0, 1, 0] - tips)
    both = tips[:, 2] < 0  # within the cone of both normals
    assert both.sum() > 500
    assert angle_deg(r.force[both], exact[both]).max() < 0.05
    np.testing.assert_allclose(r.force[both], exact[both], atol=1e-6)
    still = render(mesh, np.concatenate([tips, np.repeat(tips[-1:], 200, axis=0)]), radius=RADIUS, stiffness=K)
    np.testing.assert_allclose(still.force[-199:], np.repeat(still.force[-1:], 199, axis=0), atol=1e-12)


def room(triangles):
    """The inside of a box: six walls as one open mesh, so that its orientation is not corrected."""
    vertices, faces = Box((0.04, 0.04, 0.04)).mesh(triangles)
    lid = (vertices[faces][:, :, 0] > 0.0199).all(axis=1)
    return _core.Mesh(vertices, np.ascontiguousarray(faces[~lid][:, ::-1]))


@pytest.mark.parametrize("triangles", [12, 2000])
def test_contact_with_three_walls_inside_a_box_is_exact(triangles):
    tips = along([0, 0, 0], [-0.0195, 0.0005, -0.0195], [-0.021, 0.0215, -0.0205], [-0.0195, 0.0194, 0.0])
    r = render(room(triangles), tips, radius=RADIUS, stiffness=K)
    exact = K * (np.clip(tips, -0.02 + RADIUS, 0.02 - RADIUS) - tips)
    felt = np.linalg.norm(exact, axis=1) > 1e-2
    assert angle_deg(r.force, exact)[felt].max() < 0.05
    np.testing.assert_allclose(r.force, exact, atol=1e-6)


def test_force_at_box_edges_and_corners_follows_the_offset_surface():
    """Around edges and a corner, 1 mm above: direction and steps agree with the exact offset surface."""
    t = np.linspace(0, np.pi / 2, 400)[:, None]
    corner = np.array([0.02, 0.02, 0.02])
    x, y, z = np.eye(3)
    arc = corner + 1e-3 * np.concatenate([np.cos(t) * z + np.sin(t) * x, np.cos(t) * x + np.sin(t) * y])
    tips = np.concatenate([along([0.018, 0.018, 0.03], [0.018, 0.018, 0.021], arc[0]), arc])
    for triangles in (12, 3000):
        r = render(_core.Mesh(*SHAPES["box"].mesh(triangles)), tips, radius=RADIUS, stiffness=K)
        depth, normal = SHAPES["box"].held(tips, RADIUS)
        exact = K * depth[:, None] * normal
        np.testing.assert_allclose(r.force, exact, atol=1e-5)
        touched = np.linalg.norm(exact, axis=1) > 0.1
        steps, truth = (angle_deg(f[1:], f[:-1])[touched[1:] & touched[:-1]].max() for f in (r.force, exact))
        assert steps <= truth + 0.01


@pytest.mark.parametrize("seed", range(6))
def test_resting_proxy_is_a_constrained_minimum(seed):
    """SLSQP with the distance to every triangle as a constraint finds the same position."""
    rng = np.random.default_rng(seed)
    wall = 0.03 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    corners, turns = [], []
    for _ in range(3):  # three large faces that face upwards and pass through the middle
        tilt = np.radians(rng.uniform(20, 60))
        turns.append(2 * np.pi * (len(turns) + rng.uniform(-0.15, 0.15)) / 3)
        about_x = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
        c, s = np.cos(turns[-1]), np.sin(turns[-1])
        corners.append(wall @ about_x.T @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T)
    normals = np.array([np.cross(q[1] - q[0], q[2] - q[0]) for q in corners])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    faces = np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + 4 * k for k in range(3)]).astype(np.int32)
    tool = np.array([*rng.uniform(-3e-3, 3e-3, 2), -1e-3])
    r = render(_core.Mesh(np.concatenate(corners), faces), along([0, 0, 0.03], tool, tool), radius=RADIUS, stiffness=K)
    best = minimize(
        lambda p: ((p - tool / MM) ** 2).sum(),
        [0, 0, 10],
        constraints=[{"type": "ineq", "fun": lambda p: normals @ p - RADIUS / MM}],
        method="SLSQP",
        options={"ftol": 1e-14},
    )
    np.testing.assert_allclose(r.proxy[-1] / MM, best.x, atol=1e-5)


@pytest.mark.parametrize(("shape", "triangles"), [("torus", 1000), ("wavy", 1000), ("wavy", 10_000)])
def test_forces_do_no_work_on_closed_paths(shape, triangles):
    """The work around a loop, in both directions, is less than a thousandth of the exchanged energy."""
    exact = SHAPES[shape]
    mesh = _core.Mesh(*exact.mesh(triangles))
    turns = 5 if shape == "torus" else 1
    loop = exact.curve(np.linspace(0, turns, 12_000), -1e-3)
    for path in (loop, loop[::-1]):
        down = path[0] + exact.distance(path[:1])[1] * np.linspace(0.02, 0, 400)[:, None]
        r = render(mesh, np.concatenate([down, path]), radius=RADIUS, stiffness=K)
        force = r.force[400:]
        work = ((force[1:] + force[:-1]) / 2 * np.diff(path, axis=0)).sum()
        flow = np.linalg.norm(force, axis=1).mean() * np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        assert abs(work) < 5e-5 * flow


@pytest.mark.parametrize("shape", ["torus", "wavy"])
def test_the_force_is_the_gradient_of_the_energy(shape):
    """Central differences of 1/2 k depth^2 at random positions give the force."""
    exact = SHAPES[shape]
    mesh = _core.Mesh(*exact.mesh(5000))
    rng = np.random.default_rng(2)
    h = 1e-7
    for s in rng.random(6):
        tip = exact.curve(np.array([s]), -1e-3)[0]
        around = np.concatenate([tip + h * np.array([d, -d]) for d in np.eye(3)])
        tips = np.concatenate([along(tip + exact.distance(tip[None])[1][0] * 0.01, tip), around, tip[None]])
        r = render(mesh, tips, radius=RADIUS, stiffness=K)
        energy = 0.5 * K * r.depth[-7:-1] ** 2
        gradient = (energy[::2] - energy[1::2]) / (2 * h)
        np.testing.assert_allclose(-gradient, r.force[-1], atol=0.02 * np.linalg.norm(r.force[-1]))


def test_plate_keeps_the_tools_side_until_the_release_depth():
    """The side of entry is kept at any depth up to `release`; beyond that the tool has passed the object."""
    mesh = _core.Mesh(*Box((0.06, 0.06, 0.001)).mesh(500))
    tips = along([0.003, 0.001, 0.02], [0.003, 0.001, -0.07])
    r = render(mesh, tips, radius=RADIUS, stiffness=K)
    depth = 0.0005 + RADIUS - tips[:, 2]
    held = (depth > 1e-6) & (depth < 0.0499)
    np.testing.assert_allclose(r.force[held], K * depth[held, None] * [0, 0, 1], atol=1e-6)
    assert (r.force[depth > 0.0501] == 0).all()
    far = render(mesh, tips, radius=RADIUS, stiffness=K, release=1.0)
    assert (far.force[depth > 1e-6, 2] > 0).all()


def test_a_tool_inside_is_not_released():
    """A tool deeper than `release` inside a body has not passed it and is still pushed back to its own side."""
    mesh = _core.Mesh(*Sphere(0.1).mesh(5000))
    tips = along([0.001, 0.002, 0.12], [0.001, 0.002, 0.02], step=1e-4)
    r = render(mesh, tips, radius=RADIUS, stiffness=K)
    assert r.force[-1, 2] > K * 0.07
    sheet = _core.Mesh(*SHAPES["wavy"].mesh(2000))  # an open surface has no inside
    below = render(sheet, along([0, 0, 0.02], [0, 0, -0.07], step=1e-4), radius=RADIUS, stiffness=K)
    assert below.force[-1, 2] > K * 0.06


@pytest.mark.parametrize("thickness", [1e-3, 0.5e-3])
@pytest.mark.parametrize("triangles", [12, 5000])
def test_moving_plate_does_not_pass_a_resting_tool(thickness, triangles):
    """A plate moves at 0.5 m/s to 20 mm beyond the tool: the tool is pushed in the plate's direction."""
    mesh = _core.Mesh(*Box((0.06, 0.06, thickness)).mesh(triangles))
    z = np.concatenate([np.arange(-0.02, 0.02, 0.5e-3), np.full(20, 0.02)])
    poses = np.repeat(np.eye(4)[None], len(z), axis=0)
    poses[:, 2, 3] = z
    tips = np.tile([0.004, -0.003, 0.0], (len(z), 1))
    r = render(mesh, tips, radius=RADIUS, stiffness=K, poses=poses)
    depth = np.maximum(z + thickness / 2 + RADIUS, 0.0)
    np.testing.assert_allclose(r.force, K * depth[:, None] * [0, 0, 1], atol=1e-6)


@pytest.mark.parametrize("thickness", [1e-3, 0.5e-3])
@pytest.mark.parametrize("speed", [0.01, 1.0])
def test_plate_of_half_a_millimetre_is_not_penetrated(thickness, speed):
    depth = 0.01 if speed < 0.1 else 0.02
    mesh = _core.Mesh(*Box((0.06, 0.06, thickness)).mesh(5000))
    tips = along([0.0041, -0.0023, 0.01], [0.0041, -0.0023, -depth], step=speed * 1e-3)
    r = render(mesh, tips, radius=RADIUS, stiffness=K)
    exact = K * np.maximum(thickness / 2 + RADIUS - tips[:, 2], 0.0)
    np.testing.assert_allclose(r.force, exact[:, None] * [0, 0, 1], atol=1e-6)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
@pytest.mark.parametrize("shape", sorted(SHAPES))
def test_forces_are_independent_of_the_scale_of_each_shape(shape, scale):
    exact = SHAPES[shape]
    slide = exact.curve(np.linspace(0, 1, 1500), -1e-3 if shape in ("torus", "wavy", "groove") else 1e-3)
    tips = np.concatenate([slide[0] + exact.distance(slide[:1])[1] * np.linspace(0.02, 0, 300)[:, None], slide])
    vertices, faces = exact.mesh(3000)
    one = render(_core.Mesh(vertices, faces), tips, radius=RADIUS, stiffness=K, friction=0.3, static_friction=0.5)
    other = render(
        _core.Mesh(vertices * scale, faces),
        tips * scale,
        radius=RADIUS * scale,
        release=0.05 * scale,
        stiffness=K / scale,
        friction=0.3,
        static_friction=0.5,
    )
    np.testing.assert_allclose(other.force, one.force, rtol=0, atol=1e-9 * np.abs(one.force).max())


@pytest.mark.parametrize("shape", sorted(SHAPES))
def test_forces_are_equivariant_under_rotation_and_translation(shape):
    """Rotated and moved by 10 cm, the scene gives the same forces, rotated."""
    exact = SHAPES[shape]
    slide = exact.curve(np.linspace(0, 1, 1000), -1e-3 if shape in ("torus", "wavy", "groove") else 1e-3)
    tips = np.concatenate([slide[0] + exact.distance(slide[:1])[1] * np.linspace(0.02, 0, 300)[:, None], slide])
    vertices, faces = exact.mesh(3000)
    R = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    R *= np.sign(np.linalg.det(R))
    p = np.array([0.1, -0.05, 0.02])
    one = render(_core.Mesh(vertices, faces), tips, radius=RADIUS, stiffness=K).force
    other = render(_core.Mesh(vertices @ R.T + p, faces), tips @ R.T + p, radius=RADIUS, stiffness=K).force
    np.testing.assert_allclose(other @ R, one, rtol=0, atol=1e-9 * np.abs(one).max())


def cylinder(n):
    """An open pipe around the y axis with a radius of 10 mm and n facets."""
    u, v = (c.ravel() for c in np.meshgrid(np.arange(n), np.arange(6), indexing="ij"))
    a = 2 * np.pi * u / n
    vertices = np.stack([0.01 * np.sin(a), (v - 2.5) * 0.01, 0.01 * np.cos(a)], axis=1)
    i, j = (c.ravel() for c in np.meshgrid(np.arange(n), np.arange(5), indexing="ij"))
    p, q = i * 6 + j, (i + 1) % n * 6 + j
    faces = np.concatenate([np.stack([p, p + 1, q + 1], 1), np.stack([p, q + 1, q], 1)])
    return _core.Mesh(vertices, faces.astype(np.int32))


@pytest.mark.parametrize(("inner", "side"), [(0.008, 1.0), (0.0105, 1.0), (0.0115, -1.0), (0.009, -1.0)])
def test_cylinder_from_outside_and_inside(inner, side):
    """40 facets approximate the pipe: F = k (r - phi) n with radial n."""
    a = np.linspace(0.1, 5, 3000)
    radial = np.stack([np.sin(a), 0 * a, np.cos(a)], axis=1)
    slide = inner * radial + np.stack([0 * a, 0.002 * np.sin(3 * a), 0 * a], axis=1)
    start = slide[0] + side * radial[0] * (0.01 if side > 0 else min(0.007, inner - 1e-4))
    tips = np.concatenate([along(start, slide[0]), slide])
    r = render(cylinder(40), tips, radius=RADIUS, stiffness=K)
    force, depth = r.force[-len(slide) :], RADIUS - side * (inner - 0.01)
    assert angle_deg(force, side * radial).max() < 0.1
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), K * depth, rtol=2e-3)
