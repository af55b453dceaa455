"""The estimates of `palpate check`, against what is measured on surfaces that are known exactly."""

from itertools import pairwise

import numpy as np
import pytest

import palpate.contact
from palpate import _core
from palpate.contact import touchable
from palpate.contact.judging import RADIUS, STIFFNESS
from palpate.shapes.analytic import SHAPES
from palpate.shapes.paths import tool_path
from palpate.studies.radius import work as study


@pytest.mark.parametrize(("name", "triangles"), [("torus", 1000), ("torus", 10_000), ("wavy", 1000), ("wavy", 10_000)])
def test_the_felt_error_is_no_more_than_estimated(name, triangles):
    shape, mesh = SHAPES[name], _core.Mesh(*SHAPES[name].mesh(triangles))
    fine = touchable.fineness(mesh, STIFFNESS)
    way = tool_path(shape, -1e-3, 0.05, RADIUS)
    felt = palpate.contact.render(mesh, way.tips, radius=RADIUS, stiffness=STIFFNESS)
    phi, normal = shape.distance(way.tips[way.steady])
    force = felt.force[way.steady]
    strength = np.linalg.norm(force, axis=1)
    cosine = np.clip((force * normal).sum(axis=1) / strength, -1, 1)
    assert np.percentile(np.degrees(np.arccos(cosine)), 95) < 1.1 * fine.direction_error_deg
    assert np.percentile(1e3 * np.abs(strength - STIFFNESS * (RADIUS - phi)), 95) < 1.3 * fine.force_error_mN


def test_facets_of_a_sphere_have_the_sagitta_of_an_arc():
    """Unsmoothed: s^2 / 8 R with s across the facets."""
    shape = SHAPES["sphere"]
    mesh = _core.Mesh(*shape.mesh(5000))
    fine = touchable.fineness(mesh, 500.0)
    spacing = 1e-3 * fine.edge_mm * 3**0.5 / 3  # from centre to centre of two even triangles
    assert fine.turn_deg == pytest.approx(np.degrees(spacing / shape.radius), rel=0.25)
    assert not fine.coarse


def test_a_coarse_mesh_is_called_so_and_the_triangles_that_would_do_do():
    coarse = touchable.fineness(_core.Mesh(*SHAPES["wavy"].mesh(700)), 500.0)
    assert coarse.coarse
    enough = touchable.fineness(_core.Mesh(*SHAPES["wavy"].mesh(coarse.triangles_needed)), 500.0)
    assert enough.direction_error_deg < 1.25 * touchable.COARSE_DEG
    assert enough.force_error_mN < 1.25 * touchable.COARSE_MN


def test_a_round_thing_of_few_facets_is_doubtful_and_a_box_is_not():
    assert touchable.fineness(_core.Mesh(*SHAPES["sphere"].mesh(80)), 500.0).turn_deg < 30
    assert touchable.fineness(_core.Mesh(*SHAPES["sphere"].mesh(20)), 500.0).doubtful_share > 0.9
    assert touchable.fineness(_core.Mesh(*SHAPES["box"].mesh(12)), 500.0).doubtful_share == 0.0


@pytest.mark.parametrize("noise", [0.05e-3, 0.2e-3, 0.5e-3])
def test_roughness_is_the_noise_that_was_added(noise):
    v, t = SHAPES["torus"].mesh(20_000)
    mesh = _core.Mesh(v + np.random.default_rng(0).normal(scale=noise, size=v.shape), t)
    assert touchable.roughness(mesh) == pytest.approx(noise, rel=0.15)
    assert touchable.roughness(_core.Mesh(v, t)) < 0.03e-3
    assert touchable.roughness(_core.Mesh(*SHAPES["box"].mesh(2000))) < 1e-9
    assert touchable.roughness(_core.Mesh(*SHAPES["box"].mesh(12))) == 0.0


def test_hollows_limit_the_radius_as_their_curvature_does():
    wavy = SHAPES["wavy"]
    tightest = 1.0 / (2 * wavy.amplitude * wavy.k**2)  # at the bottom of a pit: along x and along y
    suits = touchable.radius(_core.Mesh(*wavy.mesh(20_000)), 0.02)
    assert tightest < 1e-3 * suits.largest_mm < 2.5 * tightest
    assert suits.unreachable_share > 0.05
    assert not np.isfinite(touchable.radius(_core.Mesh(*SHAPES["sphere"].mesh(1000)), 0.02).largest_mm)


@pytest.fixture(scope="module")
def map_():
    return study.run(radii=(1e-3, 2e-3, 4e-3, 8e-3), features=(4e-3, 16e-3), noises=(0.05e-3, 0.2e-3, 0.5e-3))


def test_half_the_width_keeps_a_feature(map_):
    for row in map_:
        ratio = row["radius_mm"] / row["feature_mm"]
        assert row["kept"] > 0.97 if ratio <= touchable.FEATURE_RADIUS else row["kept"] < 0.9, row


def test_noise_turns_the_force_as_the_rule_says(map_):
    for row in map_:
        if row["feature_mm"] == 4 or row["radius_mm"] < 2:  # the rule is for a sphere that the feature lets in
            continue
        rule = touchable.direction_noise_deg(1e-3 * row["noise_mm"], 1e-3 * row["radius_mm"], study.GRID)
        assert row["direction_deg"] == pytest.approx(rule, rel=0.2), row


def test_a_greater_radius_steadies_the_force_and_pushes_it_out(map_):
    """'Smooths, but results in a noisy deflection', says the paper. The deflection is steadier, and too large."""
    rows = [r for r in map_ if r["feature_mm"] == 16 and r["noise_mm"] == 0.5]
    for less, more in pairwise(rows):
        assert more["step_mN"] < less["step_mN"]
        assert more["direction_deg"] < less["direction_deg"]
    assert rows[-1]["bias_mN"] > rows[1]["bias_mN"] > 100


def test_the_recommended_radius_keeps_both_limits_where_that_can_be():
    mesh = _core.Mesh(*SHAPES["wavy"].mesh(2000))
    spacing = np.median(np.linalg.norm(np.diff(mesh.vertices[mesh.triangles[:, :2]], axis=1), axis=2))
    rough = touchable.SMOOTHED * spacing * 1.3
    suits = touchable.radius(mesh, 2e-3, feature=0.2, noise=rough)
    assert not suits.conflict
    assert suits.smallest_mm <= suits.recommended_mm * 1.05
    assert suits.recommended_mm <= suits.largest_mm
    assert suits.direction_noise_deg == pytest.approx(touchable.DIRECTION_LIMIT_DEG, rel=0.05)
    against = touchable.radius(mesh, 2e-3, feature=4e-3, noise=rough)
    assert against.conflict
    assert against.recommended_mm == pytest.approx(2.0)
