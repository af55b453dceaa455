"""`palpate serve follower --arm`: an arm over ROS 2 follows a session across a link, and its tissue is learnt."""

import threading
import time
import warnings

import numpy as np
import pytest
from dvrk_client import Dvrk

pytest.importorskip("cryptography", reason="links need the extra remote")

from palpate.base.errors import PalpateError
from palpate.cli import main
from palpate.ros.patient import RosPatient
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.session import Session
from palpate.session.remote.link import RemoteLink
from palpate.session.remote.site import FollowerServer

KEY = bytes(range(32))
K, PLACE, RADIUS = 450.0, -0.0015, 0.002
SCENE = {
    "objects": [{"name": "table", "plane": {}, "stiffness": 300, "damping": 1}],
    "arms": {"leader": {"model": "mtm_right", "base": {"xyz": [0.345, 0.243, 0.219], "rpy_deg": [0, 0, -20]}},
             "follower": {"model": "psm_lnd", "base": {"xyz": [-0.12, -0.06, 0.155], "rpy_deg": [0, 0, 205]}}},
    "contact": {"radius": RADIUS},
    "operator": {"palpate": {"object": "table", "at": [0, 0, 0.1], "force": 1.0, "length": 0.01, "approach": 1.0,
                             "press": 0.5, "slide": 2.0, "leave": 0.5}},
}  # fmt: skip


@pytest.fixture(scope="module")
def rig():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return build(Scene.model_validate(SCENE))


@pytest.fixture(scope="module")
def sim(start_sim):
    return start_sim("PSM1")


@pytest.fixture
def robot(sim, node, until):
    robot = Dvrk(node, until)
    robot.subscribe("/PSM1/operating_state", "/PSM1/measured_cp")
    if not robot.last["/PSM1/operating_state"].is_homed:
        robot.home("PSM1")
    return robot


@pytest.fixture
def tissue(robot, node, rig):
    """A table that answers each pose of the tip with its force, in axes of the arm's base: its largest force [N]."""
    from geometry_msgs.msg import PoseStamped, WrenchStamped

    from palpate.base.arrays import so3

    publisher, X_WB, felt = node.create_publisher(WrenchStamped, "/tissue/measured_cf", 1), rig.arms.X_WB, []

    def answer(message):
        p, o = message.pose.position, message.pose.orientation
        X_WT = X_WB @ so3.pose([p.x, p.y, p.z], [o.w, o.x, o.y, o.z])
        F = X_WB[:3, :3].T @ np.array([0.0, 0.0, max(K * (PLACE + RADIUS - X_WT[2, 3]), 0.0)])
        felt.append(float(np.linalg.norm(F)))
        out = WrenchStamped()
        out.header.stamp = message.header.stamp
        out.wrench.force.x, out.wrench.force.y, out.wrench.force.z = F.tolist()
        publisher.publish(out)

    node.create_subscription(PoseStamped, "/PSM1/measured_cp", answer, 1)
    return felt


@pytest.fixture
def spinning(node, tissue):
    """The tissue answers in a thread of its own."""
    from rclpy.executors import SingleThreadedExecutor

    executor, stopped = SingleThreadedExecutor(), threading.Event()
    executor.add_node(node)

    def spin():
        while not stopped.is_set():
            executor.spin_once(timeout_sec=0.05)

    thread = threading.Thread(target=spin)
    thread.start()
    yield
    stopped.set()
    thread.join()
    executor.remove_node(node)


@pytest.fixture
def served(rig, tissue, spinning):
    """A follower's end with the arm: server, patient, and what they said."""
    said = []
    patient = RosPatient(rig, "PSM1", "/tissue/measured_cf", say=said.append)
    server = FollowerServer(rig, KEY, "127.0.0.1", 0, 250.0, said.append, [patient])
    thread = threading.Thread(target=server.run)
    thread.start()
    yield server, patient, said
    server.stop()
    thread.join()


def test_an_arm_follows_and_its_tissue_is_felt(served, rig, tissue):
    server, patient, _ = served
    time.sleep(0.5)
    assert patient.sent == 0  # nobody drives it yet
    session = Session(rig.scene, rig=rig)
    with RemoteLink(session, ("127.0.0.1", server.port), KEY, 250.0) as remote:
        session.run(7.0, realtime=True)
        found = remote.figures()
    (model,) = found["models"]
    assert patient.sent > 500
    assert model["stiffness_N_per_m"] == pytest.approx(K, rel=0.1)
    assert model["shift_m"][2] == pytest.approx(PLACE, abs=3e-4)
    assert 0.3 < max(tissue) < 3.0
    assert server.largest == pytest.approx(max(tissue), rel=0.2)


def test_a_silent_force_is_named(robot, rig, monkeypatch):
    monkeypatch.setattr("palpate.ros.patient.FIND", 1.0)
    with pytest.raises(PalpateError, match="PSM1 cannot follow: nothing valid on /nobody/measured_cf"):
        RosPatient(rig, "PSM1", "/nobody/measured_cf")


def test_an_arm_that_is_disabled_gets_no_goal(served, robot, rig, until):
    server, patient, said = served
    session = Session(rig.scene, rig=rig)
    with RemoteLink(session, ("127.0.0.1", server.port), KEY, 250.0):
        driving = threading.Thread(target=session.run, args=(6.0,), kwargs={"realtime": True})
        driving.start()
        until(lambda: patient.sent > 50, "goals of the operator")
        robot.publish("/PSM1/state_command", string="disable")
        until(lambda: any("not ENABLED: no goal is sent" in line for line in said), "words about the arm")
        sent = patient.sent
        time.sleep(0.5)
        assert patient.sent == sent
        session.interrupt()
        driving.join()


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--arm", "PSM1"), "the force of the tissue on its tool is not known"),
        (("--arm", "PSM1", "PSM2", "--force", "/a", "/b"), "each pair of this scene needs an arm of its own"),
        (("--force", "/tissue/measured_cf"), "a simulated instrument measures its own force"),
    ],
)
def test_an_arm_needs_a_force_and_a_force_an_arm(words, why, tmp_path, capsys):
    assert main(["keys", "--out", str(tmp_path / "key")]) == 0
    assert main(["serve", "follower", "remote", "--key", str(tmp_path / "key"), *words]) == 2
    assert why in " ".join(capsys.readouterr().err.split())
