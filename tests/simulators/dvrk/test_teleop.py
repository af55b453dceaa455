"""Teleoperation and console: conditions of following, and continuity of the motion."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation


def rotation(X):
    return X[:3, :3]


def angle(A, B):
    return Rotation.from_matrix(A.T @ B).magnitude()


@pytest.fixture
def console(robot):
    """MTMR and PSM1 homed, an operator present, teleoperation enabled, and a hand at the MTM."""
    r = robot("MTMR", "PSM1").home()
    r.send("console", "teleop/enable", True)
    r.send("console", "emulate_operator_present", 1)
    r.run(5.1)  # time for the alignment, until the operator is requested
    return r


@pytest.fixture
def following(console):
    """The hand holds the handle and has closed the gripper, so the PSM follows."""
    take(console)
    pinch(console)
    assert console.teleop("MTMR_PSM1")["following"]
    console.run(3.5)  # time for the jaw to catch up
    return console


def take(r):
    r.send("MTMR", "hand/servo_cp", r.state("MTMR")["measured_cp"])


def pinch(r):
    for gripper in (1.0, 0.1, 0.5):
        r.send("MTMR", "hand/gripper", gripper)
        r.run(0.05)


def lead(r, p, seconds, turn=(0.0, 0.0, 0.0)):
    """Move the hand smoothly to p with a rotation; returns the largest step of the PSM's setpoint in 1 ms [m]."""
    X = r.state("MTMR")["measured_cp"]
    start, R = X[:3, 3].copy(), rotation(X).copy()
    largest, before = 0.0, r.state("PSM1")["setpoint_cp"]
    n = int(seconds / 0.002)
    for k in range(1, n + 1):
        s = 0.5 - 0.5 * np.cos(np.pi * k / n)
        X[:3, 3] = start + s * (np.asarray(p) - start)
        X[:3, :3] = Rotation.from_rotvec(s * np.asarray(turn)).as_matrix() @ R
        r.send("MTMR", "hand/servo_cp", X)
        r.run(0.002)
        now = r.state("PSM1")["setpoint_cp"]
        largest = max(largest, np.linalg.norm(now[:3, 3] - before[:3, 3]))
        before = now
    return largest


def test_states_before_following(console):
    """Alignment is automatic; the operator has to close the gripper."""
    states = [e[3] for e in console.events if e[1:3] == ("MTMR_PSM1", "current_state")]
    assert states == ["DISABLED", "SETTING_ARMS_STATE", "ALIGNING_MTM"]
    assert angle(rotation(console.state("MTMR")["measured_cp"]), rotation(console.state("PSM1")["setpoint_cp"])) < 0.087
    assert "MTMR_PSM1: pinch/twist MTM gripper a bit" in console.messages("warning")
    take(console)
    pinch(console)
    assert console.teleop("MTMR_PSM1")["current_state"] == "ENABLED"
    assert [e[3] for e in console.events if e[2] == "following"] == [False, True]


def test_psm_follows_with_scale_and_orientation(following):
    r = following
    mtm, psm = r.state("MTMR")["measured_cp"], r.state("PSM1")["setpoint_cp"]
    jump = lead(r, mtm[:3, 3] + [0.05, 0.02, 0.03], 1.0, turn=(0.1, 0.2, -0.2))
    r.run(0.3)
    moved = r.state("MTMR")["measured_cp"][:3, 3] - mtm[:3, 3]
    assert np.linalg.norm(moved) > 0.04
    assert np.allclose(r.state("PSM1")["setpoint_cp"][:3, 3] - psm[:3, 3], 0.2 * moved, atol=2e-5)
    turned = rotation(r.state("MTMR")["measured_cp"]) @ rotation(mtm).T
    assert angle(rotation(r.state("PSM1")["setpoint_cp"]), turned @ rotation(psm)) < 0.005
    assert jump < 0.2 * 0.3 * 0.003


