"""Coarser surfaces to draw."""

import numpy as np
import trimesh

from palpate.base import cache
from palpate.world.mesh import coarse

BALL = trimesh.creation.icosphere(subdivisions=5, radius=0.04)


def test_a_stray_vertex_far_away_leaves_a_surface():
    vertices = np.vstack([BALL.vertices, [[1e4, -1e4, 1e4]]])
    drawn, faces = coarse.drawable(vertices, BALL.faces.astype(np.int32), 10_000)
    assert 100 < len(faces) <= 10_000
    radius = np.linalg.norm(drawn[np.unique(faces)], axis=1)
    assert radius.min() > 0.03
    assert radius.max() < 0.0401


def test_a_kept_surface_is_of_this_version(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    faces = BALL.faces.astype(np.int32)
    first = coarse.drawable(BALL.vertices, faces, 5_000, "ball")
    again = coarse.drawable(np.zeros((0, 3)), faces, 5_000, "ball")
    np.testing.assert_array_equal(first[0], again[0])
    np.testing.assert_array_equal(first[1], again[1])
    another = tmp_path / "coarse.py"  # an edited source
    another.write_text("")
    monkeypatch.setattr(coarse, "__file__", str(another))
    assert len(cache.entries()) == 1
    coarse.drawable(BALL.vertices, faces, 5_000, "ball")
    assert len(cache.entries()) == 2
