"""What is drawn is what is felt, only never heavier than a browser can turn."""

import numpy as np
import pytest
import trimesh

from palpate.shapes.organ import organ
from palpate.viewer.staging import drawable


def test_a_surface_that_is_light_enough_is_drawn_as_it_is():
    vertices, triangles = organ(4000)
    assert drawable(vertices, triangles)[0] is vertices


def test_a_heavy_surface_is_drawn_coarser_in_the_same_place():
    vertices, triangles = organ(60_000)
    coarse_vertices, coarse_triangles = drawable(vertices, triangles, most=8000)
    assert 4000 < len(coarse_triangles) < 12_000
    fine, coarse = trimesh.Trimesh(vertices, triangles), trimesh.Trimesh(coarse_vertices, coarse_triangles)
    np.testing.assert_allclose(coarse.bounds, fine.bounds, atol=2e-3)
    assert coarse.volume == pytest.approx(fine.volume, rel=0.02)