def test_motion_beyond_the_wrist_limits_and_back(following):
    """Beyond 90 degrees the PSM's wrist flips at the speed of its joints without a fault, and returns."""
    r = following
    X = r.state("MTMR")["measured_cp"]
    R, before, largest = rotation(X).copy(), r.state("PSM1")["setpoint_js"]["position"], 0.0
    for k in range(401):
        turn = np.radians(105) * np.sin(np.pi * k / 400)
        X[:3, :3] = Rotation.from_rotvec([turn, 0, 0]).as_matrix() @ R
        r.send("MTMR", "hand/servo_cp", X)
        r.run(0.01)
        now = r.state("PSM1")["setpoint_js"]["position"]
        largest, before = max(largest, np.abs(now - before).max()), now
    assert 0.1 < largest < 12 * 0.0107
    r.run(0.5)
    assert r.teleop("MTMR_PSM1")["following"]
    assert not r.messages("error")
    assert angle(rotation(r.state("PSM1")["setpoint_cp"]), rotation(r.state("MTMR")["measured_cp"])) < 0.05


def test_engaging_clutching_and_scaling_never_jump(following):
    """Around a transition the PSM's setpoint moves at most as far as the hand."""
    r = following
    p_MTM = r.state("MTMR")["measured_cp"][:3, 3]
    lead(r, p_MTM + np.array([0.0, 0.02, 0.0]), 0.5)
    psm = r.state("PSM1")["setpoint_cp"]
    r.send("console", "emulate_clutch", 1)
    r.run(0.05)
    assert not r.teleop("MTMR_PSM1")["following"]
    assert r.state("MTMR")["orientation_locked"]
    lead(r, p_MTM + np.array([0.03, -0.02, 0.02]), 0.6)  # the hand moves, the PSM does not
    assert np.linalg.norm(r.state("PSM1")["setpoint_cp"][:3, 3] - psm[:3, 3]) < 1e-3
    psm = r.state("PSM1")["setpoint_cp"]
    r.send("console", "emulate_clutch", 0)
    r.run(1.0)
    assert r.teleop("MTMR_PSM1")["following"]
    assert np.linalg.norm(r.state("PSM1")["setpoint_cp"][:3, 3] - psm[:3, 3]) < 1e-3
    assert angle(rotation(r.state("PSM1")["setpoint_cp"]), rotation(psm)) < 0.09
    for scale in (0.5, 0.05, 1.0):
        before = r.state("PSM1")["setpoint_cp"]
        r.send("console", "teleop/set_scale", scale)
        r.run(0.01)
        assert np.linalg.norm(r.state("PSM1")["setpoint_cp"][:3, 3] - before[:3, 3]) < 2e-4
    assert r.teleop("MTMR_PSM1")["scale"] == 1.0
    r.send("MTMR_PSM1", "set_scale", -1.0)
    r.run(0.01)
    assert "scale must be above 0" in r.messages("warning")[-1]


def test_jaw_catches_up_slowly_and_then_follows_fast(console):
    """The jaw moves at 0.2 pi rad/s until it has caught up, then at 4 pi rad/s."""
    r = console
    assert abs(r.state("PSM1")["jaw/measured_js"]["position"][0]) < 1e-9
    take(r)
    pinch(r)
    scale = 1.396 / (np.pi / 3)

    def speed(seconds):
        before = r.state("PSM1")["jaw/setpoint_js"]["position"][0]
        r.run(seconds)
        return abs(r.state("PSM1")["jaw/setpoint_js"]["position"][0] - before) / seconds / scale

    assert abs(speed(0.3) - 0.2 * np.pi) < 0.02
    r.run(2.0)
    assert abs(r.state("PSM1")["jaw/measured_js"]["position"][0] - scale * 0.5) < 1e-3
    r.send("MTMR", "hand/gripper", 0.0)
    assert abs(speed(0.03) - 4 * np.pi) < 0.7
    r.run(0.5)
    assert abs(r.state("PSM1")["jaw/measured_js"]["position"][0]) < 1e-3
    assert ("MTMR", "gripper/pinch") in [e[1:3] for e in r.events]


