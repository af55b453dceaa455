"""Wrenches and torques on an MTM, against MuJoCo, Jacobians by finite differences and pseudoinverses."""

from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

import palpate
from palpate.arm import models_folder
from palpate.simulators import dvrk

TILTED = np.array([[0.8, -0.6, 0, 0.1], [0.6, 0.8, 0, -0.2], [0, 0, 1, 0.3], [0, 0, 0, 1.0]])
PUSH = np.array([1.0, -0.5, 0.8, 0.01, 0.02, -0.005])


def frictionless(name="MTMR"):
    """A system with ideal encoders, without friction and without the platform controller."""
    spec = dvrk.arm(name)
    options = spec.leader
    options.coulomb = options.viscous = np.zeros(7)
    options.quantised = False
    spec.leader = options
    spec.platform_gain = 0.0
    return spec


@pytest.fixture
def homed(robot):
    return robot("MTMR", base_frames={"MTMR": TILTED}).home()


def in_tip_axes(state, F):
    R = state["measured_cp"][:3, :3].T
    return np.concatenate([R @ F[:3], R @ F[3:]])


def applied(state):
    """Torques minus the gravity compensation [N m]."""
    return state["measured_js"]["effort"] - state["gravity_compensation/setpoint_js"]


def twin():
    """The MTM in MuJoCo: the same URDF with drawn joints welded, and the rotor inertia."""
    arm = palpate.Arm.mtm("right")
    xml = ElementTree.fromstring((models_folder() / "mtm_right.urdf").read_text())
    for joint in xml.findall("joint"):
        if joint.get("name") not in arm.joint_names:
            joint.set("type", "fixed")
            for tag in ("limit", "mimic", "axis"):
                for element in joint.findall(tag):
                    joint.remove(element)
    ElementTree.SubElement(ElementTree.SubElement(xml, "mujoco"), "compiler", fusestatic="false")
    model = mujoco.MjModel.from_xml_string(ElementTree.tostring(xml, encoding="unicode"))
    model.dof_armature[:] = arm.leader_options().rotor_inertia
    return model, mujoco.MjData(model)


@pytest.mark.parametrize("F", [PUSH, [0, 2.0, 0, 0, 0, 0], [0, 0, 0, 0, 0.03, 0]], ids=["all", "force", "torque"])
def test_acceleration_by_a_wrench_agrees_with_mujoco(robot, F):
    """With gravity and spring compensated M a = J^T F, in base axes, for a few milliseconds without much rotation."""
    r = robot(frictionless()).home()
    r.send("MTMR", "move_jp", [0.2, 0.3, 0.1, -0.4, 1.2, 0.3, 0.5])
    r.run(4.0)
    r.send("MTMR", "body/set_cf_orientation_absolute", True)
    r.send("MTMR", "body/servo_cf", np.zeros(6))
    r.run(0.002)
    before = r.system.truth("MTMR")
    r.send("MTMR", "body/servo_cf", F)
    r.run(0.002)  # the wrench acts from the next servo period on, after at most 0.67 ms
    tau = applied(r.state("MTMR"))
    after = r.system.truth("MTMR")

    model, data = twin()
    data.qpos[:] = before["position"]
    mujoco.mj_forward(model, data)
    M, Jv, Jw = np.zeros((7, 7)), np.zeros((3, 7)), np.zeros((3, 7))
    mujoco.mj_fullM(model, data, M)
    tip = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, "tip")
    mujoco.mj_jac(model, data, Jv, Jw, data.xpos[tip], tip)
    expected = Jv.T @ np.asarray(F)[:3] + Jw.T @ np.asarray(F)[3:]
    assert np.abs(tau - expected).max() < 2e-3
    a = np.linalg.solve(M, expected)
    gained = after["velocity"] - before["velocity"]
    acted = (a @ M @ gained) / (a @ M @ a)  # least squares in the metric of the kinetic energy
    assert 0.0010 < acted < 0.0020 + 1e-9
    rest = gained - acted * a
    assert rest @ M @ rest < 0.02**2 * (gained @ M @ gained)


@pytest.mark.parametrize("absolute", [False, True])
def test_wrench_axes_turn_with_the_tip_unless_absolute(homed, absolute):
    """The default axes are those of the tip, absolute ones those of the frame of measured_cp."""
    homed.send("MTMR", "body/set_cf_orientation_absolute", absolute)
    homed.send("MTMR", "move_jp", [0.2, 0.3, 0.1, -0.4, 1.2, 0.3, 0.5])
    homed.run(4.0)
    homed.send("MTMR", "body/servo_cf", PUSH)
    homed.run(0.001)
    seen = homed.state("MTMR")  # the state from which the controller computed the torque one period earlier
    homed.run(0.001)
    s = homed.state("MTMR")
    F_tip = in_tip_axes(seen, PUSH) if absolute else PUSH
    error = applied(s) - seen["body/jacobian"].T @ F_tip
    assert np.abs(np.delete(error, 3)).max() < 1e-4
    F_body = s["body/measured_cf"]
    assert np.allclose(F_body, s["measured_cf"] if absolute else in_tip_axes(s, s["measured_cf"]), atol=1e-9)


