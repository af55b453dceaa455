"""The endoscope arm of a session: hands follow the picture, also a rolled one, and move the camera under its pedal."""
# ruff: noqa: RUF005  (the sums are of arrays)

import numpy as np
import pytest

import palpate
from palpate.arm.ecm import R_CD, R_DL
from palpate.base.errors import ArmError, SceneError
from palpate.session.beside import AttendedLoop
from palpate.session.camera import CameraArm

SCENE = """
objects:
  - {{name: floor, plane: {{}}, stiffness: 400, damping: 2}}
operator:
  path:
    - {{t: 0, xyz: [0, 0, 0.01]}}
    - {{t: 1, xyz: [0.02, 0.01, 0.02]}}
    - {{t: 2, xyz: [0.0, 0.0, 0.01]}}
    - {{t: 3, xyz: [-0.02, 0.01, 0.02]}}
mapping: {{align_rate: 0}}
{more}
"""
ROLLED = "ecm: {joints: [0.1, -0.2, 0.08, 0.6], endoscope: {tilt_deg: 30}}"


def session_of(more="ecm: {}"):
    return palpate.Session(palpate.Scene.parse(SCENE.format(more=more)))


def motions(session, ticks):
    """Motion of the handle in the display D, and of the tool goal in the picture C, over some ticks (3,) [m]."""
    a = session.latest()
    R_WC = session.camera.X_WC[:3, :3]
    session.step(ticks)
    b = session.latest()
    return R_DL @ (b["p_LH"] - a["p_LH"]), R_WC.T @ (b["p_WT_goal"] - a["p_WT_goal"])


@pytest.mark.parametrize("more", ["ecm: {}", ROLLED], ids=["automatic", "rolled and tilted"])
def test_the_tool_moves_in_the_picture_as_the_hand_in_front_of_the_display(more):
    session = session_of(more)
    session.step(300)
    for _ in range(3):
        hand_D, tool_C = motions(session, 200)
        assert np.linalg.norm(hand_D) > 1e-3
        np.testing.assert_allclose(tool_C, 0.5 * R_CD @ hand_D, atol=1e-9)


def test_hands_follow_the_picture_after_the_camera_has_rolled():
    session = session_of()
    session.step(400)
    before = session.latest()["p_WT_goal"].copy()
    session.camera.move_to(session.camera.q + [0.2, -0.1, 0.02, 0.7])
    session.step(1)
    assert np.linalg.norm(session.latest()["p_WT_goal"] - before) < 2e-4, "the tool does not jump"
    session.step(50)
    hand_D, tool_C = motions(session, 300)
    assert np.linalg.norm(hand_D) > 1e-3
    np.testing.assert_allclose(tool_C, 0.5 * R_CD @ hand_D, atol=1e-9)


def test_without_follow_picture_the_hands_keep_their_axes():
    session = session_of("ecm: {follow_picture: false}")
    session.step(300)
    hand_D, tool_C = motions(session, 300)
    assert np.linalg.norm(tool_C - 0.5 * R_CD @ hand_D) > 1e-4
    session.camera.move_to(session.camera.q + [0.2, 0, 0, 0.7])
    session.step(1)
    assert not session.controls.quat_WL.any()


def pixel(X_WC, p_W):
    """Direction (2,) in which the camera sees a point: to the right, and up."""
    p = X_WC[:3, :3].T @ (p_W - X_WC[:3, 3])
    return np.array([p[0], -p[1]]) / p[2]


def camera_of(session, n):
    """The camera arm of a session, for n hands whose leaders have their bases at one place."""
    return CameraArm(session.camera.placed, n * [session.rig.arms.X_WL], n * [session])


def moved_by(session, hands0, hands, camera=None):
    """Camera poses before and after hands moved under the camera pedal; positions in the display D."""
    camera = camera or camera_of(session, len(np.atleast_2d(hands0)))
    hands0, hands = (np.atleast_2d(x) @ R_DL for x in (hands0, hands))  # rows of p_LH = R_LD p_D
    before = camera.X_WC
    camera.step(False, hands0, 0.01)
    for s in np.linspace(0.0, 1.0, 101):
        camera.step(True, hands0 + s * (hands - hands0), 0.01)
    return before, camera.X_WC


HANDS = np.array([[-0.1, 0, 0], [0.1, 0, 0.0]])


@pytest.mark.parametrize("more", ["ecm: {}", ROLLED], ids=["automatic", "rolled and tilted"])
@pytest.mark.parametrize("n", [1, 2])
def test_the_picture_goes_where_the_hands_go(more, n):
    """A point in the middle of the picture moves by the angle of the hands; nearer comes nearer."""
    for by in ([0.03, 0, 0], [0, 0.03, 0], [-0.02, 0.02, 0]):
        session = session_of(more)
        first, last = moved_by(session, HANDS[:n], HANDS[:n] + by)
        p_eye = last[:3, 3] + 0.1 * first[:3, 2]  # a direction, so that the motion of the eye itself does not count
        np.testing.assert_allclose(pixel(last, p_eye), np.array(by[:2]) / 0.4, rtol=0.05, atol=4e-3)
    session = session_of(more)
    camera = camera_of(session, n)
    insertion = camera.q[2]
    moved_by(session, HANDS[:n], HANDS[:n] + [0, 0, 0.02], camera)
    assert camera.q[2] == pytest.approx(insertion + 0.02, abs=1e-9)


