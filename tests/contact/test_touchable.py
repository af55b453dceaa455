"""The estimates of `palpate check`, against measurements on surfaces with a closed form."""

from dataclasses import fields
from itertools import pairwise

import numpy as np
import pytest

import palpate.scene.contact
from palpate import _core
from palpate.scene.contact import touchable
from palpate.scene.contact.judging import RADIUS, STIFFNESS
from palpate.world.mesh import Mesh, index
from palpate.world.shapes.analytic import SHAPES
from palpate.world.shapes.paths import tool_path
from palpate_lab.studies.radius import work as study


@pytest.mark.parametrize(("name", "triangles"), [("torus", 1000), ("torus", 10_000), ("wavy", 1000), ("wavy", 10_000)])
def test_force_error_is_no_larger_than_estimated(name, triangles):
    shape, mesh = SHAPES[name], _core.Mesh(*SHAPES[name].mesh(triangles))
    fine = touchable.fineness(mesh, STIFFNESS)
    path = tool_path(shape, -1e-3, 0.05, RADIUS)
    felt = palpate.contact.render(mesh, path.tips, radius=RADIUS, stiffness=STIFFNESS)
    phi, normal = shape.distance(path.tips[path.steady])
    force = felt.force[path.steady]
    strength = np.linalg.norm(force, axis=1)
    cosine = np.clip((force * normal).sum(axis=1) / strength, -1, 1)
    assert np.percentile(np.degrees(np.arccos(cosine)), 95) < 1.1 * fine.direction_error_deg
    assert np.percentile(1e3 * np.abs(strength - STIFFNESS * (RADIUS - phi)), 95) < 1.3 * fine.force_error_mN


def test_facets_of_a_sphere_have_the_sagitta_of_an_arc():
    """Without smoothing: s^2 / 8 R with the width s of the facets."""
    shape = SHAPES["sphere"]
    mesh = _core.Mesh(*shape.mesh(5000))
    fine = touchable.fineness(mesh, 500.0)
    spacing = 1e-3 * fine.edge_mm * 3**0.5 / 3  # distance between the centres of two equal triangles
    assert fine.turn_deg == pytest.approx(np.degrees(spacing / shape.radius), rel=0.25)
    assert not fine.coarse


def test_coarse_mesh_is_reported_and_the_advised_number_of_triangles_suffices():
    coarse = touchable.fineness(_core.Mesh(*SHAPES["wavy"].mesh(700)), 500.0)
    assert coarse.coarse
    enough = touchable.fineness(_core.Mesh(*SHAPES["wavy"].mesh(coarse.triangles_needed)), 500.0)
    assert enough.direction_error_deg < 1.25 * touchable.COARSE_DEG
    assert enough.force_error_mN < 1.25 * touchable.COARSE_MN


def test_round_object_of_few_facets_is_doubtful_and_a_box_is_not():
    assert touchable.fineness(_core.Mesh(*SHAPES["sphere"].mesh(80)), 500.0).turn_deg < 30
    assert touchable.fineness(_core.Mesh(*SHAPES["sphere"].mesh(20)), 500.0).doubtful_share > 0.9
    assert touchable.fineness(_core.Mesh(*SHAPES["box"].mesh(12)), 500.0).doubtful_share == 0.0


@pytest.mark.parametrize("noise", [0.05e-3, 0.2e-3, 0.5e-3])
def test_estimated_roughness_is_the_added_noise(noise):
    v, t = SHAPES["torus"].mesh(20_000)
    mesh = _core.Mesh(v + np.random.default_rng(0).normal(scale=noise, size=v.shape), t)
    assert touchable.roughness(mesh) == pytest.approx(noise, rel=0.15)
    assert touchable.roughness(_core.Mesh(v, t)) < 0.03e-3
    assert touchable.roughness(_core.Mesh(*SHAPES["box"].mesh(2000))) < 1e-9
    assert touchable.roughness(_core.Mesh(*SHAPES["box"].mesh(12))) == 0.0


def test_concave_curvature_limits_the_radius():
    wavy = SHAPES["wavy"]
    tightest = 1.0 / (2 * wavy.amplitude * wavy.k**2)  # radius of curvature at the bottom of a pit, in x and in y
    suits = touchable.radius(_core.Mesh(*wavy.mesh(20_000)), 0.02)
    assert tightest < 1e-3 * suits.largest_mm < 2.5 * tightest
    assert suits.unreachable_share > 0.05
    assert not np.isfinite(touchable.radius(_core.Mesh(*SHAPES["sphere"].mesh(1000)), 0.02).largest_mm)


