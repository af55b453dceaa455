"""The patient side over ROS 2: a client that commands a PSM, and the teleoperation of the dVRK."""

import time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

TELEOP = "/MTMR_PSM1"
JAW_SCALE = 1.396 / (np.pi / 3)  # ratio of jaw range to gripper range


def joy(button):
    from sensor_msgs.msg import Joy

    return Joy(buttons=[button])


def joint_state(q):
    from sensor_msgs.msg import JointState

    return JointState(position=np.atleast_1d(q).astype(float).tolist())


def message_of(X):
    from geometry_msgs.msg import PoseStamped

    message = PoseStamped()
    p, o = message.pose.position, message.pose.orientation
    p.x, p.y, p.z = map(float, X[:3, 3])
    o.x, o.y, o.z, o.w = map(float, Rotation.from_matrix(X[:3, :3]).as_quat())
    return message


def angle(A, B):
    return Rotation.from_matrix(A[:3, :3].T @ B[:3, :3]).magnitude()


def apart(A, B):
    return np.linalg.norm(A[:3, 3] - B[:3, 3])


class Client:
    """Poses, joints and states of both arms from a client."""

    def __init__(self, dvrk, until):
        self.dvrk, self.until, self.publish, self.last = dvrk, until, dvrk.publish, dvrk.last

    def pose(self, arm, topic="measured_cp"):
        pose = self.last[f"/{arm}/{topic}"].pose
        X = np.eye(4)
        o = pose.orientation
        X[:3, :3] = Rotation.from_quat([o.x, o.y, o.z, o.w]).as_matrix()
        X[:3, 3] = pose.position.x, pose.position.y, pose.position.z
        return X

    def jaw(self, topic="measured_js"):
        return self.last[f"/PSM1/jaw/{topic}"].position[0]

    def wait(self, seconds):
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, "time", seconds + 5.0)

    def state(self):
        return self.last[f"{TELEOP}/current_state"].data

    def following(self):
        return self.last[f"{TELEOP}/following"].data

    def lead(self, p=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0), seconds=0.6):
        """Move the hand on the handle by a displacement and a rotation, and wait until the motion settles."""
        start = self.pose("MTMR")
        for share in 0.5 - 0.5 * np.cos(np.linspace(0.05, 1.0, 20) * np.pi):
            X = start.copy()
            X[:3, 3] += share * np.asarray(p)
            X[:3, :3] = Rotation.from_rotvec(share * np.asarray(turn)).as_matrix() @ start[:3, :3]
            self.publish("/MTMR/hand/servo_cp", message_of(X))
            self.wait(seconds / 20)
        self.wait(0.5)

    def pinch(self):
        for gripper in (1.0, 0.1, 0.5):
            self.publish("/MTMR/hand/gripper", data=gripper)
            self.wait(0.15)

    def goal(self, verb, message, seconds=10.0):
        """Send a command, and return its goal_reached."""
        self.last.pop("/PSM1/goal_reached", None)
        self.publish(f"/PSM1/{verb}", message)
        self.until(lambda: "/PSM1/goal_reached" in self.last, f"goal_reached of {verb}", seconds)
        return self.last["/PSM1/goal_reached"].data


@pytest.fixture
def client(sim, node, until):
    from dvrk_client import Dvrk

    assert sim.poll() is None, sim.stderr.read()
    dvrk = Dvrk(node, until)
    for arm in ("MTMR", "PSM1"):
        dvrk.subscribe(f"/{arm}/operating_state", f"/{arm}/measured_cp", f"/{arm}/setpoint_cp", f"/{arm}/measured_js")
        dvrk.subscribe(f"/{arm}/goal_reached", f"/{arm}/error", wait=False)
    dvrk.subscribe("/PSM1/jaw/measured_js", "/PSM1/jaw/setpoint_js")
    dvrk.home("MTMR", "PSM1")
    until(lambda: dvrk.last["/PSM1/measured_cp"].header.stamp.sec, "a valid pose of the PSM")
    places = {"MTMR": [0.0] * 7, "PSM1": [0.0, 0.0, 0.12, 0.0, 0.0, 0.0]}
    for arm, q in places.items():
        dvrk.last.pop(f"/{arm}/goal_reached", None)
        dvrk.publish(f"/{arm}/move_jp", joint_state(q))
    for arm, q in places.items():
        topic = f"/{arm}/measured_js"
        until(lambda topic=topic, q=q: np.abs(np.subtract(dvrk.last[topic].position, q)).max() < 0.06, f"{arm} at home")
        state = f"/{arm}/operating_state"
        until(lambda state=state: not dvrk.last[state].is_busy, f"{arm} at rest")
        until(lambda arm=arm: f"/{arm}/goal_reached" in dvrk.last, f"the end of the move of {arm}")
    return Client(dvrk, until)