def test_teleoperation_wrench_has_no_timeout_and_ends_at_a_transition(following):
    r = following
    push = [0.0, 0.0, 0.4, 0.0, 0.0, 0.0]

    def felt():
        s = r.state("MTMR")
        tau = s["measured_js"]["effort"] - s["gravity_compensation/setpoint_js"]
        return np.linalg.lstsq(s["body/jacobian"][:3, :3].T, tau[:3], rcond=None)[0][2]

    r.send("MTMR_PSM1", "following/mtm/body/servo_cf", push)
    r.run(0.01)
    assert abs(felt() - 0.4) < 0.05
    r.run(3.0)  # without further wrenches
    assert abs(felt() - 0.4) < 0.05
    r.send("console", "emulate_clutch", 1)
    r.run(0.01)
    assert abs(felt()) < 0.05
    r.send("MTMR_PSM1", "following/mtm/body/servo_cf", push)  # dropped at the next transition
    r.run(0.01)
    assert abs(felt()) < 0.05
    r.send("console", "emulate_clutch", 0)
    r.run(1.0)
    assert r.teleop("MTMR_PSM1")["following"]
    assert abs(felt()) < 0.05
    r.send("MTMR_PSM1", "following/mtm/body/servo_cf", [np.nan] * 6)
    r.run(0.01)
    assert "refused" in r.messages("warning")[-1]
    assert abs(felt()) < 0.05


def test_rotation_and_translation_locks(following):
    r = following
    p_MTM = r.state("MTMR")["measured_cp"][:3, 3]
    r.send("MTMR_PSM1", "lock_translation", True)
    r.run(0.01)
    psm = r.state("PSM1")["setpoint_cp"]
    lead(r, p_MTM + np.array([0.03, 0, 0]), 0.5)
    assert np.linalg.norm(r.state("PSM1")["setpoint_cp"][:3, 3] - psm[:3, 3]) < 1e-6
    r.send("MTMR_PSM1", "lock_translation", False)
    r.send("MTMR_PSM1", "lock_rotation", True)
    r.run(0.01)
    assert r.state("MTMR")["orientation_locked"]
    psm = r.state("PSM1")["setpoint_cp"]
    lead(r, p_MTM, 0.5)
    assert angle(rotation(r.state("PSM1")["setpoint_cp"]), rotation(psm)) < 1e-5
    assert np.linalg.norm(r.state("PSM1")["setpoint_cp"][:3, 3] - psm[:3, 3]) > 0.004
    r.send("MTMR_PSM1", "lock_rotation", False)  # the MTM may be misaligned now, so it is aligned again
    r.run(0.002)
    assert not r.teleop("MTMR_PSM1")["following"]
    assert {e[2] for e in r.events} >= {"rotation_locked", "translation_locked"}


def test_offset_is_constant_without_alignment(robot):
    r = robot("MTMR", "PSM1").home()
    r.send("MTMR_PSM1", "set_align_MTM", False)
    r.send("MTMR_PSM1", "state_command", "enable")
    r.run(0.5)
    take(r)
    pinch(r)
    assert r.teleop("MTMR_PSM1")["following"]
    R = r.teleop("MTMR_PSM1")["alignment_offset"]
    assert angle(np.eye(3), R) > 0.5
    mtm, psm = r.state("MTMR")["measured_cp"], r.state("PSM1")["setpoint_cp"]
    assert angle(rotation(mtm) @ R, rotation(psm)) < 0.02


def test_fault_of_an_arm_stops_the_teleoperation(following):
    r = following
    r.send("PSM1", "emulate_fault", "power lost")
    r.run(0.01)
    assert r.teleop("MTMR_PSM1")["current_state"] == "DISABLED"
    assert not r.teleop("MTMR_PSM1")["following"]
    assert any("received from arm [PSM1: power lost]" in w for w in r.messages("error"))


