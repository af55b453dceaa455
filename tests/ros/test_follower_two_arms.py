"""Two arms over ROS 2 at one follower's end: each follows its own hand, and each hand feels its own tissue."""

import threading
import time
import warnings

import numpy as np
import pytest
from dvrk_client import Dvrk

pytest.importorskip("cryptography", reason="links need the extra remote")

from palpate.ros.patient import RosPatient
from palpate.scene import Scene
from palpate.scene.together import build_pairs
from palpate.session import PairsSession
from palpate.session.remote.link import RemoteLink
from palpate.session.remote.site import FollowerServer

KEY, RADIUS = bytes(range(32)), 0.002
TISSUES = {"right": ("PSM1", 600.0, -0.001), "left": ("PSM2", 350.0, -0.002)}
"""Arm, stiffness [N/m] and place [m] of the table under each."""


def arms(side):
    x, turn = {"right": (1.0, -20.0), "left": (-1.0, 20.0)}[side]
    foot = {"right": [0.06, -0.06, 0.155], "left": [-0.12, -0.06, 0.155]}[side]
    yaw = {"right": 155.0, "left": 205.0}[side]
    return {"leader": {"model": f"mtm_{side}", "base": {"xyz": [0.345 * x, 0.243, 0.219], "rpy_deg": [0, 0, turn]}},
            "follower": {"model": "psm_lnd", "base": {"xyz": foot, "rpy_deg": [0, 0, yaw]}}}  # fmt: skip


def operator(x):
    return {"palpate": {"object": "table", "at": [x, 0, 0.1], "force": 1.0, "length": 0.005, "approach": 1.0,
                        "press": 0.5, "slide": 2.0, "leave": 0.5}}  # fmt: skip


@pytest.fixture
def scene():
    return Scene.model_validate({
        "objects": [{"name": "table", "plane": {}, "stiffness": 450, "damping": 1}],
        "contact": {"radius": RADIUS},
        "pairs": {"right": {"arms": arms("right"), "operator": operator(0.03)},
                  "left": {"arms": arms("left"), "operator": operator(-0.03)}},
        "remote": {"rate": 250.0},
    })  # fmt: skip


@pytest.fixture
def tissues(start_sim, node, until, scene):
    """Both arms are homed, and a table answers each with a force of its own, in a thread: rigs of the pairs."""
    from geometry_msgs.msg import PoseStamped, WrenchStamped
    from rclpy.executors import SingleThreadedExecutor

    from palpate.base.arrays import so3

    start_sim(*(arm for arm, _, _ in TISSUES.values()))
    robot = Dvrk(node, until)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rigs = build_pairs(scene)
    for arm, _, _ in TISSUES.values():
        robot.subscribe(f"/{arm}/operating_state", f"/{arm}/measured_cp")
    robot.home(*(arm for arm, _, _ in TISSUES.values()))
    for name, (arm, K, place) in TISSUES.items():
        publisher, X_WB = node.create_publisher(WrenchStamped, f"/{arm}/tissue_cf", 1), rigs[name].arms.X_WB

        def answer(message, publisher=publisher, X_WB=X_WB, K=K, place=place):
            p, o = message.pose.position, message.pose.orientation
            X_WT = X_WB @ so3.pose([p.x, p.y, p.z], [o.w, o.x, o.y, o.z])
            F = X_WB[:3, :3].T @ np.array([0.0, 0.0, max(K * (place + RADIUS - X_WT[2, 3]), 0.0)])
            out = WrenchStamped()
            out.header.stamp = message.header.stamp
            out.wrench.force.x, out.wrench.force.y, out.wrench.force.z = F.tolist()
            publisher.publish(out)

        node.create_subscription(PoseStamped, f"/{arm}/measured_cp", answer, 1)
    executor, stopped = SingleThreadedExecutor(), threading.Event()
    executor.add_node(node)

    def spin():
        while not stopped.is_set():
            executor.spin_once(timeout_sec=0.05)

    thread = threading.Thread(target=spin)
    thread.start()
    yield rigs
    stopped.set()
    thread.join()
    executor.remove_node(node)


def learnt(model, K, place):
    """Stiffness within 10 %, and place within 0.4 mm."""
    return abs(model["stiffness_N_per_m"] / K - 1.0) <= 0.1 and abs(model["shift_m"][2] - place) <= 4e-4


@pytest.mark.long  # arms on a busy machine are silent now and then, and learn slowly
def test_two_arms_follow_two_hands_over_one_link(tissues, scene):
    said = []
    patients = [RosPatient(tissues[name], arm, f"/{arm}/tissue_cf", say=said.append)
                for name, (arm, _, _) in TISSUES.items()]  # fmt: skip
    server = FollowerServer(tissues, KEY, "127.0.0.1", 0, 250.0, said.append, patients)
    thread = threading.Thread(target=server.run)
    thread.start()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            session = PairsSession(scene)
        with RemoteLink(session, ("127.0.0.1", server.port), KEY, 250.0) as remote:
            hands = threading.Thread(target=session.run, args=(40.0,), kwargs={"realtime": True})
            hands.start()
            while hands.is_alive():  # a busy machine lets the arms rest now and then
                time.sleep(0.2)
                found = {name: remote.figures(name)["models"][0] for name in TISSUES}
                if all(learnt(found[name], *TISSUES[name][1:]) for name in TISSUES):
                    session.interrupt()
                    break
            hands.join()
    finally:
        server.stop()
        thread.join()
    for (name, (_, K, place)), patient in zip(TISSUES.items(), patients, strict=True):
        assert patient.sent > 50, said
        assert learnt(found[name], K, place), (name, found[name], said)
    assert server.largest < 3.0
