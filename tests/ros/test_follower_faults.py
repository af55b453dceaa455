"""An arm over ROS 2 that follows an operator across the network, when it is carried, stuck, silent or disabled."""

import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("cryptography", reason="links need the extra remote")

from palpate import _network
from palpate.cli.commands.serve.follower import Command
from palpate.ros.newest import Newest
from palpate.ros.patient import LAG, RosPatient
from palpate.scene import Scene
from palpate.scene.rig import build


class Arm:
    """An arm in the test's node: it tells pose and force at 100 Hz, and its tool is at once where it is sent."""

    def __init__(self, node, name="FAKE"):
        from crtk_msgs.msg import OperatingState
        from geometry_msgs.msg import PoseStamped, WrenchStamped
        from rclpy.qos import DurabilityPolicy, QoSProfile

        self.p, self.offset, self.force = np.zeros(3), 0.0, 0.0  # true place [m], error of the measured one, force [N]
        self.stuck, self.stamp = False, None  # stamp of all messages; None: the present time
        self.goals = []  # distances of all goals from the tool [m]
        self._node, self._pose, self._wrench, self._state = node, PoseStamped, WrenchStamped, OperatingState
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._states = node.create_publisher(OperatingState, f"/{name}/operating_state", latched)
        self._poses = node.create_publisher(PoseStamped, f"/{name}/measured_cp", 1)
        self._forces = node.create_publisher(WrenchStamped, f"/{name.lower()}/measured_cf", 1)
        node.create_subscription(PoseStamped, f"/{name}/servo_cp", self._take, 10)
        node.create_timer(0.01, self._tell)
        self.tell_state("ENABLED")

    def tell_state(self, name):
        self._states.publish(self._state(state=name, is_homed=True))

    def _tell(self):
        pose, wrench = self._pose(), self._wrench()
        stamp = self.stamp or self._node.get_clock().now().to_msg()
        pose.header.stamp = wrench.header.stamp = stamp
        pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = (self.p + self.offset).tolist()
        wrench.wrench.force.z = self.force
        self._poses.publish(pose)
        self._forces.publish(wrench)

    def _take(self, message):
        p = np.array([message.pose.position.x, message.pose.position.y, message.pose.position.z])
        self.goals.append(float(np.linalg.norm(p - self.p)))
        if not self.stuck:
            self.p = p


@pytest.fixture(scope="module")
def rig():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return build(Scene.model_validate({"objects": [{"name": "table", "plane": {}}]}))


@pytest.fixture
def arm(node):
    return Arm(node)


@pytest.fixture
def patient(rig, arm, until):
    said = []
    with ThreadPoolExecutor() as pool:
        made = pool.submit(RosPatient, rig, "FAKE", "/fake/measured_cf", say=said.append)
        until(made.done, "the patient's side")
    patient = made.result()
    patient.said = said
    patient.start()
    yield patient
    patient.stop()