def test_psm_follows_servo_cp(client):
    """A circle of 5 mm at 16 mm/s with rotation: the error is below 1 mm in motion, and small at the end."""
    start, apart_most = client.pose("PSM1"), 0.0
    begin = time.monotonic()
    while (t := time.monotonic() - begin) < 2.0:
        turn = np.pi * t
        X = start.copy()
        X[:3, 3] += 0.005 * np.array([np.sin(turn), 1.0 - np.cos(turn), 0.0])
        X[:3, :3] = start[:3, :3] @ Rotation.from_rotvec([0.0, 0.0, 0.2 * np.sin(turn)]).as_matrix()
        client.publish("/PSM1/servo_cp", message_of(X))
        client.wait(0.01)
        if t > 0.2:
            apart_most = max(apart_most, apart(client.pose("PSM1", "setpoint_cp"), X))
            assert apart(client.pose("PSM1"), X) < 0.004  # tolerance for a late client: 16 mm/s for 0.25 s
    assert apart_most > 0.0
    client.publish("/PSM1/servo_cp", message_of(start))
    client.until(lambda: apart(client.pose("PSM1"), start) < 5e-5, "the goal within 0.05 mm")
    client.until(lambda: angle(client.pose("PSM1"), start) < 1e-3, "its attitude")
    assert "/PSM1/error" not in client.last


def test_moves_of_a_psm_report_their_goal(client):
    goal = client.pose("PSM1")
    goal[:3, 3] += [0.01, -0.008, -0.006]
    goal[:3, :3] = goal[:3, :3] @ Rotation.from_rotvec([0.1, 0.2, 0.0]).as_matrix()
    assert client.goal("move_cp", message_of(goal))
    client.until(
        lambda: apart(client.pose("PSM1"), goal) < 5e-5 and angle(client.pose("PSM1"), goal) < 1e-3, "the goal"
    )
    far = goal.copy()
    far[:3, 3] += [2.0, 0.0, 0.0]
    assert not client.goal("move_cp", message_of(far)), "the pose is out of reach"
    client.until(lambda: "/PSM1/error" in client.last, "why not")
    assert "inverse kinematics" in client.last["/PSM1/error"].data


def test_jaw_accepts_servo_and_move_commands(client):
    client.publish("/PSM1/jaw/servo_jp", joint_state(0.4))
    client.until(lambda: abs(client.jaw() - 0.4) < 1e-3, "the jaw at 0.4 rad")
    assert client.goal("jaw/move_jp", joint_state(1.0))
    client.until(lambda: abs(client.jaw() - 1.0) < 1e-3, "the jaw at 1 rad")
    client.publish("/PSM1/jaw/servo_jp", joint_state(9.0))
    client.until(lambda: abs(client.jaw() - 1.396) < 1e-3, "the jaw at its stop")


def test_service_converts_actuator_to_joint_positions(client, node, until):
    from cisst_msgs.srv import ConvertFloat64Array

    service = node.create_client(ConvertFloat64Array, "/PSM1/actuator_to_joint_position")
    until(service.service_is_ready, "the service")
    future = service.call_async(ConvertFloat64Array.Request(input=[0.1, 0.2, 0.12, 1.0, 0.0, 0.0, 0.0]))
    until(future.done, "an answer")
    np.testing.assert_allclose(future.result().output, [0.1, 0.2, 0.12, -1.5632, 0, 0, 0], atol=1e-12)


@pytest.fixture
def aligning(client):
    """The dVRK teleoperation is on, an operator is present, and the MTM moves to the PSM's orientation."""
    client.dvrk.subscribe(
        f"{TELEOP}/current_state", f"{TELEOP}/following", f"{TELEOP}/scale", "/console/teleop/enabled"
    )
    client.dvrk.subscribe(f"{TELEOP}/warning", f"{TELEOP}/error", "/console/clutch", wait=False)
    client.publish("/PSM1/jaw/servo_jp", joint_state(0.0))
    client.publish("/MTMR/hand/free")
    client.publish(f"{TELEOP}/set_scale", data=0.2)
    client.publish("/console/teleop/enable", data=True)
    client.publish("/console/emulate_operator_present", joy(1))
    client.until(lambda: client.state() == "ALIGNING_MTM", "aligning")
    yield client
    client.publish("/console/emulate_operator_present", joy(0))
    client.publish("/console/teleop/enable", data=False)
    client.publish("/MTMR/hand/free")
    client.until(lambda: client.state() == "DISABLED", "the teleoperation off")


@pytest.fixture
def following(aligning):
    """The operator holds the handle and has closed the gripper, so the PSM and its jaw follow."""
    target = aligning.pose("PSM1", "setpoint_cp")
    aligning.until(lambda: angle(aligning.pose("MTMR"), target) < 0.08, "the MTM aligned", 15.0)
    aligning.publish("/MTMR/hand/servo_cp", message_of(aligning.pose("MTMR")))
    aligning.pinch()
    aligning.until(aligning.following, "following", 10.0)
    aligning.until(lambda: abs(aligning.jaw() - 0.5 * JAW_SCALE) < 2e-3, "the jaw as the gripper", 10.0)
    return aligning


