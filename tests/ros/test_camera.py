"""`palpate ros camera` in its own process, received by a node here and by a source of clouds; and felt by a session."""

import time

import numpy as np
import pytest

from palpate import Session
from palpate.scene import Scene
from palpate.sensing import messages
from palpate.sensing.ros_cloud import RosCloudSource

CAMERA = """
sensors:
  camera: {simulated: {columns: 160, rows: 120, noise_mm: 0.2, step_mm: 0, instrument: false},
           pose: {xyz: [0.01, 0, 0.4], rpy_deg: [180, 0, 0]}}
objects: [{name: block, box: {size: [0.2, 0.2, 0.04]}, presence: real}, {name: other, sphere: {radius: 0.01},
          pose: {xyz: [0.5, 0, 0]}}]
"""
FELT = """
objects: [{name: seen, cloud: {topic: /camera/depth/points, region: 0.1}, stiffness: 300}]
contact: {radius: 0.004}
arms:
  leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
  follower: {bandwidth: 0, base: {xyz: [-0.120, -0.060, 0.155], rpy_deg: [0, 0, 205]}}
operator: {path: [{t: 0.2, xyz: [0, 0, 0.03]}, {t: 1.0, xyz: [0, 0, 0.022]}, {t: 30.0, xyz: [0, 0, 0.022]}]}
"""


@pytest.fixture(scope="module")
def camera(start_once, tmp_path_factory):
    """The publishing process."""
    scene = tmp_path_factory.mktemp("camera") / "camera.yaml"
    scene.write_text(CAMERA)
    process = start_once("-m", "palpate", "ros", "camera", scene)
    lines = []
    for line in process.stdout:
        lines.append(line)
        if "Ctrl-C" in line:
            return process
    pytest.fail("".join([*lines, process.stderr.read()]))


def test_another_process_receives_cloud_image_info_and_frame(camera, node, until):
    from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
    from sensor_msgs.msg import CameraInfo, Image, PointCloud2
    from tf2_msgs.msg import TFMessage

    got = {}
    for kind, topic in ((PointCloud2, "points"), (Image, "image_rect_raw"), (CameraInfo, "camera_info")):
        node.create_subscription(
            kind, f"/camera/depth/{topic}", lambda m, topic=topic: got.update({topic: m}), qos_profile_sensor_data
        )
    latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(TFMessage, "/tf_static", lambda m: got.update(tf=m.transforms[0]), latched)
    until(lambda: len(got) == 4, "all topics", 30.0)
    decoded, info = messages.decode(got["points"]), got["camera_info"]
    p = decoded.points.reshape(-1, 3)
    seen = np.isfinite(p).all(axis=1)
    assert decoded.points.shape == (120, 160, 3)
    assert np.median(p[seen, 2]) == pytest.approx(0.38, abs=1e-3)  # the block's top, 0.02 m above its middle
    assert got["tf"].child_frame_id == got["points"].header.frame_id == "palpate_sensor_camera"
    assert got["tf"].transform.translation.z == pytest.approx(0.4)
    depth = np.frombuffer(bytes(got["image_rect_raw"].data), np.float32).reshape(120, 160)
    v, u = 60, 80
    while not np.isfinite(depth[v, u]):
        u += 1
    K = np.array(info.k).reshape(3, 3)
    ray = np.linalg.solve(K, [u, v, 1.0])
    assert depth[v, u] * ray == pytest.approx(depth[v, u] * np.array([(u - 79.5) / K[0, 0], (v - 59.5) / K[1, 1], 1]))
    assert np.nanmedian(depth) == pytest.approx(0.38, abs=1e-3)


def test_the_source_takes_the_pose_from_tf(camera):
    source = RosCloudSource("/camera/depth/points")
    try:
        end = time.monotonic() + 30.0
        while (frame := source.latest(7.0)) is None:
            assert time.monotonic() < end, source.fault
            time.sleep(0.01)
        assert frame.X_WC[:3, 3] == pytest.approx([0.01, 0, 0.4])
        p = frame.points.reshape(-1, 3)
        p_W = p[np.isfinite(p).all(axis=1)] @ frame.X_WC[:3, :3].T + frame.X_WC[:3, 3]
        assert np.median(p_W[:, 2]) == pytest.approx(0.02, abs=1e-3)
        assert 0.0 <= 7.0 - frame.t < 1.0
        assert len(frame.colors) == len(p)
    finally:
        source.close()


def test_a_session_feels_the_cloud_of_a_topic(camera):
    with Session(Scene.parse(FELT)) as session:
        session.start()
        end = time.monotonic() + 30.0
        heights = []
        while len(heights) < 20:
            tick = session.latest()
            if tick["contacts"] > 0:
                heights.append(float(tick["p_WP"][2]))
            assert time.monotonic() < end, (session.sensing.status(float(tick["t"])), session.notes)
            time.sleep(0.02)
    assert np.median(heights) == pytest.approx(0.024, abs=2e-3), heights  # the proxy rests on the block's top
