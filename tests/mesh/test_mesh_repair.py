"""Repaired copies of meshes, compared with the mesh before the damage."""

import numpy as np
import pytest

from palpate import _core
from palpate.world.mesh import repair as mesh_repair
from palpate.world.shapes.analytic import SHAPES

SPHERE = SHAPES["sphere"]


def damaged_sphere(seed: int = 0):
    v, t = SPHERE.mesh(3000)
    rng = np.random.default_rng(seed)
    keep = np.ones(len(t), dtype=bool)
    keep[rng.integers(0, len(t), 20)] = False
    keep[np.linalg.norm(v[t].mean(axis=1) - v[0], axis=1) < 5e-3] = False
    return v, t[keep]


def test_holes_are_filled_with_the_winding_of_their_neighbours():
    v, t = damaged_sphere()
    before = _core.Mesh(v, t)
    assert not before.report.closed
    v, t, done = mesh_repair.repair(before, widest_hole=0.02)
    after = _core.Mesh(v, t).report
    assert after.closed
    assert (after.turned, after.inverted, after.parts) == (0, 0, 1)
    assert after.volume == pytest.approx(4 / 3 * np.pi * SPHERE.radius**3, rel=0.01)
    assert done.filled > 10
    assert done.left_open == 0


def test_wide_holes_stay_open_and_are_reported():
    before = _core.Mesh(*damaged_sphere())
    v, t, done = mesh_repair.repair(before, widest_hole=0.008)
    assert done.left_open == 1
    assert done.widest_left_mm > 8
    assert not _core.Mesh(v, t).report.closed


def test_cracks_are_closed():
    """Each triangle has its own corners with errors of a thousandth of an edge, as from single precision."""
    v, t = SPHERE.mesh(1000)
    soup = v[t].reshape(-1, 3) + np.random.default_rng(1).normal(scale=2e-6, size=(3 * len(t), 3))
    cracked = _core.Mesh(soup, np.arange(len(soup), dtype=np.int32).reshape(-1, 3))
    assert cracked.report.parts == len(t)
    v, t, done = mesh_repair.repair(cracked, widest_hole=0.01)
    after = _core.Mesh(v, t).report
    assert after.closed
    assert (after.parts, after.triangles) == (1, len(cracked.triangles))
    assert done.sewn == len(soup) - after.vertices


def test_sliver_is_removed_and_the_surface_stays_closed():
    v, t = SPHERE.mesh(1000)
    a, b = t[0, :2]
    v = np.vstack([v, v[a] + 1e-9 * (v[b] - v[a])])  # split the edge a-b next to a
    neighbour = next(i for i in range(1, len(t)) if {a, b} <= set(t[i].tolist()))
    rows = [np.where(t[i] == old, len(v) - 1, t[i]) for i in (0, neighbour) for old in (a, b)]
    split = _core.Mesh(v, np.vstack([np.delete(t, [0, neighbour], axis=0), rows]).astype(np.int32))
    assert split.report.closed
    fixed, faces, done = mesh_repair.repair(split, widest_hole=0.01)
    after = _core.Mesh(fixed, faces).report
    assert done.collapsed == 2
    assert after.closed
    assert after.triangles == len(t)


def test_valid_mesh_is_unchanged():
    mesh = _core.Mesh(*SHAPES["torus"].mesh(1000))
    v, t, done = mesh_repair.repair(mesh, widest_hole=1.0)
    np.testing.assert_array_equal(v, mesh.vertices)
    np.testing.assert_array_equal(t, mesh.triangles)
    assert done == mesh_repair.Repairs(0, 0, 0, 0, 0, 0.0)


def test_holes_that_share_a_vertex_are_two_loops():
    v, t = SPHERE.mesh(3000)
    first, *others = np.flatnonzero((t == 100).any(axis=1))
    opposite = next(i for i in others if len(set(t[i]) & set(t[first])) == 1)
    hole = np.delete(t, [first, opposite], axis=0)
    loops = list(mesh_repair.loops(_core.Mesh(v, hole).rims()))
    assert sorted(len(loop) for loop in loops) == [3, 3]


def test_hole_filling_has_the_least_area_of_all_triangulations():
    v = np.array([[0, 0, 0], [1, 0, 0.3], [1, 1, 0], [0, 1, 0.1], [-0.5, 0.5, 0.4]], dtype=float)
    area = lambda t: np.linalg.norm(np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]), axis=1).sum()  # noqa: E731
    fans = [np.array([[i, (i + k) % 5, (i + k + 1) % 5] for k in (1, 2, 3)]) for i in range(5)]  # all triangulations
    best = mesh_repair.fill(v, list(range(5)), set())
    assert area(best) == pytest.approx(min(area(f) for f in fans))


def test_small_parts_are_counted():
    v, t = SPHERE.mesh(1000)
    crumb = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 1e-3 + 0.1
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]) + len(v)
    assert mesh_repair.small_parts(_core.Mesh(np.vstack([v, crumb]), np.vstack([t, faces]).astype(np.int32))) == 1
