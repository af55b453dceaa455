"""The drawn dent: the surface follows the tool's sphere, nothing else moves, and a release leaves no trace."""

from unittest.mock import MagicMock

import numpy as np
import pytest
import trimesh

from palpate.viewer.dent import Press, lowering, pressed, refined
from palpate.viewer.organs import OrganDrawing
from palpate.viewer.patch import PatchCutter
from palpate.viewer.stage import TouchedObject
from palpate.world.shapes.organs import organ

MOST = 1e-4
"""Largest intersection of drawn surface and drawn sphere [m]."""


def intersection(vertices, triangles, press):
    """Depth of the sphere below the surface [m]: radius minus signed distance of its centre."""
    corners = vertices[triangles]
    nearest = trimesh.triangles.closest_point(corners, np.repeat(press.centre[None], len(corners), 0))
    away = press.centre - nearest
    distance = np.linalg.norm(away, axis=1)
    close = np.flatnonzero(distance < distance.min() + 1e-9)
    normals = np.cross(corners[close, 1] - corners[close, 0], corners[close, 2] - corners[close, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    beside = np.einsum("ij,ij->i", normals, away[close])
    return press.radius - float(distance.min() * np.sign(beside[np.argmax(np.abs(beside))]))


def presses(mesh, radius, depth, count=4):
    """Spheres pressed into random places, displaced sideways as friction does."""
    random = np.random.default_rng(3)
    for k in random.integers(len(mesh.faces), size=count):
        n, point = mesh.face_normals[k], mesh.triangles_center[k]
        sideways = np.cross(n, random.normal(size=3))
        centre = point + (radius - depth) * n + 0.2 * depth * sideways / np.linalg.norm(sideways)
        yield Press(centre, radius, point, n)


@pytest.mark.parametrize("radius", [0.002, 0.006])
@pytest.mark.parametrize("depth", [0.0005, 0.002, 0.004, 0.01])
def test_surface_follows_the_sphere(radius, depth):
    vertices, triangles = organ(12_000)
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    for press in presses(mesh, radius, depth):
        cutter = PatchCutter(vertices, triangles, np.zeros(len(triangles), np.int64))
        patch = cutter.patch([press])
        assert intersection(vertices, triangles, press) > 0.7 * depth, "nothing to repair"
        assert intersection(patch.vertices, patch.triangles, press) < MOST
        assert -0.3 * radius - 0.1 * depth < intersection(patch.vertices, patch.triangles, press), "touches the sphere"


def test_profile_is_the_sphere_inside_the_contact_radius_and_smooth_outside():
    """Hertz: contact radius sqrt(r h); value and slope agree with the sphere's there; zero beyond the reach."""
    r, h = 0.01, 0.001
    press = Press(np.array([0.0, 0.0, r - h]), r, np.zeros(3), np.array([0.0, 0.0, 1.0]))
    a = np.sqrt(r * h)
    assert lowering(np.zeros(1), press)[0] == pytest.approx(h)
    inside = np.linspace(0.0, 0.999 * a, 50)
    np.testing.assert_allclose(h - lowering(inside, press), r - np.sqrt(r**2 - inside**2), atol=1e-12)
    e = 1e-7
    below, above = lowering(np.array([a - e]), press)[0], lowering(np.array([a + e]), press)[0]
    assert (above - below) / (2 * e) == pytest.approx(-a / np.sqrt(r**2 - a**2), rel=1e-3)
    assert lowering(np.array([press.reach, 1.0]), press) == pytest.approx([0.0, 0.0])
    assert np.all(np.diff(lowering(np.linspace(0.0, press.reach, 400), press)) <= 0.0)


def test_refinement_keeps_the_surface_and_opens_no_gap():
    box = trimesh.creation.box((0.1, 0.1, 0.02))
    press = Press(np.array([0.01, 0.0, 0.0105]), 0.002, np.array([0.01, 0.0, 0.01]), np.array([0.0, 0.0, 1.0]))
    vertices, triangles, labels = refined(np.array(box.vertices), box.faces.astype(np.int32), np.arange(12), [press])
    fine = trimesh.Trimesh(vertices, triangles, process=False)
    assert fine.is_watertight
    assert fine.volume == pytest.approx(box.volume, rel=1e-9)
    np.testing.assert_allclose(np.bincount(labels, fine.area_faces), box.area_faces, rtol=1e-9)
    assert 500 < len(triangles) < 20_000
    assert intersection(pressed(vertices, triangles, press), triangles, press) < MOST
    assert intersection(pressed(np.array(box.vertices), box.faces, press), box.faces, press) > 1e-3, "too coarse"


def test_far_side_and_border_of_the_cut_stay():
    """Under a sphere in a plate of 5 mm, the lower side and the border of the cut do not move."""
    plate = trimesh.creation.box((0.2, 0.2, 0.005)).subdivide().subdivide().subdivide().subdivide()
    vertices, triangles = np.array(plate.vertices), plate.faces.astype(np.int32)
    point = np.array([0.0, 0.0, 0.0025])
    press = Press(point - [0.0, 0.0, 0.001], 0.002, point, np.array([0.0, 0.0, 1.0]))
    patch = PatchCutter(vertices, triangles, np.zeros(len(triangles), np.int64)).patch([press])
    assert 0 < np.count_nonzero(~patch.rest) < len(triangles) / 2
    lower = patch.vertices[:, 2] < -0.0024
    assert np.all(patch.vertices[lower, 2] == -0.0025)
    cut = trimesh.Trimesh(patch.vertices, patch.triangles, process=False)
    border = np.unique(cut.edges_sorted[trimesh.grouping.group_rows(cut.edges_sorted, require_count=1)])
    assert np.abs(np.abs(patch.vertices[border, 2]) - 0.0025).max() < 1e-12
    assert np.abs(patch.vertices[:, 2] - 0.0025).max() > 0.0025


def drawn(obj):
    scene = MagicMock()
    made = {}
    scene.add_mesh_simple.side_effect = lambda name, v, t, **_: made.setdefault(
        name, MagicMock(vertices=v, faces=t, visible=True)
    )
    return OrganDrawing(scene, obj, (1, 2, 3)), made


def test_release_restores_every_byte():
    vertices, triangles = organ(6000)
    drawing, made = drawn(TouchedObject("liver", vertices, triangles, np.eye(4)))
    base = made["/objects/liver/0"]
    before = (base.vertices.tobytes(), base.faces.tobytes())
    point, n = vertices[100], trimesh.Trimesh(vertices, triangles, process=False).vertex_normals[100]
    drawing.press([(point - 0.001 * n, 0.002, point, n)])
    patch = made["/objects/liver/0_pressed"]
    assert len(base.faces) < len(triangles)
    assert patch.visible
    drawing.press([(point - 0.001 * n + 0.0005, 0.002, point, None)])
    drawing.press([])
    assert (base.vertices.tobytes(), base.faces.tobytes()) == before
    assert not patch.visible


def test_points_of_a_cloud_take_no_dent():
    vertices, triangles = organ(2000)
    drawing, made = drawn(TouchedObject("scan", vertices, triangles, np.eye(4), is_cloud=True))
    drawing.press([(vertices[100], 0.002, vertices[100], None)])
    assert len(made["/objects/scan/0"].faces) == len(triangles)


def test_press_beside_the_drawn_part_of_a_plane_moves_the_nearest_triangle_only():
    vertices = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0.1, 0.1, 0]])
    triangles = np.array([[0, 1, 2], [1, 3, 2]], np.int32)
    up, far = np.array([0.0, 0.0, 1.0]), np.array([1.0, 1.0, 0.0])
    patch = PatchCutter(vertices, triangles, np.zeros(2, np.int64)).patch([Press(far - 0.001 * up, 0.002, far, up)])
    assert patch.rest.tolist() == [True, False]
    assert np.isfinite(patch.vertices).all()


def test_still_sphere_sends_nothing_and_a_moving_one_keeps_the_cut():
    vertices, triangles = organ(6000)
    cutter = PatchCutter(vertices, triangles, np.zeros(len(triangles), np.int64))
    n = trimesh.Trimesh(vertices, triangles, process=False).vertex_normals[100]
    press = Press(vertices[100] - 0.001 * n, 0.002, vertices[100], n)
    assert cutter.patch([press]).is_new_cut
    assert cutter.patch([press]) is None
    aside = np.cross(n, [1.0, 0.0, 0.0]) * 0.001
    assert not cutter.patch([Press(press.centre + aside, 0.002, press.point + aside, n)]).is_new_cut
    far = vertices[np.argmax(np.linalg.norm(vertices - vertices[100], axis=1))]
    assert cutter.patch([Press(far, 0.002, far, n)]).is_new_cut