def test_misaligned_mtm_is_not_followed(aligning):
    """An MTM held at 12 degrees, beyond the tolerance of 5, is refused with a warning; once released, it aligns."""
    target = aligning.pose("PSM1", "setpoint_cp")
    aligning.until(lambda: angle(aligning.pose("MTMR"), target) < 0.08, "the MTM aligned", 15.0)
    X = aligning.pose("MTMR")
    X[:3, :3] = Rotation.from_rotvec([0.0, 0.0, np.radians(25)]).as_matrix() @ X[:3, :3]
    aligning.publish("/MTMR/hand/servo_cp", message_of(X))
    aligning.until(lambda: angle(aligning.pose("MTMR"), target) > np.radians(6), "the handle turned away")
    aligning.last.pop(f"{TELEOP}/warning", None)
    aligning.pinch()
    warning = "unable to align MTM, angle error is"
    aligning.until(lambda: warning in getattr(aligning.last.get(f"{TELEOP}/warning"), "data", ""), warning, 8.0)
    assert aligning.state() == "ALIGNING_MTM"
    assert not aligning.following()
    aligning.publish("/MTMR/hand/free")
    aligning.until(aligning.following, "aligned and following, once let go", 10.0)


def test_following_with_scale_clutch_and_locks(following):
    c = following
    for scale in (0.2, 0.5):
        c.publish(f"{TELEOP}/set_scale", data=scale)
        c.until(lambda scale=scale: c.last[f"{TELEOP}/scale"].data == scale, "the published scale")
        hand, tool = c.pose("MTMR"), c.pose("PSM1", "setpoint_cp")
        c.lead(p=[0.03, -0.02, 0.02], turn=[0.1, 0.15, -0.1])
        moved = (c.pose("MTMR") - hand)[:3, 3]
        assert np.linalg.norm(moved) > 0.02
        np.testing.assert_allclose((c.pose("PSM1", "setpoint_cp") - tool)[:3, 3], scale * moved, atol=3e-4)
        turned = c.pose("MTMR")[:3, :3] @ hand[:3, :3].T
        expected = tool.copy()
        expected[:3, :3] = turned @ tool[:3, :3]
        assert angle(c.pose("PSM1", "setpoint_cp"), expected) < 0.02
        c.lead(p=[-0.03, 0.02, -0.02], turn=[-0.1, -0.15, 0.1])

    tool = c.pose("PSM1", "setpoint_cp")
    c.publish("/console/emulate_clutch", joy(1))
    c.until(lambda: not c.following(), "clutched")
    c.lead(p=[0.03, 0.02, 0.0])
    assert apart(c.pose("PSM1", "setpoint_cp"), tool) < 1e-3, "the tool does not move while the hand moves"
    c.publish("/console/emulate_clutch", joy(0))
    c.until(c.following, "following again", 10.0)
    assert apart(c.pose("PSM1", "setpoint_cp"), tool) < 1e-3, "no jump"

    c.publish(f"{TELEOP}/lock_rotation", data=True)
    c.wait(0.2)
    tool = c.pose("PSM1", "setpoint_cp")
    c.lead(p=[0.0, 0.03, 0.0])
    assert angle(c.pose("PSM1", "setpoint_cp"), tool) < 1e-3
    assert apart(c.pose("PSM1", "setpoint_cp"), tool) > 0.005
    c.publish(f"{TELEOP}/lock_rotation", data=False)
    c.until(lambda: c.following() and c.state() == "ENABLED", "following again after an alignment", 10.0)


def test_jaw_follows_the_gripper_and_catches_up_after_a_clutch(following):
    """After a clutch the jaw catches up at 0.2 pi rad/s, then it follows directly."""
    c = following
    c.publish("/console/emulate_clutch", joy(1))
    c.until(lambda: not c.following(), "clutched")
    c.publish("/MTMR/hand/gripper", data=0.9)
    c.wait(0.3)
    assert abs(c.jaw() - 0.5 * JAW_SCALE) < 0.02, "the jaw does not move while clutched"
    c.publish("/console/emulate_clutch", joy(0))
    c.until(c.following, "following again", 10.0)

    def took(gripper):
        """Time until the jaw has reached the angle of the gripper, on the robot's clock [s]."""

        def arrived():
            now = c.last["/PSM1/jaw/setpoint_js"]
            t = now.header.stamp.sec + 1e-9 * now.header.stamp.nanosec
            if t > seen[-1][0]:
                seen.append((t, now.position[0]))
            return abs(c.jaw() - gripper * JAW_SCALE) < 5e-3

        seen = [(0.0, c.jaw("setpoint_js"))]
        c.until(arrived, f"the jaw at the gripper's {gripper} rad", 10.0)
        t, q = np.array(seen[1:]).T
        moving = np.flatnonzero(np.abs(np.diff(q)) > 1e-6)
        return t[moving[-1] + 1] - t[moving[0]]

    assert took(0.9) > 0.5, "slow: 0.4 rad of the gripper, except for 2 degrees, at 0.2 pi rad/s"
    c.publish("/MTMR/hand/gripper", data=0.1)
    assert took(0.1) < 0.4, "then the jaw follows directly"
