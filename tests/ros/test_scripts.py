"""The calls of the dVRK's and CRTK's own scripts, in their order and with their timeouts, against the simulated robot.

Each script is a client that starts beside the running robot and sends its first command at once.
"""

import copy
import time

import numpy as np
import pytest

WAIT = 5.0  # timeout of a first reading [s]; the scripts allow 1 s, which a busy machine may need to start a node
ARM = ("operating_state", "state_command", "setpoint_js", "setpoint_cp", "measured_js", "measured_cp", "measured_cv",
       "hold", "free", "servo_jp", "servo_jr", "servo_cp", "servo_jf", "move_jp", "move_jr", "move_cp",
       "spatial/measured_cf", "spatial/servo_cf", "spatial/jacobian", "body/measured_cf", "body/servo_cf",
       "body/jacobian", "local/measured_cp", "local/setpoint_cp", "body/set_cf_orientation_absolute",
       "use_gravity_compensation", "trajectory_j/set_ratio", "trajectory_j/ratio")  # fmt: skip
MTM = (*ARM, "gripper/measured_js", "lock_orientation", "unlock_orientation")
PSM = (*ARM, "jaw/measured_js", "jaw/setpoint_js", "jaw/servo_jp", "jaw/move_jp", "jaw/servo_jf")


@pytest.fixture
def script(sim, rclpy, request):
    """A program that has just started; its callbacks run once `spin` is called."""
    from crtk_client import Script

    assert sim.poll() is None, sim.stderr.read()
    with Script(rclpy, request.node.name[:40].replace("[", "_").replace("]", "")) as script:
        yield script


def joint_state(q):
    from sensor_msgs.msg import JointState

    return JointState(position=[float(x) for x in q])


def moved(pose, dx=0.0, dy=0.0, dz=0.0):
    goal = copy.deepcopy(pose)
    p = goal.pose.position
    p.x, p.y, p.z = p.x + dx, p.y + dy, p.z + dz
    return goal


def wrench(*values):
    from geometry_msgs.msg import WrenchStamped

    message = WrenchStamped()
    for axis, value in zip("xyz", values, strict=True):
        setattr(message.wrench.force, axis, float(value))
    return message


def test_python_teleoperation(script):
    """Home both arms at once, align the master, then follow: tool by the scaled motion of the hand, jaw by gripper."""
    master, puppet = script.arm("MTMR").use(*MTM), script.arm("PSM1").use(*PSM)
    for pedal in ("clutch", "operator_present"):
        script.subscribe(f"/console/{pedal}")
    script.spin()
    for arm in (puppet, master):
        arm.enable()
        arm.home()
    q = puppet.joints
    q[2] = 0.12
    puppet.move("move_jp", joint_state(q))  # past the cannula, as the manual asks for
    goal = master.read("setpoint_cp")
    goal.pose.orientation = puppet.read("setpoint_cp").pose.orientation
    master.send("move_cp", goal)
    master.send("use_gravity_compensation", data=True)
    master.send("body/servo_cf", wrench(0, 0, 0))
    start, hand = puppet.read("setpoint_cp"), master.tip
    for k in range(40):
        gripper = master.read("gripper/measured_js").position[0]
        step = 0.2 * (master.tip - hand) + [0.0, 0.0, 0.0002 * k]  # the hand itself may rest
        puppet.send("servo_cp", moved(start, *step))
        puppet.send("jaw/servo_jp", joint_state([min(gripper, 0.8)]))
    p = start.pose.position
    expected = np.array([p.x, p.y, p.z]) + step
    end = time.monotonic() + 10.0
    while np.linalg.norm(puppet.tip - expected) > 1e-3:
        assert time.monotonic() < end, (puppet.tip, expected)
    puppet.send("hold")
    master.send("hold")


def test_crtk_teleoperation_example(script):
    """It enables nothing: the first call reads the master's pose and waits for 1 s."""
    master, puppet = script.arm("MTMR").use("measured_cp"), script.arm("PSM1").use("setpoint_cp", "servo_cp")
    master.use("gripper/measured_js")
    puppet.use("jaw/setpoint_js", "jaw/servo_jp")
    script.spin()
    hand, start = master.read("measured_cp", WAIT), puppet.read("setpoint_cp", WAIT)
    for _ in range(20):
        now = master.read("measured_cp").pose.position
        puppet.send("servo_cp", moved(start, 0.1 * (now.x - hand.pose.position.x)))
        puppet.send("jaw/servo_jp", joint_state([master.read("gripper/measured_js").position[0]]))
        puppet.read("jaw/setpoint_js")


