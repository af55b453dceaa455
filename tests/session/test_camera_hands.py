"""The law by which hands move the picture: by what one sees, and against the simulated dVRK."""
# ruff: noqa: RUF005  (the sums are of arrays)

import numpy as np
import pytest

from palpate.arm.ecm import R_CD, R_DL, follows_picture
from palpate.session.camera_hands import REACH, picture_motion

LEFT, RIGHT = np.array([-0.1, 0.0, 0.0]), np.array([0.1, 0.0, 0.0])
HANDS = np.array([LEFT, RIGHT])


@pytest.mark.parametrize("hands", [HANDS, HANDS[:1]], ids=["two", "one"])
def test_small_motions_by_the_closed_form(hands):
    """Across by x the picture turns by atan(x / REACH); towards the eye by z it comes nearer by z."""
    for x in (-0.05, 0.02):
        angle = np.arctan(x / REACH)
        assert picture_motion(hands, hands + [x, 0, 0])[:2] == pytest.approx((angle, 0.0))
        assert picture_motion(hands, hands + [0, x, 0])[:2] == pytest.approx((0.0, angle))
        assert picture_motion(hands, hands + [0, 0, x]) == pytest.approx((0, 0, x, 0))
    assert picture_motion(hands, hands) == (0, 0, 0, 0)


def test_two_hands_roll_the_picture_and_one_does_not():
    for angle in (-0.4, 0.3):
        c, s = np.cos(angle), np.sin(angle)
        turned = HANDS @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])  # counter-clockwise for the operator
        assert picture_motion(HANDS, turned) == pytest.approx((0, 0, 0, angle))
        one = picture_motion(turned[:1], turned[:1] + [0.01, 0, 0])
        assert one.roll == 0.0
    together = np.zeros((2, 3))
    assert picture_motion(together, together).roll == 0.0, "hands at one place define no direction"


def test_frames_of_hand_display_and_camera():
    for R in (R_DL, R_CD):
        np.testing.assert_allclose(R @ R.T, np.eye(3))
        assert np.linalg.det(R) == pytest.approx(1.0)
    right, up, near = R_DL.T  # rows of R_LD: axes of the display in L of an MTM
    np.testing.assert_array_equal([right, up, near], [[-1, 0, 0], [0, 0, 1], [0, 1, 0]])


@pytest.mark.parametrize("roll", [0.0, 0.5, -2.0])
def test_the_tool_moves_in_the_picture_as_the_hand_in_the_display(roll):
    """Also with a rolled camera."""
    c, s = np.cos(roll), np.sin(roll)
    looks_down = np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1.0]])
    R_WC = looks_down @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    R_WL = follows_picture(R_WC)
    for hand_D, picture_C in (([1, 0, 0], [1, 0, 0]), ([0, 1, 0], [0, -1, 0]), ([0, 0, 1], [0, 0, -1])):
        moved_C = R_WC.T @ R_WL @ (R_DL.T @ hand_D)
        np.testing.assert_allclose(moved_C, picture_C, atol=1e-12)


def test_angles_are_those_of_the_simulated_dvrk():
    """Its camera teleoperation reads measured poses: x left, y up, z away, and the eye at the origin."""
    from palpate.simulators import dvrk

    apart = {"MTMR": np.eye(4), "MTML": np.eye(4)}
    apart["MTMR"][:3, 3], apart["MTML"][:3, 3] = [0.15, 0, 0.5], [-0.15, 0, 0.5]
    robot = dvrk.system(("MTML", "MTMR", "PSM1", "ECM"), base_frames=apart)
    for arm in robot.arms:
        robot.send(arm, "state_command", "home")
    for _ in range(90):
        robot.step(round(0.1 / robot.tick))
        robot.events()
    for topic, value in (("teleop/enable", True), ("emulate_operator_present", 1), ("emulate_camera", 1)):
        robot.send("console", topic, value)

    def hands():
        p = [robot.state(name)["measured_cp"][:3, 3] for name in ("MTML", "MTMR")]
        return np.array(p) * [-1, 1, -1]

    robot.step(round(0.02 / robot.tick))
    q0, first = robot.state("ECM")["setpoint_js"]["position"].copy(), hands()
    start = {name: robot.state(name)["measured_cp"] for name in ("MTML", "MTMR")}
    for k in range(1, 201):  # to the side, up, and with a turn of the line between them
        for name, shift in (("MTML", [0.03, 0.01, 0.05]), ("MTMR", [0.03, 0.03, 0.05])):
            X = start[name].copy()
            X[:3, 3] += np.asarray(shift) * k / 200
            robot.send(name, "hand/servo_cp", X)
        robot.step(round(0.005 / robot.tick))
        robot.events()
    q, motion = robot.state("ECM")["setpoint_js"]["position"], picture_motion(first, hands(), eye=[0, 0, 0])
    assert np.abs(motion).min() > 0.005
    c, s = np.cos(motion.roll + q0[3]), np.sin(motion.roll + q0[3])
    expected = [motion.pan * c - motion.tilt * s, motion.tilt * c + motion.pan * s, motion.insertion, motion.roll]
    np.testing.assert_allclose(q - q0, expected, atol=1e-3)
