"""Two hands on a simulated dVRK: instruments that meet, one console, as a client of the robot sees them."""

import json
import os
import time

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from palpate.arm import Arm
from palpate.ros.background import BackgroundNode
from palpate.scene import Scene
from palpate.session import PairsSession

RATE = 100
Q_PSM = np.array([0.0, 0.0, 0.12, 0.0, 0.0, 0.0])
ARMS = {"right": ("MTMR", "PSM1", 1.0), "left": ("MTML", "PSM2", -1.0)}
CAP = 0.6  # [N]
APART = 0.03  # distance of the tips at the start [m]


def scene_text():
    """Both tips on the x axis, `APART` apart, each with its shaft from its own side."""
    pairs = {}
    tip = Arm.psm("lnd").fk(Q_PSM)
    for name, (leader, follower, side) in ARMS.items():
        X_WT = np.eye(4)  # the instrument points down and to the other side
        X_WT[:3, :3] = Rotation.from_euler("y", side * 40.0, degrees=True).as_matrix() @ tip[:3, :3]
        X_WT[:3, 3] = [side * 0.5 * APART, 0.0, 0.0]
        X_WB = X_WT @ np.linalg.inv(tip)
        rpy = Rotation.from_matrix(X_WB[:3, :3]).as_euler("xyz", degrees=True)
        at = X_WT[:3, 3].tolist()
        pairs[name] = {
            "devices": {"leader": leader, "follower": follower, "teleop": "none"},
            "arms": {
                "leader": {"model": f"mtm_{name}", "base": {"xyz": [0.4 * side, 0.3, 0.2]}, "start": [0.0] * 7},
                "follower": {"model": "psm_lnd", "base": {"xyz": X_WB[:3, 3].tolist(), "rpy_deg": rpy.tolist()}},
            },
            "operator": {"path": [{"t": 0, "xyz": at}, {"t": 1, "xyz": at}]},
        }
    return json.dumps({
        "objects": [{"name": "table", "plane": {}, "pose": {"xyz": [0, 0, -0.1]}, "stiffness": 300}],
        "mapping": {"scale": 1.0}, "rates": {"haptic": RATE}, "stability": {"force_cap": 3, "passivity": "off"},
        "instruments": {"stiffness": 300, "damping": 0}, "pairs": pairs, "record": {"report": False},
    })  # fmt: skip


class Client(BackgroundNode):
    """A client of the robot: it homes the arms, moves the hands and receives all wrenches on both leaders."""

    def __init__(self, domain):
        super().__init__(f"client_{os.getpid()}", domain)
        from crtk_msgs.msg import OperatingState
        from geometry_msgs.msg import PoseStamped, WrenchStamped
        from rclpy.qos import DurabilityPolicy, QoSProfile

        self.forces, self.homed, self.poses, self._publishers = {name: [] for name in ARMS}, {}, {}, {}
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

        def subscribe(kind, topic, take, qos=10):
            self.node.create_subscription(kind, topic, take, qos)

        for name, (leader, follower, _) in ARMS.items():
            for arm in (leader, follower):
                topic = f"/{arm}/operating_state"
                subscribe(OperatingState, topic, lambda m, arm=arm: self._state(arm, m), latched)
            subscribe(PoseStamped, f"/{leader}/measured_cp", lambda m, leader=leader: self.poses.update({leader: m}))
            subscribe(WrenchStamped, f"/{leader}/body/servo_cf", lambda m, name=name: self._wrench(name, m), 100)
        self.spin()

    def _state(self, arm, m):
        self.homed[arm] = m.is_homed and not m.is_busy

    def _wrench(self, name, m):
        self.forces[name].append([m.wrench.force.x, m.wrench.force.y, m.wrench.force.z])

    def publish(self, topic, message):
        """Publish a message once the topic has a subscriber."""
        if topic not in self._publishers:
            self._publishers[topic] = self.node.create_publisher(type(message), topic, 10)
        self.wait(self._publishers[topic].get_subscription_count, f"a subscriber of {topic}")
        self._publishers[topic].publish(message)

    @staticmethod
    def wait(condition, description, seconds=60.0):
        """Wait until a condition holds."""
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, f"timeout: {description}"
            time.sleep(0.01)

    def press(self, topic, down=True):
        """Press or release a pedal."""
        from sensor_msgs.msg import Joy

        self.publish(topic, Joy(buttons=[int(down)]))

    def push(self, force, most=0.04):
        """Move the right hand towards the left instrument, up to this force or farthest displacement [m]."""
        goal = self.poses["MTMR"]
        for x in np.arange(goal.pose.position.x, goal.pose.position.x - most, -0.0005):
            goal.pose.position.x = float(x)
            self.publish("/MTMR/hand/servo_cp", goal)
            seen = len(self.forces["right"])
            self.wait(lambda seen=seen: len(self.forces["right"]) > seen + 2, "wrenches")
            if np.linalg.norm(self.now()[0]) >= force:
                break

    def opposite(self):
        """Smaller force of both hands, if they are opposite within 10 % [N]; else 0."""
        right, left = self.now()
        small = min(np.linalg.norm(right), np.linalg.norm(left))
        return small if np.linalg.norm(right + left) < 0.1 * small else 0.0

    def now(self):
        """Newest forces of right and left hand (2, 3)."""
        return np.array([self.forces[name][-1] for name in ("right", "left")])


