"""The deformed surface of a soft object, read while the loop runs."""

from __future__ import annotations

import time
from itertools import pairwise

import numpy as np
import pytest
from soft_bodies import lockstep, soft_cube

import palpate
from palpate.viewer.staging import stage_of

SCENE = """
objects:
  - name: table
    box: {size: [0.3, 0.3, 0.01]}
    unit: m
    pose: {xyz: [0, 0, -0.03]}
    stiffness: 500
  - name: cube
    box: {size: [0.06, 0.06, 0.04]}
    unit: m
    tissue: {volume: cube.vtk, preset: liver, fixed: [{at: [0, 0, -0.02], box: [0.2, 0.2, 0.002]}]}
contact: {radius: 0.006}
operator: {palpate: {object: cube, approach: 0.3, press: 1.0, force: 0.25}}
"""


@pytest.fixture
def session(tmp_path):
    return palpate.Session(soft_cube(tmp_path, SCENE))


def test_surface_at_rest_is_that_of_the_stage_and_dents_where_the_tool_presses(session):
    cube = stage_of(session.rig).objects[1]
    assert cube.soft
    assert not stage_of(session.rig).objects[0].soft
    assert np.array_equal(session.soft_vertices(1), cube.vertices)
    ticks = lockstep(session, 1200)
    assert ticks["contacts"][-1] > 0
    moved = session.soft_vertices(1) - cube.vertices
    lowest = int(moved[:, 2].argmin())
    p_WV = cube.X_WO[:3, :3] @ cube.vertices[lowest] + cube.X_WO[:3, 3]
    away = np.linalg.norm((p_WV - ticks["p_WT"][-1])[:2])
    assert moved[lowest, 2] < -5e-4, "the surface below the tool sinks"
    assert away < 0.015, "it sinks below the tool"
    fixed = cube.vertices[:, 2] < -0.0199
    assert np.abs(moved[fixed]).max() < 0.2 * -moved[lowest, 2]


def test_surface_is_published_at_most_every_16_ticks(session):
    session._advance(1000)
    seen = []
    for _ in range(64):
        session._advance(1)
        seen.append(session.soft_vertices(1))
    changes = sum(not np.array_equal(a, b) for a, b in pairwise(seen))
    assert 3 <= changes <= 4


def test_reading_while_the_loop_runs_gives_whole_surfaces(session):
    rest = session.soft_vertices(1)
    session.start()
    shapes = []
    for _ in range(60):
        time.sleep(0.02)
        shapes.append(session.soft_vertices(1))
    session.stop()
    assert all(s.shape == rest.shape and np.isfinite(s).all() for s in shapes)
    assert max(np.abs(s - rest).max() for s in shapes) > 5e-4
    assert max(np.abs(s - rest).max() for s in shapes) < 0.02


@pytest.mark.parametrize("index", [0, 2, 99])
def test_other_objects_have_no_soft_surface(session, index):
    with pytest.raises(ValueError, match=f"object {index} of 2 does not exist or is not soft"):
        session.soft_vertices(index)
