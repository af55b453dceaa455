"""The interfaces around the haptic node, seen by a ROS 2 client: frames, models, markers, diagnostics, gains."""

import os
import time
from types import SimpleNamespace

import numpy as np
import pytest

from palpate import Session
from palpate.arm import Arm
from palpate.scene import Scene
from palpate_lab.verify.bench import ros_stand as bench


class Publisher:
    """Counts messages beside a number of subscribers."""

    def __init__(self, topic):
        self.topic, self.listeners, self.messages = topic, 0, []

    def get_subscription_count(self):
        return self.listeners

    def publish(self, message):
        self.messages.append(message)


def test_what_nobody_hears_is_not_made(built):
    """Frames, joint states and markers are published 30 times a second, each one to those who listen to it."""
    from builtin_interfaces.msg import Time

    from palpate.ros.around.frames import Frames
    from palpate.ros.around.markers import Markers

    session, made = Session(Scene.parse("objects: [{name: wall, plane: {}}]\nduration: 0.01")), {}
    session.run()
    clock = SimpleNamespace(now=lambda: SimpleNamespace(to_msg=Time))
    node = SimpleNamespace(
        create_publisher=lambda kind, topic, qos: made.setdefault(topic, Publisher(topic)), get_clock=lambda: clock
    )
    names = SimpleNamespace(leader="MTMR", follower="")
    plant = SimpleNamespace(loop=SimpleNamespace(names=names))
    frames, markers = Frames(node, session, plant), Markers(node, session)

    def new():
        before = {topic: len(one.messages) for topic, one in made.items()}
        frames.show(session.latest()), markers.show(session.latest())
        return {topic for topic, one in made.items() if len(one.messages) > before[topic]}

    assert new() == set()
    for topic in ("/tf", "~/markers", "~/MTMR/joint_states", "~/objects"):
        made[topic].listeners = 1
        assert new() == {topic}
        made[topic].listeners = 0
    made["~/objects"].listeners = 1
    assert new() == set(), "objects are drawn once, and again when the scene is another"
    markers.draw_objects()
    assert new() == {"~/objects"}
    assert {t.child_frame_id for t in made["/tf"].messages[0].transforms} >= {"MTMR_handle", "virtual_tool"}


@pytest.fixture(scope="module")
def stand(native):
    return bench.Stand(native, f"SEEN{os.getpid()}")


@pytest.fixture(scope="module")
def node(stand, tmp_path_factory):
    node = bench.Node(stand, tmp_path_factory.mktemp("around"))
    try:
        stand.press(60.0)
        yield node
    finally:
        node.process.terminate()
        node.process.wait(20)


@pytest.fixture(scope="module")
def client(node, rclpy):
    """A client that subscribes to everything published except the forces."""
    from diagnostic_msgs.msg import DiagnosticArray
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from sensor_msgs.msg import JointState
    from std_msgs.msg import String
    from tf2_msgs.msg import TFMessage
    from visualization_msgs.msg import MarkerArray

    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

    class Client:
        def __init__(self):
            self.node, self.heard = rclpy.create_node(f"client_{os.getpid()}"), {}
            for topic, kind, qos in (
                ("/tf", TFMessage, 10),
                ("/diagnostics", DiagnosticArray, 10),
                ("/palpate/markers", MarkerArray, 10),
                ("/palpate/objects", MarkerArray, latched),
                ("/palpate/scene", String, latched),
                ("/palpate/virtual/joint_states", JointState, 10),
                ("/palpate/virtual/robot_description", String, latched),
            ):
                self.node.create_subscription(kind, topic, lambda m, t=topic: self.heard.update({t: m}), qos)

        def get(self, topic, accept=lambda m: True, seconds=15.0):
            end = time.monotonic() + seconds
            if not topic.endswith(("objects", "scene", "robot_description")):  # latched topics are published once
                self.heard.pop(topic, None)
            while not (topic in self.heard and accept(self.heard[topic])):
                assert time.monotonic() < end, f"no accepted message on {topic}"
                rclpy.spin_once(self.node, timeout_sec=0.05)
            return self.heard[topic]

        def call(self, kind, name, request, seconds=15.0):
            service = self.node.create_client(kind, name)
            assert service.wait_for_service(seconds), name
            future = service.call_async(request)
            rclpy.spin_until_future_complete(self.node, future, timeout_sec=seconds)
            assert future.done(), f"{name} does not respond"
            return future.result()

        def set(self, **values):
            from rcl_interfaces.srv import SetParameters
            from rclpy.parameter import Parameter

            changes = [Parameter(k.replace("__", "."), value=v).to_parameter_msg() for k, v in values.items()]
            answer = self.call(SetParameters, "/palpate/set_parameters", SetParameters.Request(parameters=changes))
            return answer.results[0]

    client = Client()
    yield client
    client.node.destroy_node()


def xyz(v):
    return np.array([v.x, v.y, v.z])