@pytest.fixture(scope="module")
def client(built):
    """A homed robot of four arms in this process, whose head sensor reports the operator, and its client."""
    from std_msgs.msg import Empty

    from palpate.ros import sim

    robot = sim.start(("MTMR", "MTML", "PSM1", "PSM2"), rate=RATE, head_sensor=True)
    with Client(int(os.environ["ROS_DOMAIN_ID"])) as client:
        client.publish("/system/power_on", Empty())
        client.publish("/system/home", Empty())
        client.wait(lambda: len(client.homed) == 4 and all(client.homed.values()), "all arms homed")
        yield client
    robot.stop()


@pytest.fixture
def pairs(client, tmp_path):
    """Both pairs, following, with the console's topics; the left hand holds its handle."""
    from palpate.ros.around import Around
    from palpate.ros.haptics import Limits
    from palpate.ros.pairs import plants_of
    from palpate.ros.pedal_topics import PedalTopics

    scene = Scene.parse(scene_text())
    plants = plants_of(scene, Limits(CAP, RATE))
    with PairsSession(scene, tmp_path, plants=plants) as pairs, PedalTopics(pairs.console, domain(pairs)):
        around = [Around(session, pair=name) for name, session in pairs.pairs.items()]
        pairs.start()
        client.publish("/MTML/hand/servo_cp", client.poses["MTML"])
        client.press("/console/emulate_operator_present")
        client.wait(lambda: all(len(f) > 20 for f in client.forces.values()), "wrenches of both pairs")
        yield pairs
        for one in around:
            one.close()


def test_two_hands_feel_opposite_forces_below_the_cap(client, pairs):
    assert not client.now().any(), "the instruments do not touch yet"
    client.push(0.4)
    client.wait(lambda: client.opposite() > 0.2, f"opposite forces at rest; newest: {client.now()}")
    right, left = client.now()
    assert right[0] > 0.0 > left[0], "each is pushed back to its own side"
    check_console(client, pairs)
    check_graph()
    client.push(0.99 * CAP)
    forces = np.concatenate([np.linalg.norm(np.array(f), axis=1) for f in client.forces.values()])
    assert CAP * 0.98 < forces.max() <= CAP + 1e-9
    check_tool(client, pairs)
    summaries = pairs.close().pairs
    client.wait(lambda: not client.now().any(), "zero last")
    client.wait(lambda: not any("writer" in name for name in client.node.get_node_names()), "the writers are gone")
    assert all(one.timing["published"] > 0 and one.latest()["t"] > 0.0 for one in pairs.pairs.values())
    assert all(os.path.isfile(one.record) for one in summaries.values())