def test_mtm_stays_aligned_when_the_operator_leaves(following):
    r = following
    r.send("console", "emulate_operator_present", 0)
    r.run(0.01)
    assert not r.teleop("MTMR_PSM1")["following"]
    assert r.teleop("MTMR_PSM1")["current_state"] == "ALIGNING_MTM"
    r.send("console", "teleop/enable", False)
    r.run(0.1)
    assert r.teleop("MTMR_PSM1")["current_state"] == "DISABLED"


def test_unselected_teleoperations_do_not_run(console):
    r = console
    r.send("console", "teleop/unselect", "MTMR_PSM1")
    r.run(0.1)
    assert r.teleop("MTMR_PSM1")["current_state"] == "DISABLED"
    r.send("console", "teleop/select", "MTMR_PSM1")
    r.run(0.1)
    assert r.teleop("MTMR_PSM1")["current_state"] == "ALIGNING_MTM"
    r.send("console", "teleop/select", "MTMX_PSM1")
    r.run(0.01)
    assert "can't find MTMX_PSM1" in r.messages("warning")[-1]
    assert [e[3] for e in r.events if e[2] == "teleop/unselected"][-1] == "MTMR_PSM1"


def test_pedals_distinguish_presses_and_taps(robot):
    r = robot("MTMR", "PSM1")

    def published(topic, component):
        return [e[3] for e in r.events if e[1:3] == (component, topic)]

    r.send("footpedals", "emulate_clutch", 1)
    r.run(0.1)
    assert published("clutch", "footpedals") == []  # press or tap is not decided yet
    r.send("footpedals", "emulate_clutch", 0)
    r.run(0.1)
    assert published("clutch", "footpedals") == [2]
    r.send("footpedals", "emulate_clutch", 1)
    r.run(0.3)
    r.send("footpedals", "emulate_clutch", 0)
    r.send("footpedals", "emulate_coag", 1)
    r.run(0.01)
    assert published("clutch", "footpedals") == [2, 1, 0]
    assert published("clutch", "console") == [2, 1, 0]
    assert published("operator_present", "console") == [1]  # the coag pedal is the operator's presence


def test_unknown_teleoperation_commands_are_reported(robot):
    r = robot("MTMR", "PSM1")
    r.send("MTMR_PSM1", "state_command", "align_mtm")
    r.run(0.01)
    assert (
        "align_mtm doesn't seem to be a valid state_command (enable, disable or align_MTM)" in r.messages("warning")[0]
    )


def test_camera_pedal_moves_the_endoscope_with_both_hands(robot):
    apart = {"MTMR": np.eye(4), "MTML": np.eye(4)}
    apart["MTMR"][:3, 3], apart["MTML"][:3, 3] = [0.15, 0, 0.5], [-0.15, 0, 0.5]
    r = robot("MTMR", "MTML", "PSM1", "ECM", base_frames=apart).home()
    r.send("console", "teleop/enable", True)
    r.send("console", "emulate_operator_present", 1)
    r.send("console", "emulate_camera", 1)
    r.run(0.1)
    assert r.teleop("MTMR_PSM1")["current_state"] == "DISABLED"
    poses = {arm: r.state(arm)["measured_cp"] for arm in ("MTMR", "MTML")}
    for k in range(200):  # both hands move to the right
        for arm, X in poses.items():
            goal = X.copy()
            goal[0, 3] += 0.05 * k / 200
            r.send(arm, "hand/servo_cp", goal)
        r.run(0.005)
    assert abs(r.state("ECM")["measured_js"]["position"][0]) > 0.05
    distance = r.state("MTMR")["measured_cp"][:3, 3] - r.state("MTML")["measured_cp"][:3, 3]
    assert abs(np.linalg.norm(distance) - 0.3) < 0.03
    r.send("console", "emulate_camera", 0)
    r.run(0.5)
    assert r.teleop("MTMR_PSM1")["current_state"] == "ALIGNING_MTM"
