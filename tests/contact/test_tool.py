"""Tools with many spheres on many objects: exact resultants and torques."""

import numpy as np
import pytest

from palpate import _core
from palpate.scene.contact import render
from palpate.scene.contact_method import METHODS, loaded
from palpate.world.shapes.analytic import SHAPES

RADIUS, K = 2e-3, 500.0
SQUARE = (np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]], np.int32))


def plane(normal, offset, stiffness=K):
    """A square with the outward direction `normal`, at the distance `offset` [m] from the origin."""
    n = np.asarray(normal, float) / np.linalg.norm(normal)
    x = np.cross(n, [0.3, 0.5, 0.8])
    x /= np.linalg.norm(x)
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = np.stack([x, np.cross(n, x), n], axis=1), offset * n
    return _core.Object(f"plane {normal}", _core.Mesh(*SQUARE), X, _core.Material(np.full(3, stiffness)))


def render_path(objects, tips, spheres=()):
    options = _core.ContactOptions()
    options.radius = RADIUS
    options.spheres = [_core.ToolSphere(np.array(p, float), r) for p, r in spheres]
    return _core.contact_render(_core.Snapshot(objects), np.ascontiguousarray(tips), "proxy", options, 1000.0)


def entry_path(end, n=300):
    return np.linspace(np.array([0.1, 0.1, 0.1]), end, n)


@pytest.mark.parametrize("count", [2, 3])
def test_forces_of_several_objects_add_up(count):
    """Walls of different stiffness, each its own object, overlap in a corner: the force is the sum of all springs."""
    normals, stiffness = np.eye(3)[:count], [300.0, 500.0, 700.0][:count]
    tips = entry_path([-0.001, -0.002, -0.0005])
    force = render_path([plane(n, 0.0, k) for n, k in zip(normals, stiffness, strict=True)], tips)[0]
    exact = sum(k * np.maximum(RADIUS - tips @ n, 0.0)[:, None] * n for n, k in zip(normals, stiffness, strict=True))
    np.testing.assert_allclose(force, exact, atol=1e-9)


def test_thirty_two_objects_are_rendered_and_one_more_needs_room():
    angles = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    ring = [plane([-np.cos(a), -np.sin(a), 0.0], -0.01) for a in angles]
    tips = np.linspace([0, 0, 0.0], [0.004, 0.007, 0.0], 200)
    force, *_ = render_path(ring, tips)
    gaps = RADIUS + tips @ np.stack([np.cos(angles), np.sin(angles), 0 * angles]) - 0.01
    inwards = -np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    np.testing.assert_allclose(force, K * np.maximum(gaps, 0.0) @ inwards, atol=1e-9)
    with pytest.raises(ValueError, match="has 33 objects, and this loop was made for at most 32"):
        render_path([*ring, ring[0]], tips)
    with pytest.raises(ValueError, match="at most 512 objects, got 513"):
        _core.Snapshot(16 * ring + ring[:1])


def test_rod_of_spheres_gives_the_wrench_of_its_springs():
    rod = [((0.0, 0.0, 0.01 * i), 0.003 + 0.0002 * i) for i in range(1, 16)]
    tips = np.linspace([0.02, 0, 0], [-0.001, 0, 0], 200)
    force, *_, torque = render_path([plane([1, 0, 0.2], 0.0)], tips, rod)
    n = np.array([1, 0, 0.2]) / np.hypot(1, 0.2)
    p_TS = np.array([[0.0, 0, 0], *(p for p, _ in rod)])
    radius = np.array([RADIUS, *(r for _, r in rod)])
    depth = np.maximum(radius - (tips[:, None] + p_TS) @ n, 0.0)  # (ticks, spheres)
    np.testing.assert_allclose(force, K * depth.sum(axis=1)[:, None] * n, atol=1e-9)
    np.testing.assert_allclose(torque, K * np.cross((depth[:, :, None] * p_TS).sum(axis=1), n), atol=1e-10)


