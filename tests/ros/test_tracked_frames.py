"""Trackers on PoseStamped topics of another process, through the gate; and the frames of a scene on /tf."""

import os
import time
from pathlib import Path

import numpy as np
import pytest

from palpate import Session
from palpate.scene import Scene
from palpate_lab.verify.bench import ros_stand as bench

HERE = Path(__file__).parent
FRAMES = """
frames:
  - {child: camera, pose: {xyz: [0.1, 0.2, 0.3], rpy_deg: [0, 0, 90]}}
  - {child: tracker, pose: {xyz: [0, 0, 1]}, sigma_mm: 0.3}
  - {parent: tracker, child: patient, tracker: polaris, tool: marker, pose: {xyz: [0, 0, -1]}}
  - {parent: patient, child: anatomy, pose: {xyz: [0, 0.05, 0]}}
trackers: {polaris: {topic: "/polaris/{tool}/measured_cp", fade: 0.2}}
"""
TOPIC = "/polaris/marker/measured_cp"


@pytest.fixture(scope="module")
def poses(start_once):
    """Publisher in another process; a call sets the pose of a topic."""
    process = start_once(HERE / "pose_publisher.py", 50)
    assert process.stdout.readline().strip() == "ready"

    def put(*words):
        process.stdin.write(f"{TOPIC} {' '.join(map(str, words))}\n")
        process.stdin.flush()

    return put


def wait(condition, description, seconds=20.0):
    end = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < end, f"timeout: {description}"
        time.sleep(0.02)
    return value


def test_poses_of_a_topic_pass_the_gate_and_move_the_object(poses):
    """A session follows the topic; a jump, old or zero stamps and silence leave the object where it is."""
    text = FRAMES + "objects: [{name: block, box: {size: [0.1, 0.1, 0.04]}, frame: anatomy}]\n"
    poses(0, 0, -1, 0)
    session = Session(Scene.parse(text))
    with session:
        session.start()
        tracking = session.tracking
        status = lambda: tracking.status(float(session.latest()["t"]))["patient"]  # noqa: E731
        block = lambda: np.array(session.latest()["live_p"][:3])  # noqa: E731
        wait(lambda: status() == "tracked", "tracked")
        assert block() == pytest.approx([0, 0.05, 0], abs=1e-4)
        poses(0.002, 0, -1, 5)
        centre = np.array([0.002 - 0.05 * np.sin(np.radians(5)), 0.05 * np.cos(np.radians(5)), 0.0])
        near = lambda: np.linalg.norm(block() - centre) < 4e-4  # noqa: E731
        wait(near, "the block follows")
        # A pose that steps is followed like a motion, with some overshoot: the block rests when it has stayed there.
        wait(lambda: all((time.sleep(0.02), near())[1] for _ in range(50)), "the block rests")
        at = block()
        for wrong, words in (((0.1, 0, -1, 5), "jumped"), ((0.002, 0, -1, 5, "back"), "stamp goes backwards"),
                             ((0.002, 0, -1, 5, "zero"), "invalid"), (("off",), "lost for")):  # fmt: skip
            poses(*wrong)
            wait(lambda words=words: "lost" in status() and words in status(), words)
            assert np.linalg.norm(block() - at) < 4e-4
        wait(lambda: session.latest()["live_share"][0] == 0.0, "the force fades")
        poses(0.002, 0, -1, 5)
        wait(lambda: status() == "tracked", "tracked again")


@pytest.fixture(scope="module")
def node(native, poses, tmp_path_factory):
    poses(0, 0, -1, 0)
    wall = bench.scene().replace("pose: {xyz: [0, -0.387, -0.1288], rpy_deg: [-90, 0, 0]}", "POSE")
    assert "POSE" in wall
    at = "frame: anatomy, pose: {xyz: [0, -0.437, -0.1288], rpy_deg: [-90, 0, 0]}"
    stand = bench.Stand(native, f"TRACKED{os.getpid()}")
    node = bench.Node(stand, tmp_path_factory.mktemp("tracked"), text=FRAMES + wall.replace("POSE", at))
    node.output.await_line("guardian")
    yield node
    node.end()


def test_frames_of_the_scene_are_on_tf(node, poses, rclpy):
    """Known and registered frames latched on /tf_static, the tracked one and its object on /tf at 30 Hz at most."""
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from tf2_msgs.msg import TFMessage

    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    here, still, live, times = rclpy.create_node(f"tf_{os.getpid()}"), {}, {}, []

    def take(message):
        times.append(time.monotonic())
        live.update({t.child_frame_id: t for t in message.transforms})

    here.create_subscription(
        TFMessage, "/tf_static", lambda m: still.update({t.child_frame_id: t for t in m.transforms}), latched
    )
    here.create_subscription(TFMessage, "/tf", take, 10)

    def until(condition, description, seconds=20.0):
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, description
            rclpy.spin_once(here, timeout_sec=0.05)

    def place(t):
        p, q = t.transform.translation, t.transform.rotation
        return t.header.frame_id, [p.x, p.y, p.z], [q.x, q.y, q.z, q.w]

    until(lambda: len(still) == 3 and "palpate_frame_patient" in live, "tf")
    assert set(still) == {"palpate_frame_camera", "palpate_frame_tracker", "palpate_frame_anatomy"}
    assert place(still["palpate_frame_camera"])[0] == "palpate_world"
    assert place(still["palpate_frame_camera"])[1] == pytest.approx([0.1, 0.2, 0.3])
    assert place(still["palpate_frame_camera"])[2] == pytest.approx([0, 0, np.sqrt(0.5), np.sqrt(0.5)])
    assert place(still["palpate_frame_anatomy"])[:2] == ("palpate_frame_patient", pytest.approx([0, 0.05, 0]))
    assert "palpate_frame_patient" not in still
    assert not {name for name in live if name.startswith("palpate_frame_")} - {"palpate_frame_patient"}
    poses(0.003, 0, -1, 0)
    until(
        lambda: place(live["palpate_frame_patient"])[:2] == ("palpate_frame_tracker", pytest.approx([0.003, 0, -1])),
        "live",
    )
    until(lambda: place(live["palpate_object_wall"])[1] == pytest.approx([0.003, -0.387, -0.1288], abs=4e-4), "object")
    begin, times[:] = time.monotonic(), []
    until(lambda: time.monotonic() > begin + 3.0, "three seconds")
    assert len(times) <= 10 + 3 * 31, "30 Hz, and at most ten that had waited in the queue"
    here.destroy_node()
