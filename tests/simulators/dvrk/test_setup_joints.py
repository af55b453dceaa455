"""Setup joints, the camera's teleoperation as a component, focus motor, clutch button and endoscope type."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

APART = {"MTMR": np.eye(4), "MTML": np.eye(4)}
APART["MTMR"][:3, 3], APART["MTML"][:3, 3] = [0.15, 0, 0.5], [-0.15, 0, 0.5]


def pose(p=(0, 0, 0), axis="z", angle=0.0):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = Rotation.from_euler(axis, angle).as_matrix(), p
    return X


def linkage(q):
    """The motion of the carried base by homogeneous matrices, joint by joint along the chain."""
    return (
        pose((0, 0, q[0]))
        @ pose(angle=q[1])
        @ pose((0.4, 0, 0))
        @ pose(angle=q[2])
        @ pose((0.4, 0, 0))
        @ pose(angle=q[3])
        @ pose(axis="y", angle=q[4])
        @ pose(axis="x", angle=q[5])
        @ pose((-0.8, 0, 0))
    )


@pytest.fixture
def carried(robot):
    frame = pose((0.1, -0.2, 0.3), "y", 0.4)
    r = robot("PSM1", "ECM", base_frames={"PSM1": frame}).home()
    r.send("SUJ/PSM1", "state_command", "home")
    return r, frame


def test_arms_stand_where_their_base_frames_say_until_the_setup_joints_move(carried):
    r, frame = carried
    state = r.state("PSM1")
    assert np.array_equal(state["SUJ/measured_cp"], frame)
    assert np.array_equal(state["SUJ/local/measured_cp"], frame)
    assert np.array_equal(state["SUJ/measured_js"]["position"], np.zeros(6))
    assert np.allclose(state["measured_cp"], frame @ state["local/measured_cp"], atol=1e-12)


@pytest.mark.parametrize("q", [[0.1, 0, 0, 0, 0, 0], [0, 0.5, -0.7, 0, 0, 0], [0.05, -0.3, 0.4, 1.1, 0.6, -0.9]])
def test_setup_joints_carry_the_base(carried, q):
    r, frame = carried
    before = r.state("PSM1")["local/measured_cp"]
    r.send("SUJ/PSM1", "servo_jp", q)
    r.run(0.01)
    state = r.state("PSM1")
    assert np.allclose(state["SUJ/measured_cp"], linkage(q) @ frame, atol=1e-12)
    assert np.allclose(state["measured_cp"], linkage(q) @ frame @ state["local/measured_cp"], atol=1e-12)
    assert np.allclose(state["local/measured_cp"], before, atol=1e-6)
    assert np.array_equal(r.state("ECM")["SUJ/measured_js"]["position"], np.zeros(6)), "the other arm stays"


def test_move_jp_is_busy_until_it_arrives_and_disabled_joints_refuse(carried):
    r, _ = carried
    r.send("SUJ/PSM1", "move_jp", [0.05, 0.1, 0, 0, 0, 0])
    news = r.run(0.05)
    assert ("SUJ/PSM1", "operating_state", ("ENABLED", True, True)) in [e[1:] for e in news]
    news = r.run(5.0)
    assert ("SUJ/PSM1", "operating_state", ("ENABLED", True, False)) in [e[1:] for e in news]
    assert np.allclose(r.state("PSM1")["SUJ/measured_js"]["position"], [0.05, 0.1, 0, 0, 0, 0])
    r.send("SUJ/PSM1", "state_command", "disable")
    r.send("SUJ/PSM1", "move_jp", np.zeros(6))
    assert any("brakes" in words for words in r.messages("warning", r.run(0.05)))
    r.send("SUJ/PSM1", "state_command", "enable")
    r.send("SUJ/PSM1", "servo_jp", [9.0, 0, 0, 0, 0, 0])
    assert any("lift within 0.4 m" in words for words in r.messages("warning", r.run(0.05)))
    r.send("SUJ/PSM1", "state_command", "dance")
    assert any("dance" in words for words in r.messages("warning", r.run(0.05)))


def test_reference_arm_tells_the_poses_in_the_picture_of_the_camera(carried):
    """As sawIntuitiveResearchKit: the base frame of the others is the inverse of the camera's pose on the cart."""
    r, frame = carried
    r.send("SUJ/PSM1", "servo_jp", [0.05, 0.2, 0, 0, 0, 0])
    r.send("SUJ", "set_reference_arm", "ECM")
    for goal in ([0, 0, 0.05, 0], [0.2, -0.1, 0.08, 0.3]):
        r.send("ECM", "move_jp", goal)
        r.run(8.0)
        ecm, psm = r.state("ECM"), r.state("PSM1")
        X_CE = ecm["SUJ/local/measured_cp"] @ ecm["local/measured_cp"]
        expected = np.linalg.inv(X_CE) @ linkage([0.05, 0.2, 0, 0, 0, 0]) @ frame @ psm["local/measured_cp"]
        assert np.allclose(psm["measured_cp"], expected, atol=1e-6)
        assert psm["reference"] == "ECM"
        assert ecm["reference"] == ""
    r.send("SUJ", "set_reference_arm", "Cart")
    r.run(0.01)
    psm = r.state("PSM1")
    assert np.allclose(psm["measured_cp"], linkage([0.05, 0.2, 0, 0, 0, 0]) @ frame @ psm["local/measured_cp"])
    r.send("SUJ", "set_reference_arm", "PSM9")
    assert any("can't find PSM9" in words for words in r.messages("warning", r.run(0.05)))