def test_sphere_off_the_tip_gets_the_force_of_a_single_sphere():
    """The spheres are independent: each has its own memory of the side it came from."""
    mesh = _core.Mesh(*SHAPES["torus"].mesh(3000))
    curve = SHAPES["torus"].curve(np.linspace(0, 1, 1500), -1e-3)
    away = SHAPES["torus"].distance(curve[:1])[1] * np.linspace(0.02, 0, 200)[:, None]
    path, offset = np.concatenate([curve[0] + away, curve]), np.array([0.0, 0.2, 0.0])
    alone = render(mesh, path, radius=0.003, stiffness=K)
    both = render(mesh, path + offset, radius=RADIUS, stiffness=K, spheres=[(-offset, 0.003)])
    np.testing.assert_allclose(both.force, alone.force, atol=1e-12)
    np.testing.assert_allclose(both.torque, np.cross(-offset, alone.force), atol=1e-15)


def test_contact_set_keeps_the_strongest_contacts():
    """16 spheres in 3 walls are 48 contacts; the 32 contacts of the stiffest walls are kept."""
    walls = [plane(n, 0.0, k) for n, k in zip(np.eye(3), (100.0, 200.0, 400.0), strict=True)]
    spheres = [((0.0, 0.0, 0.0), RADIUS)] * 15
    force = render_path(walls, entry_path([-0.001, -0.001, -0.001]), spheres)[0][-1]
    np.testing.assert_allclose(force, 0.003 * 16 * np.array([0.0, 200, 400]), atol=1e-9)


def test_too_many_spheres_are_rejected():
    with pytest.raises(ValueError, match="16 spheres beside the one on the tip; a tool has at most 15"):
        render_path([plane([0, 0, 1], 0)], np.zeros((1, 3)), [((0, 0, 0), RADIUS)] * 16)
    with pytest.raises(ValueError, match="radius must be a positive"):
        render(_core.Mesh(*SQUARE), np.zeros((1, 3)), radius=RADIUS, stiffness=K, spheres=[((0, 0, 0), -1.0)])


def test_jaw_opens_about_its_hinge():
    jaw = _core.ToolSphere(
        np.array([0.0, 0.0, 0.011]), 0.001, hinge=np.array([0.0, 0.0, 0.001]), turn=np.array([0.5, 0.0, 0.0])
    )
    np.testing.assert_allclose(jaw.centre(0.0), [0, 0, 0.011])
    np.testing.assert_allclose(jaw.centre(1.0), [0, -0.01 * np.sin(0.5), 0.001 + 0.01 * np.cos(0.5)], atol=1e-15)


@pytest.mark.parametrize("method", METHODS)
def test_invalid_position_gives_no_force_and_keeps_the_proxy_memory(method):
    """A NaN position gives no force, and the other forces are the same as without it."""
    tips = entry_path([0.0, 0.0, -0.001])
    tips = np.concatenate([tips, np.repeat(tips[-1:], 50, axis=0)])
    whole = render_plane(tips, method)
    tips[320] = np.nan
    broken = render_plane(tips, method)
    assert not broken[320].any()
    np.testing.assert_allclose(broken[330:], whole[330:], atol=1e-9)
    assert method != "proxy" or np.linalg.norm(whole[330:], axis=1).min() > 0.1


def render_plane(tips, method):
    options = _core.ContactOptions()
    options.radius = RADIUS
    return _core.contact_render(_core.Snapshot([plane([0, 0, 1], 0.0)]), tips, loaded(method), options, 1000.0)[0]


def test_tool_filters_virtual_or_real_objects():
    """Floors of 300, 500 and 700 N/m at one position: virtual, real for the follower's drives, and both."""
    floors = [
        _core.Object("floor", _core.Mesh(*SQUARE), np.eye(4), _core.Material(np.full(3, k)), is_virtual=v, is_real=r)
        for k, v, r in ((300.0, True, False), (500.0, False, True), (700.0, True, True))
    ]
    options = _core.ContactOptions()
    options.radius = RADIUS
    for real, stiffness in ((False, 1000.0), (True, 1200.0)):
        options.real = real
        force = _core.contact_render(_core.Snapshot(floors), entry_path([0.0, 0.0, 0.001]), "proxy", options, 1000.0)[0]
        np.testing.assert_allclose(force[-1], [0, 0, stiffness * 1e-3], atol=1e-9)