def test_orientation_registration(script):
    device = script.arm("MTMR").use("measured_cp")
    script.spin()
    script.check_connections()
    poses = [device.read("measured_cp") for _ in range(6)]
    assert all(abs(np.linalg.norm([p.pose.orientation.x, p.pose.orientation.y, p.pose.orientation.z,
                                   p.pose.orientation.w]) - 1.0) < 1e-6 for p in poses)  # fmt: skip


@pytest.mark.parametrize("name", ["MTMR", "PSM1"])
def test_arm_example(script, name):
    """Enable, home, joint motions by servo and move, then Cartesian ones."""
    arm = script.arm(name).use(*ARM)
    script.spin()
    script.check_connections()
    arm.enable()
    arm.home()
    goal = np.array(arm.read("setpoint_js").position)
    goal[2 if name == "PSM1" else 0] = 0.12 if name == "PSM1" else 0.05
    arm.move("move_jp", joint_state(goal))
    assert np.allclose(arm.joints, goal, atol=0.01)
    for k in range(30):
        arm.send("servo_jp", joint_state(goal + 0.001 * k * (np.arange(len(goal)) == 0)))
        arm.read("setpoint_js")
    begin = arm.read("setpoint_cp")
    arm.move("move_cp", moved(begin, dz=0.005))
    for k in range(20):
        arm.send("servo_cp", moved(begin, dz=0.005 + 0.0001 * k))
        arm.read("setpoint_cp")
    end = time.monotonic() + 10.0
    while abs(arm.read("setpoint_cp").pose.position.z - begin.pose.position.z - 0.0069) > 1e-4:
        assert time.monotonic() < end, arm.tip
    assert abs(arm.tip[2] - begin.pose.position.z - 0.0069) < 5e-3, "the MTM's position servo has a few millimetres"
    arm.send("hold")


def test_mtm_example(script):
    """Wrenches in tip and base axes, locked orientation, then hold."""
    arm = script.arm("MTMR").use(*MTM)
    script.subscribe("/footpedals/coag")
    script.spin()
    script.check_connections()
    arm.enable()
    arm.home()
    arm.send("use_gravity_compensation", data=True)
    arm.send("body/servo_cf", wrench(0, 0, 0))
    arm.send("body/set_cf_orientation_absolute", data=True)
    before = arm.tip
    arm.send("body/servo_cf", wrench(0, 0, -3.0))
    end = time.monotonic() + 10.0
    while arm.tip[2] > before[2] - 0.01:
        assert time.monotonic() < end, "the arm does not yield to 3 N"
    arm.send("lock_orientation", arm.read("measured_cp").pose.orientation)
    arm.send("body/servo_cf", wrench(0, 0, 0))
    arm.send("unlock_orientation")
    arm.send("hold")


def test_psm_example(script):
    """The jaw by move and by servo."""
    arm = script.arm("PSM1").use(*PSM)
    script.spin()
    script.check_connections()
    arm.enable()
    arm.home()
    for name, angle in (("jaw/move_jp", 0.5), ("jaw/servo_jp", 0.45)):
        arm.send(name, joint_state([angle]))
        end = time.monotonic() + 10.0
        while abs(arm.read("jaw/measured_js").position[0] - angle) > 0.02:
            assert time.monotonic() < end, name


def test_haptic_example(script):
    """A box around the present position and viscosity, by wrenches computed in the client."""
    arm = script.arm("MTMR").use("operating_state", "state_command", "measured_cp", "measured_cv", "body/servo_cf")
    script.spin()
    arm.enable(60.0)
    arm.home()
    centre = arm.tip
    for _ in range(30):
        away = arm.tip - centre
        arm.send("body/servo_cf", wrench(*(-500.0 * (away - np.clip(away, -0.01, 0.01)))))
    for _ in range(10):
        v = arm.read("measured_cv").twist.linear
        arm.send("body/servo_cf", wrench(-10 * v.x, -10 * v.y, -10 * v.z))
    arm.send("body/servo_cf", wrench(0, 0, 0))
    assert np.linalg.norm(arm.tip - centre) < 0.1
    arm.send("state_command", string="disable")


def test_gravity_collection(script):
    """Home, then positions and efforts at several poses, each after the end of its motion."""
    arm = script.arm("PSM1").use(*ARM)
    script.spin()
    script.check_connections()
    arm.enable()
    arm.home()
    rows = []
    for q in ([-0.2, -0.1, 0.05], [0.2, -0.1, 0.05], [0.2, 0.1, 0.1]):
        arm.move("move_jp", joint_state([*q, 0.0, 0.0, 0.0]))
        measured = arm.read("measured_js")
        rows.append([*measured.position[:3], *measured.effort[:3]])
        assert np.allclose(measured.position[:3], q, atol=0.01)
    assert np.isfinite(rows).all()
    assert np.ptp(np.array(rows)[:, 3:], axis=0).max() > 0.01, "the efforts follow gravity"