def test_camera_pedal_leaves_the_frame_absolute(robot):
    """The same wrench has another meaning after the first use of the camera."""
    apart = {"MTMR": np.eye(4), "MTML": np.eye(4)}
    apart["MTMR"][:3, 3], apart["MTML"][:3, 3] = [0.15, 0, 0.5], [-0.15, 0, 0.5]
    r = robot("MTMR", "MTML", "ECM", base_frames=apart).home()

    def is_absolute(arm):
        r.send(arm, "body/servo_cf", PUSH)
        r.run(0.01)
        s = r.state(arm)
        turning, fixed = s["body/jacobian"].T @ PUSH, s["body/jacobian"].T @ in_tip_axes(s, PUSH)
        error = [np.abs(np.delete(applied(s) - tau, 3)).max() for tau in (turning, fixed)]
        assert min(error) < 0.02 < max(error)
        return error[1] < error[0]

    assert not is_absolute("MTMR")
    r.send("console", "teleop/enable", True)
    r.send("console", "emulate_operator_present", 1)
    r.send("console", "emulate_camera", 1)
    r.run(0.05)
    r.send("console", "emulate_camera", 0)
    r.send("console", "teleop/enable", False)
    r.run(0.05)
    assert is_absolute("MTMR")
    assert is_absolute("MTML")


def test_spatial_wrench_is_about_the_base_and_without_platform_control(homed):
    homed.send("MTMR", "move_jp", [0.2, 0.3, 0.1, -0.4, 1.2, 0.3, 0.5])
    homed.run(4.0)
    p = homed.state("MTMR")["local/measured_cp"][:3, 3]
    at_base = np.concatenate([PUSH[:3], PUSH[3:] + np.cross(p, PUSH[:3])])  # as small at the wrist as PUSH
    homed.send("MTMR", "spatial/servo_cf", at_base)
    homed.run(0.002)
    s = homed.state("MTMR")
    assert np.abs(applied(s) - s["spatial/jacobian"].T @ at_base).max() < 2e-3
    p = s["local/measured_cp"][:3, 3]
    R = s["local/measured_cp"][:3, :3]
    at_tip = np.concatenate([R.T @ PUSH[:3], R.T @ (PUSH[3:] - np.cross(p, PUSH[:3]))])
    assert np.allclose(s["spatial/jacobian"].T @ PUSH, s["body/jacobian"].T @ at_tip, atol=1e-12)


def test_platform_follows_the_yaw_only_in_body_mode(robot):
    """The platform controller moves joint 4 towards q6 cos q5."""
    for verb, moves in (("body/servo_cf", True), ("spatial/servo_cf", False)):
        r = robot("MTMR").home()
        r.send("MTMR", "move_jp", [0, 0, 0, 0, 0.1, 0.6, 0])
        r.run(4.0)
        r.send("MTMR", verb, np.zeros(6))
        r.run(1.0)
        assert (r.system.truth("MTMR")["position"][3] > 0.1) == moves


def test_last_wrench_stays_without_a_timeout(homed):
    homed.send("MTMR", "body/servo_cf", [0, 0, 0.5, 0, 0, 0])
    homed.run(5.0)
    s = homed.state("MTMR")
    assert np.abs(np.delete(applied(s) - s["body/jacobian"].T @ [0, 0, 0.5, 0, 0, 0], 3)).max() < 2e-2


@pytest.mark.parametrize("name", ["MTMR", "MTML"])
def test_arm_falls_without_gravity_compensation(robot, name):
    fallen = {}
    for use in (True, False):
        r = robot(name).home()
        r.send(name, "use_gravity_compensation", use)
        r.send(name, "body/servo_cf", np.zeros(6))
        height = r.state(name)["measured_cp"][2, 3]
        r.run(1.0)
        fallen[use] = height - r.state(name)["measured_cp"][2, 3]
    assert abs(fallen[True]) < 0.002
    assert fallen[False] > 0.05


def test_gravity_compensation_is_off_only_in_position_control(homed):
    """As on the real controller; its value is published anyway."""
    homed.send("MTMR", "hold")
    homed.run(1.0)
    s = homed.state("MTMR")
    error = s["setpoint_js"]["position"] - s["measured_js"]["position"]
    assert abs(80.0 * error[1] - s["measured_js"]["effort"][1]) < 0.05  # only the servo carries the arm
    assert np.abs(s["gravity_compensation/setpoint_js"][1]) > 0.1
    homed.send("MTMR", "move_jp", s["measured_js"]["position"])
    homed.run(1.0)
    s = homed.state("MTMR")
    assert np.abs(s["setpoint_js"]["position"] - s["measured_js"]["position"])[1] < 0.002