def domain(pairs):
    return next(iter(pairs.pairs.values())).plant.loop.context.domain


def check_tool(client, pairs):
    """Another instrument on one arm makes its pair hold, until the first one is mounted again and somebody resumes."""
    from std_msgs.msg import String

    right, left = pairs.pairs.values()
    arm = right.plant.devices.follower
    client.publish(f"/{arm}/set_tool_type", String(data="PROGRASP_FORCEPS_400093"))
    client.wait(lambda: right.state.session == "hold", "a hold")
    assert left.state.session != "hold"
    assert f"{arm} has another instrument, PROGRASP_FORCEPS_400093 instead of" in right.plant.events[-1]


def check_console(client, pairs):
    """Pedals and head sensor of the robot act on both hands, and arrive at the one console."""
    pedals = pairs.console.pedals
    assert pedals["operator"]
    assert not any(pedals[name] for name in ("clutch", "camera", "coag"))
    client.press("/footpedals/emulate_coag")
    client.wait(lambda: pairs.console.pedals["coag"], "the coagulation pedal")
    assert pairs.console.present, "the head sensor reports presence, not this pedal"
    client.press("/console/emulate_clutch")
    client.wait(lambda: not client.now().any() and pairs.console.pedals["clutch"], "no force on either hand")
    client.wait(lambda: {one.state.session for one in pairs.pairs.values()} == {"clutched"}, "both clutched")
    client.press("/console/emulate_clutch", False)
    client.wait(lambda: client.opposite() > 0.02, "the force is back on both hands")
    client.press("/console/emulate_operator_present", False)
    client.wait(lambda: not (pairs.console.present or client.now().any()), "the head has left: no force")
    client.press("/console/emulate_operator_present")
    client.wait(lambda: client.opposite() > 0.01, "the force is back on both hands")


def check_graph():
    """Two nodes never share a name, and two pairs never share a topic."""
    from palpate.ros import graph, rviz
    from palpate.ros.pairs import devices_of

    wanted = {"/palpate_console", "/right/palpate", "/left/palpate", "/right/palpate_haptics_MTMR"}
    end = time.monotonic() + 30.0
    found = graph.measure(0.2)
    while not wanted <= {node.name for node in found.nodes} and time.monotonic() < end:  # discovery takes a while
        found = graph.measure(1.0)
    assert wanted <= {node.name for node in found.nodes}
    assert found.duplicate_nodes == []
    assert found.shared_topics == []
    topics = {one.name: one for one in found.topics}
    measured = topics["/MTMR/measured_cp"]
    assert measured.messages > 0
    assert "/right/palpate_haptics_MTMR" in measured.subscribers
    assert topics["/right/palpate/markers"].publishers == ["/right/palpate"]
    scene = Scene.parse(scene_text())
    shown = rviz.topics(yaml.safe_load(yaml.safe_dump(rviz.config(scene, devices_of(scene)))))
    assert len(shown) == 7
    assert [name for name in shown if name not in topics] == [], "topics of the configuration of RViz"


def test_nodes_that_share_a_topic_are_found():
    from palpate.ros import graph

    def topic(name, *nodes):
        return graph.TopicFacts(name, "", list(nodes), [], 0, None, None, None)

    assert not graph.is_shared(topic("/MTMR/body/servo_cf", "/palpate_guardian_1_a", "/palpate_writer_1_a"))
    assert graph.is_shared(topic("/MTMR/body/servo_cf", "/palpate_writer_1_a", "/palpate_writer_2_b"))
    assert graph.is_shared(topic("/palpate/markers", "/palpate", "/other"))
    assert not graph.is_shared(topic("/tf", "/left/palpate", "/right/palpate"))