class Operator:
    """An operator's end that wants the tool at a place, and exchanges a packet whenever a condition is asked for."""

    def __init__(self, patient, rig, until):
        self.patient, self.peer, self._until = patient, _network.Peer(), until
        self.X = np.array(rig.arms.X_WB)  # the arm's base is where the tool begins

    def exchange(self):
        now, out = time.monotonic(), _network.Datagram()
        out.X, out.flags = self.X, _network.FLAG_ENGAGED
        self.peer.stamp(out, now)
        self.patient.receive(_network.encode(out), now)
        self.peer.receive(_network.decode(self.patient.packet()), now)
        self.peer.step(now)

    def until(self, condition, words, seconds=5.0):
        self._until(lambda: self.exchange() or condition(), words, seconds)

    def told(self, words):
        """Wait until the patient's side has said this, and then no goal comes."""
        said, lines, sent = self.patient.said, -1, 0
        while len(said) != lines:  # a valid message that was on its way can be taken between
            self.until(lambda: said and f"{words}: no goal is sent" in said[-1], words)
            lines, sent = len(said), self.patient.sent
            self.wait(0.1)
        assert self.patient.sent == sent
        said.clear()

    def wait(self, seconds):
        """Exchange packets for a time [s]."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, "the time")


@pytest.fixture
def operator(patient, rig, until):
    return Operator(patient, rig, until)


@pytest.fixture
def spin_for(until):
    """A function that lets the arm speak for a time [s], without an operator."""

    def spin(seconds):
        end = time.monotonic() + seconds
        until(lambda: time.monotonic() > end, "the time")

    return spin


def test_goals_begin_where_the_tool_is_and_stay_near_a_tool_that_is_stuck(operator, patient, arm, spin_for):
    arm.stuck = True
    spin_for(0.3)
    arm.p = np.array([0.05, 0.0, 0.0])  # others carry it, before an operator comes
    spin_for(0.1)
    operator.until(lambda: arm.goals, "a goal")
    assert arm.goals[0] < 2e-3
    operator.X[:3, 3] += operator.X[:3, 0] * 0.3
    operator.told("mm from its goal")
    assert len(arm.goals) > 50
    assert max(arm.goals) <= LAG + 1e-6
    operator.until(lambda: operator.peer.lost, "the operator is told", 3.0)


def test_what_is_no_measurement_stops_the_goals_until_it_measures_again(operator, patient, arm, node):
    operator.until(lambda: patient.sent > 20, "goals")
    for what, words in (("offset", "/FAKE/measured_cp is silent"), ("force", "/fake/measured_cf is silent")):
        setattr(arm, what, np.nan)
        operator.told(words)
        setattr(arm, what, 0.0)
        operator.until(lambda: "FAKE is ready" in patient.said, "it is ready again")
    arm.stamp = node.get_clock().now().to_msg()
    operator.told("/FAKE/measured_cp is silent")
    arm.stamp = None
    sent = patient.sent
    operator.until(lambda: patient.sent > sent, "goals again")


def test_a_new_operator_of_a_disabled_arm_gets_no_packet_of_the_one_before(operator, patient, arm):
    operator.until(lambda: operator.peer.newest.flags & _network.FLAG_ALIGNED, "the tool is aligned")
    arm.tell_state("DISABLED")
    operator.told("FAKE is DISABLED, not ENABLED")
    assert _network.decode(patient.packet()).flags & _network.FLAG_ALIGNED  # as it was: it only grows old
    patient.forget_operator()
    operator.until(lambda: not _network.decode(patient.packet()).flags, "it is forgotten")
    assert _network.decode(patient.packet()).t == 0.0


@pytest.mark.parametrize("silent", [False, True])
def test_an_operator_who_leaves_leaves_no_goals_behind(operator, patient, arm, spin_for, monkeypatch, silent):
    """Others may then carry the arm: the held pose would pull it back for ever."""
    monkeypatch.setattr("palpate.ros.patient.PATIENCE", 0.3)
    operator.until(lambda: patient.sent > 20, "goals")
    if not silent:
        patient.forget_operator()
    spin_for(0.5 if silent else 0.1)
    sent, arm.p = patient.sent, np.array([0.05, 0.0, 0.0])
    spin_for(0.3)
    assert patient.sent == sent
    arm.goals.clear()
    operator.until(lambda: arm.goals, "goals again")
    assert arm.goals[0] < 2e-3


def test_each_pair_has_an_arm_of_its_own(rig, node, until):
    arms, topics = [Arm(node, name) for name in ("ONE", "TWO")], ("/one/measured_cf", "/two/measured_cf")
    command = Command(Path("two.yaml"), arm=("ONE", "TWO"), force=topics)
    with ThreadPoolExecutor() as pool:
        made = pool.submit(command._arms, {"left": rig, "right": rig}, lambda line: None)
        until(made.done, "both arms")
    patients = made.result()
    assert [one.arm for one in patients] == ["ONE", "TWO"]
    for one in patients:
        one.start()
    Operator(patients[1], rig, until).until(lambda: len(arms[1].goals) > 20, "goals of the second one")
    assert not arms[0].goals
    for one in patients:
        one.stop()


def message(stamp=(1, 0), **fields):
    return SimpleNamespace(header=SimpleNamespace(stamp=SimpleNamespace(sec=stamp[0], nanosec=stamp[1])), **fields)


def posed(x=0.0, w=1.0, stamp=(1, 0)):
    p, o = SimpleNamespace(x=x, y=0.0, z=0.0), SimpleNamespace(w=w, x=0.0, y=0.0, z=0.0)
    return message(stamp, pose=SimpleNamespace(position=p, orientation=o))


def test_only_valid_new_messages_are_kept():
    newest = Newest()
    assert newest.age("pose", 1.0) == np.inf
    newest.keep("pose", posed(0.5), 1.0)
    for wrong in (posed(0.1), posed(np.nan, stamp=(2, 0)), posed(stamp=(0, 0)), posed(w=0.0, stamp=(2, 0)),
                  posed(w=1.1, stamp=(2, 0)), posed(w=np.inf, stamp=(2, 0))):  # fmt: skip
        newest.keep("pose", wrong, 2.0)
    np.testing.assert_array_equal(newest["pose"], [0.5, 0, 0, 1, 0, 0, 0])
    assert newest.age("pose", 3.0) == 2.0
    newest.keep("pose", posed(0.6, stamp=(1, 1)), 2.5)
    assert newest["pose"][0] == 0.6
    newest.keep("jaw", message(position=[]), 1.0)
    assert "jaw" not in newest
    newest.keep("jaw", message(position=[0.3]), 1.0)
    newest.keep("force", message(wrench=SimpleNamespace(force=SimpleNamespace(x=1.0, y=2.0, z=3.0))), 1.0)
    newest.keep("velocity", message(twist=SimpleNamespace(linear=SimpleNamespace(x=1.0, y=2.0, z=np.nan))), 1.0)
    assert newest["jaw"].tolist() == [0.3]
    assert newest["force"].tolist() == [1.0, 2.0, 3.0]
    assert "velocity" not in newest