def test_two_hands_roll_the_picture_counter_clockwise():
    session = session_of()
    c, s = np.cos(0.3), np.sin(0.3)
    first, last = moved_by(session, HANDS, HANDS @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]))
    side = first[:3, 3] + first[:3, :3] @ [0.01, 0, 0.1]  # right of the middle of the picture
    u = pixel(last, side) - pixel(last, first[:3, 3] + 0.1 * first[:3, 2])
    assert np.arctan2(u[1], u[0]) == pytest.approx(0.3, abs=1e-6)
    one = camera_of(session, 1)
    moved_by(session, HANDS[:1], HANDS[:1] + [0.01, 0, 0], one)
    assert one.q[3] == pytest.approx(one.placed.q0[3], abs=1e-3), "one hand does not roll"


def test_speed_and_joint_limits_hold():
    session = session_of()
    camera, arm = camera_of(session, 2), session.camera.placed.ecm.arm
    hands = HANDS @ R_DL
    camera.step(True, hands, 0.01)
    before = camera.q
    camera.step(True, hands + [0.3, 0.2, 0.1], 0.01)  # a leap of the hands
    assert np.all(np.abs(camera.q - before) <= arm.v_max * 0.01 + 1e-12)
    for k in range(300):
        camera.step(True, hands + [0.0, -0.004 * k, 0.0], 0.01)
    assert np.all(camera.q >= arm.q_min)
    assert np.all(camera.q <= arm.q_max)
    rest = camera.q
    camera.step(True, np.full((2, 3), np.nan), 0.01)
    np.testing.assert_array_equal(camera.q, rest)


def test_in_a_session_the_camera_moves_under_its_pedal_alone():
    session = session_of()
    session.step(300)
    rest = session.camera.q
    session.step(300)
    np.testing.assert_array_equal(session.camera.q, rest)
    session.console.press("camera")
    session.step(20)
    assert session.state.session == "camera"
    goal = session.latest()["p_WT_goal"].copy()
    session.step(600)
    assert np.abs(session.camera.q - rest).max() > 1e-3, "the hand goes on along its path"
    np.testing.assert_array_equal(session.latest()["p_WT_goal"], goal)
    session.console.release("camera")
    session.step(1)
    assert session.state.session == "following"
    assert np.linalg.norm(session.latest()["p_WT_goal"] - goal) < 2e-4
    assert isinstance(session.camera, CameraArm)


@pytest.mark.parametrize("recorded", [False, True])
def test_in_lockstep_a_camera_that_rests_takes_no_turns_and_moves_as_with_a_turn_each_period(
    monkeypatch, tmp_path, recorded
):
    def run():
        session = palpate.Session(palpate.Scene.parse(SCENE.format(more=ROLLED)), tmp_path if recorded else None)
        found = []
        pressed, ticks = (False, True, False, True, True, False, True), (405, 205, 25, 201, 19, 333, 90)
        for down, n in zip(pressed, ticks, strict=True):
            session.console.set("camera", down)
            session.step(n)
            found.append(session.camera.q)
        session.close()
        return np.array(found), session.camera.steps, session.record

    moved, turns, record = run()
    monkeypatch.setattr(AttendedLoop, "idle_periods", lambda self, t, period: 0.0)
    expected, all_turns, other = run()
    np.testing.assert_array_equal(moved, expected)
    assert np.ptp(moved, axis=0).max() > 1e-3
    assert turns < all_turns - 50
    if recorded:
        assert record.read_bytes() == other.read_bytes()


def test_a_scene_without_a_camera_arm_has_no_camera():
    session = session_of("")
    assert session.camera is None


def test_record_keeps_the_camera_and_can_be_rebuilt():
    rig = session_of(ROLLED).rig
    again = palpate.Scene.parse(rig.resolved_yaml())
    other = palpate.scene.rig.build(again)
    np.testing.assert_allclose(other.ecm.camera(other.ecm.q0), rig.ecm.camera(rig.ecm.q0), atol=1e-9)
    np.testing.assert_allclose(other.arms.X_WL, rig.arms.X_WL, atol=1e-9)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("ecm: {joints: [0, 0, 0.4, 0]}", r"ecm\.joints: insertion = 0\.4 m is outside its limits"),
        ("ecm: {joints: [0, 2, 0.1, 0]}", r"ecm\.joints: pitch = 2 rad is outside"),
        ("ecm: {base: {xyz: [0, 0, 0.3]}, camera: {xyz: [0, 0, 0.9]}}", "cannot bring its camera to"),
        ("ecm: {camera: {xyz: [0, 0, 0.9]}}", "camera needs base"),
        ("ecm: {joints: [0, 0, 0.1, 0], base: {}, camera: {}}", "joints and camera are given"),
        ("ecm: {endoscope: {tilt_deg: 45}}", "tilt_deg"),
        ("ecm: {endoscope: {baseline: 0.5}}", "baseline"),
    ],
)
def test_wrong_camera_arms_are_refused_with_their_line(more, words):
    with pytest.raises(SceneError, match=words):
        palpate.scene.rig.build(palpate.Scene.parse(SCENE.format(more=more)))


def test_joints_and_views_out_of_reach_are_refused_and_nothing_moves():
    camera = session_of().camera
    rest = camera.q
    for q in ([0, 0, 0.3, 0], [9, 0, 0.1, 0], [0, 0, 0.1], [np.nan, 0, 0.1, 0]):
        with pytest.raises(ArmError, match="cannot take the joints"):
            camera.move_to(q)
    X = camera.X_WC
    X[:3, 3] += [0, 0, 0.5]
    with pytest.raises(ArmError, match="cannot bring its camera"):
        camera.look_from(X)
    np.testing.assert_array_equal(camera.q, rest)