def test_measured_wrench_is_that_of_the_joint_torques(homed):
    """It includes weight and friction."""
    s = homed.state("MTMR")
    tau = s["measured_js"]["effort"]
    assert np.allclose(s["body/measured_cf"], np.linalg.pinv(s["body/jacobian"].T) @ tau, atol=1e-5)
    assert np.allclose(s["spatial/measured_cf"], np.linalg.pinv(s["spatial/jacobian"].T) @ tau, atol=1e-5)
    assert np.linalg.norm(s["body/measured_cf"]) > 0.3


def test_body_jacobian_matches_finite_differences(homed):
    q = homed.state("MTMR")["measured_js"]["position"]
    J = homed.state("MTMR")["body/jacobian"]
    X = homed.system.forward_kinematics("MTMR", q)
    for k in range(7):
        h = 1e-6 * np.eye(7)[k]
        dX = np.linalg.inv(X) @ (
            homed.system.forward_kinematics("MTMR", q + h) - homed.system.forward_kinematics("MTMR", q - h)
        )
        turn = np.array([dX[2, 1], dX[0, 2], dX[1, 0]])
        assert np.allclose(J[:, k], np.concatenate([dX[:3, 3], turn]) / 2e-6, atol=1e-6)


def test_joint_torque_and_free_commands(homed):
    tau = np.array([0.1, -0.2, 0.1, 0.02, 0.01, 0.005, 0.001])
    homed.send("MTMR", "servo_jf", tau)
    homed.run(0.002)
    assert np.abs(applied(homed.state("MTMR")) - tau).max() < 2e-3
    homed.send("MTMR", "free")
    homed.run(0.002)
    assert np.abs(applied(homed.state("MTMR"))).max() < 2e-3


def test_torques_are_within_the_drive_limits(homed):
    homed.send("MTMR", "body/servo_cf", [1e308, -1e308, 1e308, 1e308, 0, 0])
    homed.run(0.05)
    effort = homed.state("MTMR")["measured_js"]["effort"]
    assert (np.abs(effort) <= palpate.Arm.mtm("right").tau_max + 1e-12).all()
    assert np.isfinite(homed.system.truth("MTMR")["position"]).all()


def test_locked_orientation_is_kept_under_a_force(homed):
    homed.send("MTMR", "body/set_cf_orientation_absolute", True)
    homed.send("MTMR", "body/servo_cf", np.zeros(6))
    homed.run(0.01)
    R = homed.state("MTMR")["measured_cp"][:3, :3]
    homed.send("MTMR", "lock_orientation", R)
    before = homed.state("MTMR")["measured_cp"][:3, 3]
    homed.send("MTMR", "body/servo_cf", [0, 0, 0.5, 0, 0, 0])
    homed.run(0.5)
    s = homed.state("MTMR")
    assert np.linalg.norm(s["measured_cp"][:3, 3] - before) > 0.03
    assert np.degrees(np.arccos((np.trace(R.T @ s["measured_cp"][:3, :3]) - 1) / 2)) < 6
    assert s["orientation_locked"]
    homed.send("MTMR", "hold")  # ends effort mode
    homed.run(0.01)
    assert not homed.state("MTMR")["orientation_locked"]
    assert [e[3] for e in homed.events if e[2] == "orientation_locked"][-1] is True  # as on the real robot


def test_hold_keeps_the_position_at_the_end_of_effort_mode(homed):
    homed.send("MTMR", "body/servo_cf", [0, 0, 1.0, 0, 0, 0])
    homed.run(0.5)
    homed.send("MTMR", "body/servo_cf", np.zeros(6))
    homed.run(1.0)
    homed.send("MTMR", "hold")
    homed.run(0.01)
    q = homed.state("MTMR")["measured_js"]["position"]
    homed.run(1.0)
    assert np.abs(homed.state("MTMR")["measured_js"]["position"] - q)[:4].max() < 0.02


def test_base_frame_changes_measured_but_not_local_states(homed):
    local = homed.state("MTMR")["local/measured_cp"]
    assert np.allclose(homed.state("MTMR")["measured_cp"], TILTED @ local)
    other = np.linalg.inv(TILTED)
    homed.send("MTMR", "set_base_frame", other)
    homed.run(0.002)
    assert np.allclose(homed.state("MTMR")["local/measured_cp"], local, atol=1e-4)
    assert np.allclose(homed.state("MTMR")["measured_cp"], other @ homed.state("MTMR")["local/measured_cp"])
