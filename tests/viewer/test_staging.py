"""Drawn surfaces equal the rendered ones, with at most as many triangles as a browser can handle."""

from dataclasses import replace
from unittest.mock import MagicMock

import fake_session
import numpy as np
import pytest
import trimesh

from palpate.record.ticks import TICK
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.viewer.gauges import Gauges
from palpate.viewer.organs import OrganDrawing
from palpate.viewer.staging import stage_of
from palpate.world.mesh.coarse import drawable
from palpate.world.shapes.organs import organ


def test_small_mesh_is_drawn_unchanged():
    vertices, triangles = organ(4000)
    assert drawable(vertices, triangles)[0] is vertices


def test_large_mesh_is_drawn_coarser_at_the_same_position():
    vertices, triangles = organ(60_000)
    coarse_vertices, coarse_triangles = drawable(vertices, triangles, most=8000)
    assert 4000 < len(coarse_triangles) < 12_000
    fine, coarse = trimesh.Trimesh(vertices, triangles), trimesh.Trimesh(coarse_vertices, coarse_triangles)
    np.testing.assert_allclose(coarse.bounds, fine.bounds, atol=2e-3)
    assert coarse.volume == pytest.approx(fine.volume, rel=0.02)


def test_stability_margin_follows_the_sliders():
    """Twice the stiffness halves the margin, more damping changes the limit, and beyond it the number is red."""
    stage = replace(fake_session.stage(), stable_below=lambda B: 1000.0 + 100.0 * B)
    gauges = Gauges.__new__(Gauges)
    gauges._stage, gauges._limit = stage, None
    assert "&times; 3, stable below 1200 N/m" in gauges._margin(1.0, 1.0)
    assert "&times; 1.5" in gauges._margin(2.0, 1.0)
    assert "stable below 1400 N/m" in gauges._margin(1.0, 2.0)
    assert "color:#e12626" not in gauges._margin(2.9, 1.0)
    assert "color:#e12626" in gauges._margin(3.1, 1.0)
    gauges._stage = fake_session.stage()
    assert ">-<" in gauges._margin(1.0, 1.0)


def test_frames_and_tracked_objects_follow_their_newest_pose():
    text = (
        "frames: [{child: table, pose: {xyz: [0.1, 0, 0]}}, "
        "{parent: table, child: patient, pose: {xyz: [0, 0, 1.0]}, tracker: t}]\n"
        "trackers: {t: {simulated: {}}}\nobjects: [{name: ball, sphere: {radius: 0.03}, frame: patient}]\n"
    )
    rig = build(Scene.parse(text))
    made = stage_of(rig)
    assert [(frame.name, frame.tracked, frame.moving is None) for frame in made.frames] == [
        ("table", False, True), ("patient", True, False),
    ]  # fmt: skip
    tick = np.zeros(1, TICK)[0]
    assert made.frames[1].moving(tick) is None, "before the first tick"
    tick["tracked_p"][:3], tick["tracked_quat"][0] = [0.1, 0.2, 1.0], 1.0
    tick["live_p"][:3], tick["live_quat"][0] = [0.1, 0.15, 1.0], 1.0
    assert made.frames[1].moving(tick)[:3, 3] == pytest.approx([0.1, 0.2, 1.0])
    assert made.objects[0].slot == 0
    view = MagicMock()
    OrganDrawing(view, made.objects[0], (1, 2, 3)).show(tick)
    assert view.add_frame.return_value.position == pytest.approx([0.1, 0.15, 1.0])


def test_the_ball_stays_between_the_panels_where_bodies_are_taken_and_put_down():
    """In the tray of cubes it went behind the right panel when a cube was carried to its place."""
    from palpate.viewer.views import FIELD_OF_VIEW, overview

    rig = build(Scene.load("tray_cubes"))
    stage, arms, aspect = stage_of(rig), rig.arms, 0.9
    eye, target = overview(stage, aspect)
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(back, right), back])
    p_WH = (arms.X_WL @ arms.leader.fk(arms.q_leader0))[:3, 3]
    p_WT = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3]
    for place in rig.scene.task.place.targets:
        x, y, z = axes @ (p_WH + (np.array(place) - p_WT) / rig.scene.mapping.scale - eye)
        half = -z * np.tan(0.5 * FIELD_OF_VIEW)
        assert abs(x) < aspect * half
        assert abs(y) < half


def test_a_pointer_that_moves_down_moves_the_hand_straight_down():
    """And one that moves across moves it level; from steeply above it moves in the plane of the screen."""
    from palpate.viewer.control_panel import upright

    grab, eye = np.array([0.2, -0.1, 0.1]), np.array([0.1, -1.2, 0.6])
    back = (eye - grab) / np.linalg.norm(eye - grab)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    down = -np.cross(back, right)
    moved = upright(eye, grab + 0.05 * down, grab) - grab
    assert moved[:2] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert -0.08 < moved[2] < -0.05
    assert upright(eye, grab + 0.03 * right, grab) - grab == pytest.approx(0.03 * right)
    above = grab + np.array([0.0, -0.1, 1.0])
    assert upright(above, grab + 0.05 * down, grab) == pytest.approx(grab + 0.05 * down)
