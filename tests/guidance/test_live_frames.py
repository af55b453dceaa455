"""Frames that are told live: nothing counts before, velocities from pose to pose, leaps without a step, silence."""

import numpy as np
import pytest
from fixtures import DT, RESERVE, Stage, fixture, pose
from scipy.spatial.transform import Rotation

from palpate import _core

FRAME_LOST = 1 << 16
RATE = _core.GuidanceOptions().force_rate


def ball(frame):
    return _core.PlacedGeometry(_core.SurfaceGeometry(_core.Sphere(0.02)), np.eye(4), frame)


def test_before_it_is_told_a_frame_makes_its_fixture_count_for_nothing():
    """At the world's origin, where it would be taken to be, the tool is 5 mm in."""
    frame = _core.LiveFrame()
    for hard in (False, True):
        stage = Stage(fixture(ball(frame), hard=hard))
        out = stage.settle(np.array([0.0, 0.0, 0.015]))
        np.testing.assert_array_equal(out["F_T_W"], 0.0)
        np.testing.assert_array_equal(out["X_WT_goal"][:3, 3], [0.0, 0.0, 0.015])
        assert out["status"] & FRAME_LOST
    inside = _core.OffsetGeometry(_core.CombinedGeometry("union", [ball(frame)]), 0.001)
    assert Stage(fixture(inside)).settle(np.array([0.0, 0.0, 0.015]))["status"] & FRAME_LOST
    frame.set(np.eye(4))
    F = [stage.step(np.array([0.0, 0.0, 0.015]))["F_T_W"][2] for _ in range(600)]
    assert F[-1] > 1.5
    assert np.abs(np.diff(F, prepend=0.0)).max() <= RATE * DT * (1 + 1e-9)
    assert not stage.step(np.array([0.0, 0.0, 0.015]))["status"] & FRAME_LOST


def test_a_fixture_that_is_off_waits_for_no_frame():
    assert Stage(fixture(ball(_core.LiveFrame()), on=False)).settle(np.zeros(3))["status"] == 0


@pytest.mark.parametrize("every", [1, 33])
def test_velocities_are_found_from_pose_to_pose(every):
    """Told at the cycle's rate or at a camera's: to a few percent what a closed form says."""
    frame, w, v = _core.LiveFrame(), np.array([0.2, -0.4, 0.3]), np.array([0.03, -0.02, 0.05])
    stage = Stage(fixture(ball(frame)))
    for k in range(400):
        if k % every == 0:
            t = k * DT
            frame.set(pose(v * t + 0.01 * np.sin(2.0 * t), Rotation.from_rotvec(w * t).as_matrix()))
        stage.step(np.array([0.0, 0.0, 0.1]))
    t = 400 * DT
    V = frame.at(t)[1]
    np.testing.assert_allclose(V[:3], v + 0.02 * np.cos(2.0 * t), atol=1e-3)
    np.testing.assert_allclose(V[3:], w, atol=1e-6)
    for _ in range(200):
        stage.step(np.array([0.0, 0.0, 0.1]))
    np.testing.assert_array_equal(frame.at(t)[1], 0.0, err_msg="told no more, it rests")


@pytest.mark.parametrize("given", [False, True])
def test_a_leap_is_no_step_in_force(given):
    """A marker that jumps by 2 cm, told to rest or with no velocity: the force follows at its rate."""
    frame = _core.LiveFrame()
    frame.set(np.eye(4))
    stage = Stage(fixture(ball(frame)))
    before = stage.settle(np.array([0.0, 0.0, 0.021]))["F_T_W"]
    for k in range(600):
        if k % 40 == 0:
            X = pose((0.0, 0.0, 0.0 if k % 80 else 0.02))
            frame.set(X, np.zeros(6)) if given else frame.set(X)
        out = stage.step(np.array([0.0, 0.0, 0.021]))["F_T_W"]
        assert np.linalg.norm((out - before)[:3]) <= RATE * DT * (1 + 1e-9)
        before = out


def test_a_frame_that_falls_silent_fades_out_and_comes_back():
    frame = _core.LiveFrame()
    stage = Stage(fixture(ball(frame), patience=0.1, rise=0.05, fall=0.05))
    at, lost = np.array([0.0, 0.0, 0.015]), []
    for k in range(1000):
        if k % 30 == 0 and not 300 < k < 700:
            frame.set(np.eye(4))
        out = stage.step(at)
        lost.append(bool(out["status"] & FRAME_LOST))
        if k == 299:
            assert stage.core.authority(0) == 1.0
        if k == 600:
            assert stage.core.authority(0) == 0.0
            np.testing.assert_array_equal(out["F_T_W"], 0.0)
    assert (np.flatnonzero(lost)[[0, -1]] - [400, 719]).max() <= 1, "told last at 300, again at 720"
    assert stage.core.authority(0) == 1.0
    with pytest.raises(ValueError, match=r"patience = 0.0.*must be above 0 s"):
        _core.Fixtures([fixture(ball(frame), patience=0.0)])


def test_a_leap_leads_the_goals_of_all_that_hang_on_the_frame_at_the_return_speed():
    """By 0.9 mm in a tick, that is at 0.9 m/s: too fast for a motion, though less than what borders may move."""
    frame = _core.LiveFrame()
    frame.set(np.eye(4))
    stage = Stage(*(fixture(ball(frame), name=name, hard=True) for name in ("one", "two")))
    hand = np.array([0.0, 0.0, 0.0195])
    before = stage.settle(hand, ticks=1000)["X_WT_goal"]
    frame.set(np.eye(4))
    stage.step(hand)
    frame.set(pose((0.0, 0.0, 0.0009)))
    for _ in range(60):
        now = stage.step(hand)["X_WT_goal"]
        assert np.linalg.norm((now - before)[:3, 3]) <= _core.GuidanceOptions().return_speed * DT * (1 + 1e-6)
        before = now
    np.testing.assert_allclose(now[2, 3], 0.0209 + RESERVE, atol=1e-6)