def test_frames_agree_with_the_arm_and_the_scene(client, stand):
    """The tool is about 2 mm inside the wall; the last link of the model agrees with the forward kinematics."""
    tf = client.get("/tf")
    frames = {t.child_frame_id: t for t in tf.transforms}
    assert frames["palpate_object_wall"].header.frame_id == "palpate_world"
    np.testing.assert_allclose(xyz(frames["palpate_object_wall"].transform.translation), [0, -0.387, -0.1288])
    tool = xyz(frames["virtual_tool"].transform.translation)
    assert -0.389 < tool[1] < -0.384
    handle = xyz(frames[f"{stand.leader}_handle"].transform.translation)
    np.testing.assert_allclose(handle, [0, stand.y, 0], atol=1e-9)  # the leader's base is at the origin of W
    joints = np.array(client.get("/palpate/virtual/joint_states").position)
    base = frames["virtual_base"].transform.translation
    tip = np.array(Arm.psm().fk(joints))[:3, 3]
    assert np.linalg.norm(tip) == pytest.approx(np.linalg.norm(tool - xyz(base)), abs=1e-3)
    links = {name for name, t in frames.items() if t.header.frame_id == "virtual_base"}
    assert len(links) >= 6
    assert client.get("/palpate/virtual/robot_description", seconds=5.0).data.startswith("<?xml")


def test_markers_show_the_sent_force(client, stand):
    stand.press()
    newest = client.get("/palpate/markers", lambda m: any(k.ns == "force_spatial" and k.points for k in m.markers))
    drawn = {m.ns: m for m in newest.markers}
    assert set(drawn) == {"force_body", "force_spatial", "deflection", "tool", "proxy", "contacts"}
    arrow = drawn["force_spatial"]
    length = xyz(arrow.points[1]) - xyz(arrow.points[0])
    np.testing.assert_allclose(length / 0.06, stand.mock_leader.wrenches[-1, 3:6], atol=0.05)
    assert (arrow.color.g, arrow.color.r) == (pytest.approx(0.51), 0.0)
    assert drawn["force_body"].color.r > 0.7
    assert drawn["contacts"].color.r > 0.7
    assert len(drawn["contacts"].points) == 1
    assert xyz(drawn["contacts"].points[0])[1] == pytest.approx(-0.387, abs=1e-4)
    mesh = client.get("/palpate/objects").markers[-1]
    assert mesh.ns == "object_wall"
    assert len(mesh.points) % 3 == 0
    assert mesh.frame_locked


def test_diagnostics_report_rates_energy_and_conditions_against_a_force(client, stand):
    stand.press()
    status = client.get("/diagnostics", lambda d: d.status[0].message == "free to push").status[0]
    values = {v.key: v.value for v in status.values}
    assert status.level == b"\x00"
    assert float(values["leader rate [Hz]"]) == pytest.approx(bench.RATE, rel=0.2)
    assert 0.3 < float(values["force [N]"]) < 1.0
    assert float(values["force cap [N]"]) == 1.0
    stand.inject(zero_stamp=True)
    client.get("/diagnostics", lambda d: d.status[0].level == b"\x01" and "stamp" in d.status[0].message)
    stand.press()


def test_gain_changes_the_force_and_invalid_gains_are_rejected(client, stand):
    """Force over penetration is the set stiffness; rejected values have no effect."""
    from rcl_interfaces.srv import DescribeParameters

    def unhindered(message):  # a shift of the tool, which pauses leave on a busy machine, withholds nothing
        return message == "free to push" or message.startswith("a pause has shifted the tool")

    def felt():
        status = client.get("/diagnostics", lambda d: unhindered(d.status[0].message)).status[0]
        values = {v.key: v.value for v in status.values}
        return float(values["force [N]"]) / (1e-3 * float(values["penetration [mm]"]))

    stand.press()
    assert client.set(wall__stiffness=150.0).successful
    time.sleep(0.5)
    assert felt() == pytest.approx(150.0, rel=0.02)
    assert "150" in client.get("/palpate/scene", lambda m: "150" in m.data).data
    refused = client.set(wall__stiffness=90_000.0)
    assert not refused.successful
    assert "more than the caps allow" in refused.reason
    assert not client.set(wall__stiffness=-1.0).successful  # out of range
    assert not client.set(stiffness_scale=7.0).successful
    time.sleep(0.3)
    assert felt() == pytest.approx(150.0, rel=0.02)
    assert client.set(wall__stiffness=300.0).successful
    names = DescribeParameters.Request(names=["wall.stiffness", "stiffness_scale"])
    descriptors = client.call(DescribeParameters, "/palpate/describe_parameters", names).descriptors
    assert "N/m" in descriptors[0].description
    assert descriptors[1].floating_point_range[0].to_value == 2.0


def test_scene_is_replaced_as_a_whole_or_rejected_with_a_reason(client, stand, node, tmp_path):
    from std_srvs.srv import Trigger

    stand.press()
    other, broken = tmp_path / "other.yaml", tmp_path / "broken.yaml"
    other.write_text(bench.scene().replace("name: wall", "name: ceiling").replace("y: -0.387", "y: -0.5"))
    broken.write_text(bench.scene().replace("stiffness: 300", "stifness: 300"))
    assert client.set(scene_file=str(broken)).successful
    answer = client.call(Trigger, "/palpate/load_scene", Trigger.Request())
    assert not answer.success
    assert "stifness" in answer.message
    assert stand.force() > 0.3
    assert client.set(scene_file=str(other)).successful
    begin = time.monotonic()
    answer = client.call(Trigger, "/palpate/load_scene", Trigger.Request())
    assert answer.success, answer.message
    assert "ceiling" in answer.message
    time.sleep(0.3)
    assert stand.steepest(begin) <= 1.001 * bench.RATE_CAP
    node.output.await_line("ceiling")
    assert [m.ns for m in client.get("/palpate/objects", lambda m: m.markers[-1].ns == "object_ceiling").markers[1:]]
