"""Flipped edges of thin triangles: the surface stays where it was, with better triangles."""

import numpy as np
import pytest

from palpate import _core
from palpate.world.mesh import repair as mesh_repair
from palpate.world.mesh.flips import THIN, flip, thickness
from palpate.world.shapes.analytic import SHAPES


def tilted_sliver():
    """A square of the side 10 mm in four triangles: its centre is 0.3 mm beside a side, and 0.06 mm above the plane."""
    v = np.array([[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0], [5, 0.3, 0.06], [5, -8, 0]]) * 1e-3
    return v, np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5]], dtype=np.int32)


def stretched(name: str, seed: int):
    """A closed shape whose vertices moved along the surface, so that many of its triangles are thin."""
    v, t = SHAPES[name].mesh(3000)
    mesh = _core.Mesh(v, t)
    moved = v + np.random.default_rng(seed).normal(scale=1.2e-3, size=v.shape)
    return mesh.closest(moved)[1], t


def tilt_deg(v, t):
    n = np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]])
    return np.degrees(np.arccos(np.abs(n[:, 2]) / np.linalg.norm(n, axis=1))).max()


def test_a_sliver_is_replaced_by_the_other_diagonal():
    v, t = tilted_sliver()
    assert tilt_deg(v, t) == pytest.approx(np.degrees(np.arctan(0.06 / 0.3)), abs=0.1)
    better, flips = flip(v, t, 0.1e-3)
    assert flips == 1
    assert thickness(v, better).min() > THIN
    assert tilt_deg(v, better) < 1.0


def test_an_edge_that_would_move_the_surface_stays():
    v, t = tilted_sliver()
    unchanged, flips = flip(v, t, 0.01e-3)
    assert flips == 0
    np.testing.assert_array_equal(unchanged, t)


def test_a_sharp_edge_stays():
    v, t = SHAPES["box"].mesh(12)
    v = v * [1.0, 1.0, 0.05]  # thin sides, whose diagonals cannot become better, beside edges of 90 degrees
    assert flip(v, t, 1e-3)[1] == 0


@pytest.mark.parametrize("name", ["sphere", "torus"])
@pytest.mark.parametrize("seed", range(4))
def test_the_surface_keeps_its_topology_and_place(name, seed):
    v, t = stretched(name, seed)
    before, tolerance = _core.Mesh(v, t), 0.05e-3
    assert (thickness(v, t) < THIN).sum() > 20
    better, flips = flip(v, t, tolerance)
    after = _core.Mesh(v, better)
    assert flips > 10
    assert after.report.closed == before.report.closed
    assert (after.report.triangles, after.report.vertices) == (before.report.triangles, before.report.vertices)
    assert (after.report.turned, after.report.inverted) == (before.report.turned, before.report.inverted)
    assert (thickness(v, better) < THIN).sum() < (thickness(v, t) < THIN).sum()
    assert thickness(v, better).min() >= thickness(v, t).min()
    distance = np.abs(before.closest(v[better].mean(axis=1))[0])
    assert distance.max() < 3 * tolerance  # a place may be moved by several flips
    assert flip(v, better, tolerance)[1] == 0


def test_a_repaired_copy_says_how_many_edges_were_flipped():
    v, t = stretched("sphere", 0)
    mesh = _core.Mesh(v, t)
    w, better, done = mesh_repair.repair(mesh, widest_hole=0.01)
    assert done.flipped > 10
    assert (thickness(w, better) < THIN).sum() < (thickness(v, t) < THIN).sum()
