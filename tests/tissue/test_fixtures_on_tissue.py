"""Fixtures and contact methods on a deformed surface: gaps beside those to the deformed triangles, by brute force."""

from __future__ import annotations

import numpy as np
import pytest
from brute_force import distance_by_segments_and_planes
from soft_bodies import lockstep, soft_cube

import palpate
from palpate.base.errors import SceneError

R = 0.006
SCENE = """
objects:
  - name: cube
    box: {size: [0.06, 0.06, 0.04]}
    unit: m
    tissue: {volume: cube.vtk, preset: silicone_5kPa, fixed: [{at: [0, 0, -0.02], box: [0.2, 0.2, 0.002]}]}
contact: {radius: 0.006%(contact)s}
operator: {path: [{t: 0, xyz: [0, 0, 0.03]}, {t: 0.3, xyz: [0, 0, %(z)s]}, {t: 3, xyz: [0, 0, %(z)s]}]}
guidance: [%(guidance)s]
"""
FIXTURE = "{geometry: {object: {name: cube}}, frame: cube, role: {%s}, law: {stiffness: %s, damping: 0}%s}"


def held(folder, guidance="", z=0.0215, contact="", ticks=600):
    """Last tick of a press that is held, and the deformed surface."""
    scene = soft_cube(folder, SCENE % {"guidance": guidance, "z": z, "contact": contact})
    session = palpate.Session(scene)
    rows = lockstep(session, ticks)
    core = session.rig.surfaces[0].body.core
    return rows, (np.array(session.soft_vertices(0)), core.triangles), (core.vertices, core.triangles)


def distance(surface, rows):
    """Distance of the tool's goal to a surface [m], without search tree; the goal is above it."""
    return float(distance_by_segments_and_planes(*surface, rows["p_WT_goal"][-1:])[0])


@pytest.mark.parametrize(
    ("role", "gap"),
    [
        ("name: forbid, margin: 0.012", lambda d: d - 0.012),
        ("name: guide, margin: 0.001", lambda d: 0.001 - abs(d)),
    ],
    ids=["forbid", "guide"],
)
def test_gap_of_a_fixture_is_that_to_the_deformed_surface(tmp_path, role, gap):
    rows, deformed, at_rest = held(tmp_path, FIXTURE % (role, 1e-3, ""))
    near = distance(deformed, rows)
    assert rows["guidance_gap"][-1] == pytest.approx(gap(near), abs=2e-5)
    assert abs(near - distance(at_rest, rows)) > 3e-4, "control: the surface is dented"


def test_hard_fixture_keeps_its_margin_from_the_dent(tmp_path):
    margin = 0.0005
    fixture = FIXTURE % (f"name: forbid, margin: {margin}", 100, ", hard: true")
    rows, deformed, _ = held(tmp_path, fixture, z=0.010)
    assert distance(deformed, rows) == pytest.approx(margin, abs=1e-4)
    goal = rows["p_WT_goal"][-1]
    assert goal[2] < 0.02 + margin - 5e-4, "the tool went on with the surface, beyond the margin at rest"
    free, _, _ = held(tmp_path, z=0.010)
    assert free["p_WT_goal"][-1][2] < goal[2] - 1e-3, "control: without the fixture it goes deeper"


def test_methods_that_need_no_index_feel_the_same_dent(tmp_path):
    """Second algorithm: below a flat side both methods have the same depth."""
    proxy, penalty = (held(tmp_path, contact=f", method: {name}")[0]["F_T_W"] for name in ("proxy", "penalty"))
    assert proxy[-1, 2] > 0.1
    np.testing.assert_allclose(proxy[-1], penalty[-1], atol=0.01 * proxy[-1, 2])
    assert max(np.ptp(force[-50:, 2]) for force in (proxy, penalty)) < 0.01


@pytest.mark.parametrize("method", ["paper-plane", "paper-alg1", "face-normal", "approach-velocity"])
def test_method_with_an_index_at_rest_is_refused(tmp_path, method):
    with pytest.raises(SceneError, match="soft, and the paper's methods index its triangles once"):
        held(tmp_path, contact=f", method: {method}")


def test_whole_tool_presses_with_every_sphere(tmp_path):
    """Virtual work: spheres beside the tip share the load; the sum of their forces is that of the record."""
    spheres = (
        ", spheres: [{link: tip, at: [0.009, 0, 0], radius: 0.006}, {link: tip, at: [-0.009, 0, 0], radius: 0.006}]"
    )
    rows, _, _ = held(tmp_path, contact=spheres)
    last = rows[-1]
    assert set(last["touch_sphere"][:3]) == {0.0, 1.0, 2.0}
    assert last["touch_force"][:3].sum() == pytest.approx(last["F_T_W"][2], rel=0.1)
    alone, _, _ = held(tmp_path)
    assert last["touch_force"][:3].sum() < 2.9 * alone["F_T_W"][-1][2], "the spheres stand in one dent"