def test_set_base_frame_counts_until_the_joints_move_and_with_them(carried):
    r, _ = carried
    q, other = [0.1, 0.3, 0, 0, 0.2, 0], pose((0.4, 0.1, 0.0), "x", -0.5)
    r.send("SUJ/PSM1", "servo_jp", q)
    r.send("PSM1", "set_base_frame", other)
    r.run(0.01)
    assert np.allclose(r.state("PSM1")["SUJ/measured_cp"], other, atol=1e-12)
    r.send("SUJ/PSM1", "servo_jp", np.zeros(6))
    r.run(0.01)
    assert np.allclose(r.state("PSM1")["SUJ/measured_cp"], np.linalg.inv(linkage(q)) @ other, atol=1e-12)


def camera(r):
    r.send("console", "teleop/enable", True)
    r.send("console", "emulate_operator_present", 1)
    return r


def last(events, topic, component="MTML_MTMR_ECM"):
    return [e[3] for e in events if e[1:3] == (component, topic)][-1]


def test_camera_teleoperation_reports_its_state_as_a_component(robot):
    r = camera(robot("MTMR", "MTML", "PSM1", "ECM", base_frames=APART).home())
    assert [last(r.events, topic) for topic in ("current_state", "desired_state", "following", "scale")] == [
        "DISABLED", "DISABLED", False, 1.0,
    ]  # fmt: skip
    r.send("console", "emulate_camera", 1)
    news = r.run(0.1)
    assert [e[3] for e in news if e[1:3] == ("MTML_MTMR_ECM", "current_state")] == ["SETTING_ARMS_STATE", "ENABLED"]
    assert last(news, "following") is True
    r.send("console", "emulate_clutch", 1)
    assert last(r.run(0.1), "following") is False
    r.send("console", "emulate_clutch", 0)
    assert last(r.run(0.1), "following") is True
    r.send("console", "emulate_camera", 0)
    news = r.run(0.1)
    assert last(news, "current_state") == "DISABLED"
    assert last(news, "following") is False
    r.send("MTML_MTMR_ECM", "state_command", "align_MTM")
    assert any("enable or disable" in words for words in r.messages("warning", r.run(0.05)))


