"""Steps of the force over ridges of known radius, and over a user's mesh."""

from __future__ import annotations

import numpy as np
import pytest

from palpate.world.mesh import Mesh
from palpate.world.mesh import files as mesh_files
from palpate.world.shapes.analytic import Sphere
from palpate_lab.verify.bench import organs


@pytest.fixture(scope="module")
def ridges():
    return {(r["mesh"], r["depth_mm"]): r for r in organs.ridge_rows()}


def test_ridge_has_the_radius_that_it_names():
    vertices, faces = organs.ridge(2e-3, 0.1e-3)
    mesh = Mesh(vertices, faces)
    turns = np.linspace(-0.7, 0.7, 50)
    arc = 3e-3 * np.stack([np.sin(turns), 0 * turns, np.cos(turns)], axis=1)
    np.testing.assert_allclose(mesh.closest(arc)[0], 1e-3, atol=2e-6)


def test_ridge_with_fine_facets_turns_the_force_nearly_as_the_exact_one(ridges):
    fine = [ridges[f"ridge {R} mm, facets 0.3 mm", 1.0] for R in (0, 1, 2)]
    assert all(r["true_step_deg"] - 0.2 < r["step_deg"] < 1.5 * r["true_step_deg"] for r in fine)


def test_facets_coarser_than_the_ridge_turn_the_force_faster_where_the_tip_is_as_deep_as_its_radius(ridges):
    coarse = [ridges[f"ridge {R} mm, facets 2.6 mm", 2.0] for R in (1, 2)]
    assert all(r["step_deg"] > 5 * r["true_step_deg"] for r in coarse)
    assert all(r["limited_step_deg"] < 5.0 and r["limited_step_N"] <= 0.05 + 1e-9 for r in coarse)


def test_slides_over_a_users_mesh(tmp_path, monkeypatch):
    """On a sphere of 30 mm the force turns as fast as the tip moves around its centre, with noise smoothed or not."""
    monkeypatch.setattr(organs, "PATHS", 1)
    monkeypatch.setattr(organs, "LENGTH", 0.03)
    file = tmp_path / "ball.stl"
    vertices, faces = Sphere().mesh(20_000)
    mesh_files.write(file, 1e3 * vertices, faces)
    rows = list(organs.organ_rows(file))
    assert [r["depth_mm"] for r in rows] == [1.0, 2.0] * 3
    assert [r["repaired"] for r in rows] == [False] * 4 + [True] * 2
    assert all(r["mesh"] == "ball" and r["large_share"] == 0.0 for r in rows)
    for r in rows:
        assert r["step_deg"] == pytest.approx(np.degrees(organs.STEP / (0.032 - 1e-3 * r["depth_mm"])), rel=0.1)