@pytest.fixture(scope="module")
def map_():
    return study.run(radii=(1e-3, 2e-3, 4e-3, 8e-3), features=(4e-3, 16e-3), noises=(0.05e-3, 0.2e-3, 0.5e-3))


def test_radius_of_half_the_width_keeps_a_feature(map_):
    for row in map_:
        ratio = row["radius_mm"] / row["feature_mm"]
        assert row["kept"] > 0.97 if ratio <= touchable.FEATURE_RADIUS else row["kept"] < 0.9, row


def test_noise_changes_the_force_direction_as_estimated(map_):
    for row in map_:
        if row["feature_mm"] == 4 or row["radius_mm"] < 2:  # the rule holds for a sphere that fits into the feature
            continue
        rule = touchable.direction_noise_deg(1e-3 * row["noise_mm"], 1e-3 * row["radius_mm"], study.GRID)
        assert row["direction_deg"] == pytest.approx(rule, rel=0.2), row


def test_larger_radius_smooths_the_force_but_increases_the_deflection(map_):
    """The paper states 'smooths, but results in a noisy deflection'. The deflection is smoother here, but too large."""
    rows = [r for r in map_ if r["feature_mm"] == 16 and r["noise_mm"] == 0.5]
    for less, more in pairwise(rows):
        assert more["step_mN"] < less["step_mN"]
        assert more["direction_deg"] < less["direction_deg"]
    assert rows[-1]["bias_mN"] > rows[1]["bias_mN"] > 100


def test_recommended_radius_satisfies_both_limits_if_feasible():
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


def test_share_of_slivers_and_creases():
    """A box of 12 triangles has 12 creases, two for each triangle; a smooth ball has none until one is split."""
    assert touchable.fineness(_core.Mesh(*SHAPES["box"].mesh(12)), 500.0).stepping_share == pytest.approx(2 / 3)
    vertices, faces = SHAPES["sphere"].mesh(2000)
    assert touchable.fineness(_core.Mesh(vertices, faces), 500.0).stepping_share == 0.0
    a, b, c = faces[0]
    near_edge = 0.49 * vertices[a] + 0.49 * vertices[b] + 0.02 * vertices[c]  # three triangles, one of them thin
    n = len(vertices)
    split = np.concatenate([faces[1:], [[a, b, n], [b, c, n], [c, a, n]]]).astype(np.int32)
    share = touchable.fineness(_core.Mesh(np.concatenate([vertices, near_edge[None]]), split), 500.0).stepping_share
    areas = np.linalg.norm(np.cross(*(vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2))), axis=1)
    assert share == pytest.approx(0.02 * areas[0] / areas.sum())


@pytest.mark.parametrize(("depth", "degrees"), [(0.0, 1.43), (1e-3, 2.86), (2e-3, np.inf), (3e-3, np.inf)])
def test_an_edge_turns_the_force_faster_the_deeper_the_tip(depth, degrees):
    assert touchable.turn_per_ms_deg(2e-3, depth) == pytest.approx(degrees, abs=0.01)


def test_a_sample_of_a_large_mesh_tells_what_the_whole_does(monkeypatch):
    mesh = _core.Mesh(*SHAPES["wavy"].mesh(40_000))
    whole, hollows = touchable.fineness(mesh, 500.0), touchable.radius(mesh, 0.002).largest_mm
    monkeypatch.setattr(touchable, "MOST_TRIANGLES", 5_000)
    sample = touchable.fineness(mesh, 500.0)
    for one in fields(whole):
        assert getattr(sample, one.name) == pytest.approx(getattr(whole, one.name), rel=0.06, abs=1e-3), one.name
    assert touchable.radius(mesh, 0.002).largest_mm == pytest.approx(hollows, rel=0.06)


def test_the_fineness_of_a_large_mesh_is_kept(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(index, "CACHED_FROM", 1)
    mesh = Mesh(*SHAPES["wavy"].mesh(3_000))
    first = touchable.fineness_of(mesh, 500.0)
    assert first == touchable.fineness(mesh.core, 500.0)
    monkeypatch.setattr(touchable, "fineness", None)
    assert touchable.fineness_of(mesh, 500.0) == first
    with pytest.raises(TypeError):
        touchable.fineness_of(mesh, 600.0)