def test_camera_teleoperation_waits_for_an_arm_that_is_lost(robot):
    r = camera(robot("MTMR", "MTML", "ECM", base_frames=APART).home())
    r.send("console", "emulate_camera", 1)
    r.run(0.1)
    r.send("ECM", "state_command", "disable")
    news = r.run(0.1)
    assert last(news, "current_state") == "SETTING_ARMS_STATE"
    assert last(news, "following") is False
    assert any("ECM is not enabled and homed any more" in words for words in r.messages("warning", news))


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_scale_of_the_camera_teleoperation_scales_the_insertion(robot, scale):
    r = camera(robot("MTMR", "MTML", "ECM", base_frames=APART).home())
    r.send("ECM", "move_jp", [0, 0, 0.1, 0])
    r.run(6.0)
    r.send("MTML_MTMR_ECM", "set_scale", scale)
    r.send("console", "emulate_camera", 1)
    assert last(r.run(0.1), "scale") == scale
    before = r.state("ECM")["setpoint_js"]["position"][2]
    poses = {arm: r.state(arm)["measured_cp"] for arm in ("MTMR", "MTML")}
    middle = np.mean([X[:3, 3] for X in poses.values()], axis=0)
    for k in range(200):  # both hands towards the origin
        for arm, X in poses.items():
            goal = X.copy()
            goal[:3, 3] -= 0.02 * k / 200 * middle / np.linalg.norm(middle)
            r.send(arm, "hand/servo_cp", goal)
        r.run(0.005)
    came = np.mean([r.state(arm)["measured_cp"][:3, 3] for arm in poses], axis=0)
    nearer = np.linalg.norm(middle) - np.linalg.norm(came)
    assert nearer > 0.005
    inserted = r.state("ECM")["setpoint_js"]["position"][2] - before
    assert inserted == pytest.approx(scale * nearer, rel=0.05, abs=2e-4)
    for wrong in (0.0, -1.0, math.inf, math.nan):
        r.send("MTML_MTMR_ECM", "set_scale", wrong)
        assert r.messages("warning", r.run(0.01))


def test_focus_moves_one_way_at_a_time_and_not_while_locked(robot):
    r = robot("ECM")
    r.run(0.01)
    r.send("endoscope_focus", "focus_in", True)
    r.send("endoscope_focus", "focus_out", True)
    news = [e[2:] for e in r.run(0.01) if e[1] == "endoscope_focus"]
    assert news == [("focusing_in", True)]
    r.send("endoscope_focus", "lock", True)
    news = [e[2:] for e in r.run(0.01) if e[1] == "endoscope_focus"]
    assert news == [("focusing_in", False), ("locked", True)]
    r.send("endoscope_focus", "focus_out", True)
    assert not [e for e in r.run(0.01) if e[1] == "endoscope_focus"]
    r.send("endoscope_focus", "lock", False)
    r.send("footpedals", "emulate_cam_minus", 1)
    r.run(0.01)
    r.send("footpedals", "emulate_cam_minus", 0)
    r.run(0.01)
    assert [e[3] for e in r.events if e[1:3] == ("endoscope_focus", "focusing_out")] == [False, True, False]


def test_endoscope_type_is_told_and_an_unknown_one_is_refused(robot):
    r = robot("ECM")
    r.run(0.01)
    r.send("ECM", "set_endoscope_type", "SD_UP")
    r.send("ECM", "set_endoscope_type", "8K")
    r.run(0.01)
    assert [e[3] for e in r.events if e[2] == "endoscope_type"] == ["HD_STRAIGHT", "SD_UP"]
    assert any("8K" in words for words in r.messages("error"))


@pytest.mark.parametrize("arm", ["PSM1", "ECM"])
def test_clutch_button_of_an_arm_frees_it_and_its_release_holds_it(robot, arm):
    r = robot(arm).home()
    r.send(arm, "emulate_arm_clutch", 1)
    news = r.run(0.1)
    assert [e[3] for e in news if e[2] == "arm_clutch"] == [1]
    assert any("arm clutch pressed" in words for words in r.messages("status", news))
    there = r.state(arm)["measured_js"]["position"]
    r.send(arm, "emulate_arm_clutch", 0)
    assert [e[3] for e in r.run(0.5) if e[2] == "arm_clutch"] == [0]
    assert np.allclose(r.state(arm)["setpoint_js"]["position"], there, atol=2e-3)
    assert r.state(arm)["state"] == "ENABLED"


def test_clutch_button_lets_a_person_move_a_driven_arm(robot):
    r = robot("PSM1", driven=True).home()
    start = r.state("PSM1")["measured_js"]["position"]

    def push():
        r.send("PSM1", "tool/servo_cf", [0.0, 1.5, 0, 0, 0, 0])
        r.run(0.5)
        r.send("PSM1", "tool/servo_cf", np.zeros(6))
        r.run(0.2)
        return np.abs(r.state("PSM1")["measured_js"]["position"] - start).max()

    held = push()
    r.send("PSM1", "emulate_arm_clutch", 1)
    assert push() > 5.0 * max(held, 1e-3)
    r.send("PSM1", "emulate_arm_clutch", 0)
    r.run(0.2)
    there = r.state("PSM1")["measured_js"]["position"]
    r.run(0.5)
    assert np.allclose(r.state("PSM1")["measured_js"]["position"], there, atol=2e-3)
