"""Live frames: inactive before the first pose, velocities by differences, jumps without a force step, silence."""

import numpy as np
import pytest
from fixtures import DT, RESERVE, Stage, fixture, pose
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance

FRAME_LOST = 1 << 16
RATE = _core.GuidanceOptions().force_rate


def ball(frame):
    return _guidance.PlacedGeometry(_guidance.SurfaceGeometry(_core.Sphere(0.02)), np.eye(4), frame)


def test_fixture_on_a_live_frame_is_inactive_before_the_first_pose():
    """If the frame were assumed at the world's origin, the tool would be 5 mm inside."""
    frame = _core.LiveFrame()
    for hard in (False, True):
        stage = Stage(fixture(ball(frame), hard=hard))
        out = stage.settle(np.array([0.0, 0.0, 0.015]))
        np.testing.assert_array_equal(out["F_T_W"], 0.0)
        np.testing.assert_array_equal(out["X_WT_goal"][:3, 3], [0.0, 0.0, 0.015])
        assert out["status"] & FRAME_LOST
    inside = _guidance.OffsetGeometry(_guidance.CombinedGeometry("union", [ball(frame)]), 0.001)
    assert Stage(fixture(inside)).settle(np.array([0.0, 0.0, 0.015]))["status"] & FRAME_LOST
    frame.set(np.eye(4))
    F = [stage.step(np.array([0.0, 0.0, 0.015]))["F_T_W"][2] for _ in range(600)]
    assert F[-1] > 1.5
    assert np.abs(np.diff(F, prepend=0.0)).max() <= RATE * DT * (1 + 1e-9)
    assert not stage.step(np.array([0.0, 0.0, 0.015]))["status"] & FRAME_LOST


def test_disabled_fixture_does_not_wait_for_its_frame():
    assert Stage(fixture(ball(_core.LiveFrame()), on=False)).settle(np.zeros(3))["status"] == 0


@pytest.mark.parametrize("every", [1, 33])
def test_velocity_is_estimated_from_successive_poses(every):
    """Poses at the rate of the cycle or of a camera give the closed form within a few percent."""
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
    np.testing.assert_array_equal(frame.at(t)[1], 0.0, err_msg="without updates the frame is at rest")


@pytest.mark.parametrize("given", [False, True])
def test_jump_of_a_frame_gives_no_force_step(given):
    """A marker jumps by 2 cm, with zero or without velocity: the force changes at the rate limit."""
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


def test_fixture_of_a_silent_frame_fades_out_and_returns():
    frame = _core.LiveFrame()
    stage = Stage(fixture(ball(frame), timeout=0.1, rise=0.05, fall=0.05))
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
    assert (np.flatnonzero(lost)[[0, -1]] - [400, 719]).max() <= 1, "the last update is at 300, the next at 720"
    assert stage.core.authority(0) == 1.0
    with pytest.raises(ValueError, match=r"timeout = 0.0.*must be above 0 s"):
        _guidance.Fixtures([fixture(ball(frame), timeout=0.0)])


def test_jump_of_a_frame_moves_the_goal_at_the_return_speed():
    """A step of 0.9 mm in a tick, 0.9 m/s, is too fast for a motion, but below the reserve of the borders."""
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
