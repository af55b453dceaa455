"""The steps of a user on the simulated dVRK: home the master, start the node, press on a wall, end at zero force."""

import signal

import numpy as np
import pytest

from palpate.scene.rig import build
from palpate.scene.scene import Scene

RATE = 500
WALL = "objects: [{name: wall, box: {size: [0.2, 0.2, 0.05]}, stiffness: 300, damping: 2}]\nrecord: {report: false}\n"


@pytest.fixture
def dvrk(start, node, until):
    from dvrk_client import Dvrk

    start("-m", "palpate", "ros", "sim", "--arms", "MTMR", "--rate", RATE)
    client = Dvrk(node, until)
    client.subscribe("/MTMR/operating_state", "/MTMR/measured_cp")
    client.home("MTMR")
    return client


@pytest.mark.long  # test_topic.py presses the hand of a simulated robot into a wall, too
def test_wall_is_rendered_on_the_simulated_master(dvrk, node, until, start, tmp_path):
    from geometry_msgs.msg import PoseStamped, WrenchStamped
    from sensor_msgs.msg import Joy

    scene, forces = tmp_path / "wall.yaml", []
    scene.write_text(WALL)
    options = ("--teleop", "none", "--follower", "virtual", "--rate", RATE, "--out", tmp_path / "runs")
    haptics = start("-m", "palpate", "ros", "haptics", scene, *options)

    def felt(m):
        forces.append(np.array([m.wrench.force.x, m.wrench.force.y, m.wrench.force.z]))

    node.create_subscription(WrenchStamped, "/MTMR/body/servo_cf", felt, 100)
    dvrk.publish("/console/emulate_operator_present", Joy(buttons=[1]))
    until(lambda: len(forces) > RATE, "a second of wrenches", 60.0)
    assert not any(f.any() for f in forces), "no force in free space"
    R_WL = build(Scene.load(scene)).arms.X_WL[:3, :3]
    down, hand = R_WL.T @ [0.0, 0.0, -1.0], dvrk.last["/MTMR/measured_cp"].pose
    at, goal = np.array([hand.position.x, hand.position.y, hand.position.z]), PoseStamped()
    goal.pose.orientation = hand.orientation
    for depth in np.arange(0.0, 0.12, 0.0005):  # depth [m], at about 2 cm/s
        p = at + depth * down
        goal.pose.position.x, goal.pose.position.y, goal.pose.position.z = map(float, p)
        dvrk.publish("/MTMR/hand/servo_cp", goal)
        seen = len(forces)
        until(lambda seen=seen: len(forces) > seen + RATE // 50, "wrenches")
        if np.linalg.norm(forces[-1]) > 0.3:
            break
    push = forces[-1]
    assert np.linalg.norm(push) > 0.3
    assert push @ -down > 0.99 * np.linalg.norm(push), "the force points out of the wall in the frame of measured_cp"
    haptics.send_signal(signal.SIGTERM)
    _, err = haptics.communicate(timeout=30)
    assert haptics.returncode == 0, err
    until(lambda: not forces[-1].any(), "zero last", 2.0)
