"""Positions: moves, servo commands, inverse kinematics, cannula, jaw, tools, and rejected commands."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import palpate


def angle(A, B):
    return Rotation.from_matrix(A[:3, :3].T @ B[:3, :3]).magnitude()


GOALS = {
    "MTMR": [0.2, 0.3, 0.1, -0.4, 1.2, 0.3, 0.5],
    "PSM1": [0.3, -0.2, 0.15, 0.5, 0.4, -0.3],
    "ECM": [0.2, -0.1, 0.15, 0.3],
}


@pytest.mark.parametrize(("arm", "goal"), GOALS.items())
def test_move_jp_arrives_reports_it_and_is_busy_during_the_motion(robot, arm, goal):
    r = robot(arm).home()
    r.events.clear()
    r.send(arm, "move_jp", goal)
    r.run(0.1)
    assert r.state(arm)["is_busy"]
    r.run(6.0)
    s = r.state(arm)
    assert not s["is_busy"]
    assert [e[3] for e in r.events if e[2] == "goal_reached"] == [True]
    assert np.allclose(s["setpoint_js"]["position"], goal)
    assert np.abs(s["measured_js"]["position"] - goal).max() < 0.02


def test_ratios_scale_the_speed_and_are_published(robot):
    taken = {}
    for ratio in (1.0, 0.5):
        r = robot("PSM1").home()
        r.send("PSM1", "trajectory_j/set_ratio", ratio)
        r.send("PSM1", "move_jp", [0.8, 0, 0.12, 0, 0, 0])
        while r.system.t < 20 and not any(e[2] == "goal_reached" for e in r.events):
            r.run(0.01)
        [taken[ratio]] = [e[0] for e in r.events if e[2] == "goal_reached"]
        assert [e[3] for e in r.events if e[2] == "trajectory_j/ratio_a"][-1] == ratio
    a = np.radians(90)
    assert abs(taken[0.5] - taken[1.0] - (2 * np.sqrt(0.8 / (0.5 * a)) - 2 * np.sqrt(0.8 / a))) < 0.01
    r.send("PSM1", "trajectory_j/set_ratio_v", 1.0)
    r.run(0.01)
    assert [e[3] for e in r.events if e[2] == "trajectory_j/ratio"][-1] == 0.0  # velocity and acceleration differ
    r.send("PSM1", "trajectory_j/set_ratio", 1.5)
    r.run(0.01)
    assert "ratio must be within ]0;1], received 1.5" in r.messages("warning")[-1]


def test_interrupted_move_reports_a_missed_goal(robot):
    r = robot("PSM1").home()
    r.send("PSM1", "move_jp", [0.8, 0, 0.12, 0, 0, 0])
    r.run(0.3)
    r.events.clear()
    r.send("PSM1", "hold")
    r.run(0.5)
    assert [e[3] for e in r.events if e[2] == "goal_reached"] == [False]
    assert not r.state("PSM1")["is_busy"]
    assert np.abs(r.state("PSM1")["measured_js"]["velocity"]).max() < 1e-3


def test_move_cp_and_relative_moves(robot):
    r = robot("PSM1").home()
    X = r.state("PSM1")["measured_cp"]
    X[:3, :3] = Rotation.from_rotvec([0.2, -0.3, 0.6]).as_matrix() @ X[:3, :3]
    X[:3, 3] += [0.02, -0.01, -0.03]
    r.send("PSM1", "move_cp", X)
    r.run(3.0)
    assert np.linalg.norm(r.state("PSM1")["measured_cp"][:3, 3] - X[:3, 3]) < 1e-4
    assert angle(r.state("PSM1")["measured_cp"], X) < 1e-3
    q = r.state("PSM1")["setpoint_js"]["position"]
    step = np.array([0.02, 0.01, 0.005, 0.1, 0, 0])
    r.send("PSM1", "move_jr", step)
    r.run(2.0)
    r.send("PSM1", "servo_jr", -step / 2)
    r.run(0.5)
    assert np.allclose(r.state("PSM1")["setpoint_js"]["position"], q + step / 2, atol=1e-9)
    X = r.state("PSM1")["setpoint_cp"]
    D = np.eye(4)
    D[:3, 3] = [0.001, 0, 0.001]
    r.send("PSM1", "servo_cr", D)
    r.run(0.3)
    assert np.allclose(r.state("PSM1")["measured_cp"][:3, 3], X[:3, 3] + D[:3, 3], atol=1e-4)


def test_servo_cp_follows_a_path(robot):
    r = robot("PSM1").home()
    X0 = r.state("PSM1")["setpoint_cp"]
    for k in range(300):
        X = X0.copy()
        X[:3, 3] += 0.02 * np.array([np.sin(k / 50), 0, np.cos(k / 50) - 1])
        r.send("PSM1", "servo_cp", X)
        r.run(0.003)
        assert np.linalg.norm(r.state("PSM1")["setpoint_cp"][:3, 3] - X[:3, 3]) < 1e-5
    assert not r.messages("error")
    lag = 2 / (2 * np.pi * 30) * 0.02 / (50 * 0.003)  # lag of a critically damped servo of 30 Hz at this speed
    assert np.linalg.norm(r.state("PSM1")["measured_cp"][:3, 3] - X[:3, 3]) < 1.2 * lag


def test_unreachable_goals_are_reported_and_give_no_motion(robot):
    r = robot("PSM1").home()
    X = r.state("PSM1")["measured_cp"]
    X[:3, 3] = [1.0, 0, 0]
    for verb in ("move_cp", "servo_cp"):
        r.send("PSM1", verb, X)
        r.run(0.3)
        assert "unable to solve inverse kinematics" in r.messages("error")[-1]
    assert np.allclose(r.state("PSM1")["measured_js"]["position"], [0, 0, 0.12, 0, 0, 0], atol=1e-3)
    assert [e[3] for e in r.events if e[2] == "goal_reached"][-1] is False


@pytest.mark.parametrize("arm", ["MTMR", "MTML", "PSM1"])
def test_inverse_kinematics_of_random_poses(robot, arm):
    """Poses of random joints in the middle of the range, solved from the home pose."""
    r = robot(arm)
    model = palpate.Arm.psm("lnd") if arm == "PSM1" else palpate.Arm.mtm("right" if arm == "MTMR" else "left")
    middle, half = 0.5 * (model.q_min + model.q_max), 0.4 * (model.q_max - model.q_min)
    found = 0
    for u in np.random.default_rng(1).uniform(-1, 1, (40, model.n)):
        X = r.system.forward_kinematics(arm, middle + half * u)
        q = r.system.inverse_kinematics(arm, X, model.home)
        if q is None:
            continue
        found += 1
        assert (q >= model.q_min).all()
        assert (q <= model.q_max).all()
        assert np.abs(r.system.forward_kinematics(arm, q) - X).max() < 1e-4
    assert found >= 36
    assert r.system.forward_kinematics(arm, np.zeros(3)) is None
    assert r.system.inverse_kinematics(arm, X, np.zeros(3)) is None


def test_cartesian_control_needs_the_tool_past_the_cannula(robot):
    r = robot("PSM1").home()
    r.send("PSM1", "move_jp", [0, 0, 0.05, 0, 0, 0])
    r.run(3.0)
    X = r.state("PSM1")["measured_cp"]
    r.send("PSM1", "move_cp", X)
    r.run(0.1)
    assert "inserted past the cannula" in r.messages("warning")[-1]
    r.send("PSM1", "move_jp", [0, 0, 0.07, 0, 0, 0])
    r.run(3.0)
    r.events.clear()
    X[2, 3] -= 0.025
    r.send("PSM1", "move_cp", X)
    r.run(3.0)
    assert not r.messages("warning")
    assert [e[3] for e in r.events if e[2] == "goal_reached"] == [True]


def test_jaw_accepts_servo_move_and_effort_commands(robot):
    r = robot("PSM1").home()
    r.send("PSM1", "jaw/servo_jp", [0.8])
    r.run(0.2)
    assert abs(r.state("PSM1")["jaw/measured_js"]["position"][0] - 0.8) < 1e-6
    r.events.clear()
    r.send("PSM1", "jaw/move_jp", [0.1])
    r.run(0.1)
    assert r.state("PSM1")["is_busy"]
    r.run(1.0)
    assert [e[3] for e in r.events if e[2] == "goal_reached"] == [True]
    assert abs(r.state("PSM1")["jaw/measured_js"]["position"][0] - 0.1) < 1e-6
    r.send("PSM1", "jaw/servo_jf", [-0.1])
    r.run(0.5)
    jaw = r.state("PSM1")["jaw/measured_js"]
    assert jaw["effort"][0] == -0.1
    assert jaw["position"][0] < 0  # below zero: the jaw closes more tightly
    r.send("PSM1", "jaw/servo_jp", [99.0])
    r.run(0.5)
    assert abs(r.state("PSM1")["jaw/measured_js"]["position"][0] - palpate.Arm.psm("lnd").jaw_range[1]) < 1e-6


def test_arm_without_a_tool_has_no_tip_pose(robot):
    r = robot("PSM1").home()
    assert [e[3] for e in r.events if e[2] == "tool_type"][-1].startswith("LARGE_NEEDLE_DRIVER")
    r.send("PSM1", "emulate_tool_present", False)
    r.run(0.1)
    assert not r.state("PSM1")["cartesian_valid"]
    assert r.state("PSM1")["joints_valid"]
    r.send("PSM1", "move_cp", np.diag([1.0, 1, 1, 1]))
    r.run(0.1)
    assert "move_cp, arm not ready" in r.messages("warning")[-1]
    r.send("PSM1", "emulate_tool_present", True)
    r.run(0.1)
    assert r.state("PSM1")["cartesian_valid"]


def test_velocities_are_those_of_finite_differences_in_their_frames(robot):
    """measured_cv is in the base frame, local/measured_cv in the tip frame, as on the real robot."""
    frame = np.eye(4)
    frame[:3, :3] = Rotation.from_rotvec([0.3, 0.5, -0.2]).as_matrix()
    r = robot("PSM1", base_frames={"PSM1": frame}).home()
    r.send("PSM1", "move_jp", [0.6, 0.4, 0.2, 1.0, 0.5, -0.5])
    r.run(0.3)
    before = r.state("PSM1")
    r.run(0.002)
    now = r.state("PSM1")
    r.run(0.002)
    after = r.state("PSM1")
    dt = after["t"] - before["t"]
    v = (after["measured_cp"][:3, 3] - before["measured_cp"][:3, 3]) / dt
    w = Rotation.from_matrix(after["measured_cp"][:3, :3] @ before["measured_cp"][:3, :3].T).as_rotvec() / dt
    V = now["measured_cv"]
    assert np.linalg.norm(V[:3] - v) < 0.02 * np.linalg.norm(v)
    assert np.linalg.norm(V[3:] - w) < 0.02 * np.linalg.norm(w)
    R = now["measured_cp"][:3, :3].T
    assert np.allclose(now["local/measured_cv"], np.concatenate([R @ V[:3], R @ V[3:]]))


def test_invalid_numbers_are_reported_and_have_no_effect(robot):
    r = robot("PSM1", "MTMR").home()
    q = r.state("PSM1")["setpoint_js"]["position"]
    twisted = np.eye(4)
    twisted[0, 0] = 2.0
    for verb, value in (("servo_jp", [1.0, 2.0]), ("servo_jp", [np.nan] * 6), ("move_jp", np.zeros(9)),
                        ("servo_cp", np.full((4, 4), np.inf)), ("move_cp", twisted), ("jaw/servo_jp", [])):  # fmt: skip
        r.events.clear()
        r.send("PSM1", verb, value)
        r.run(0.01)
        assert f"PSM1: {verb} refused: it needs" in r.messages("warning")[0]
    r.send("MTMR", "body/servo_cf", [np.nan, 0, 0, 0, 0, 0])
    r.run(0.01)
    assert "MTMR: body/servo_cf refused" in r.messages("warning")[-1]
    assert np.array_equal(r.state("PSM1")["setpoint_js"]["position"], q)


def test_psm_with_drives_is_moved_by_contact_forces(robot):
    """A PSM with simulated drives: a contact of 2 N moves the tip a little and appears in the torques."""
    r = robot("PSM1", driven=True).home()
    X = r.state("PSM1")["measured_cp"]
    r.send("PSM1", "tool/servo_cf", [0, 0, 2.0, 0, 0, 0])
    r.run(1.0)
    s = r.state("PSM1")
    up = s["measured_cp"][2, 3] - X[2, 3]
    assert 0 <= up < 2 * 2.0 / 6000.0
    moved = s["measured_js"]["effort"][2]
    r.send("PSM1", "tool/servo_cf", np.zeros(6))
    r.run(1.0)
    assert abs(abs(moved - r.state("PSM1")["measured_js"]["effort"][2]) - 2.0) < 1.0  # friction: 0.45 N


def test_unknown_names_are_reported(robot):
    r = robot("PSM1")
    with pytest.raises(ValueError, match="no component 'PSM9'; its components are system, console, footpedals, PSM1"):
        r.send("PSM9", "hold")
    with pytest.raises(ValueError, match="PSM1 has no command 'lock_orientation'"):
        r.send("PSM1", "lock_orientation", np.eye(3))
    with pytest.raises(palpate.base.errors.ArmError, match="no arm 'PSM9'"):
        robot("PSM9")
    with pytest.raises(palpate.base.errors.ArmError, match="named 2 times"):
        robot("PSM1", "PSM1")
