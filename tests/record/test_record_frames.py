"""Frames, arms and meshes in a record: positions rebuilt from /tf agree with the arms' kinematics."""

import numpy as np
import pytest

from palpate import Record, Session
from palpate.base.arrays.so3 import matrices, pose
from palpate.record.extra import RATE, WORLD
from palpate.scene import Scene

rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="rosbags (test group) is not installed")
from rosbags.typesys import Stores, get_typestore  # noqa: E402

SCENE = """
objects:
  - {name: ball, sphere: {radius: 0.03}, motion: {amplitude: [0, 0, 0.004], period: 1.0}}
operator: {palpate: {object: ball, at: [0, 0, 0.1], force: 1.0, length: 0.01}}
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A run, its record, and every message of the added topics by topic: (time [ns], message)."""
    with Session(Scene.parse(SCENE), out=tmp_path_factory.mktemp("runs")) as session:
        path = session.run(1.5).record
        rig = session.rig
    found = {}
    store = get_typestore(Stores.ROS2_HUMBLE)
    with rosbag2.Reader(Record.open(path).path.parent) as bag:
        wanted = [
            c for c in bag.connections if c.topic in {"/tf", "/tf_static"} or "scene" in c.topic or "desc" in c.topic
        ]
        for connection, time, raw in bag.messages(connections=wanted):
            found.setdefault(connection.topic, []).append((time, store.deserialize_cdr(raw, connection.msgtype)))
    return rig, Record.open(path), found


def X_of(transform):
    t, q = transform.translation, transform.rotation
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = matrices(np.array([[q.w, q.x, q.y, q.z]]))[0], [t.x, t.y, t.z]
    return X


def in_world(frame, *messages):
    """Pose of a frame in W by the chain of transforms, as a viewer computes it."""
    edges = {t.child_frame_id: (t.header.frame_id, X_of(t.transform)) for m in messages for t in m.transforms}
    X = np.eye(4)
    while frame != WORLD:
        frame, step = edges[frame]
        X = step @ X
    return X


def test_positions_rebuilt_from_tf_are_those_of_the_kinematics(recorded):
    rig, record, found = recorded
    ((_, static),) = found["/tf_static"]
    by_time = {round(float(t) * 1e9): k for k, t in enumerate(record.ticks["t"])}
    assert len(found["/tf"]) == pytest.approx(1.5 * RATE, abs=2)
    leader, follower = rig.scene.arm("leader"), rig.scene.arm("follower")
    heights = []
    for time, message in found["/tf"]:
        tick = record.ticks[by_time[time]]
        assert all(t.header.stamp.sec * 10**9 + t.header.stamp.nanosec == time for t in message.transforms)
        for side, arm, base, q in (
            ("leader", leader, rig.arms.X_WL, tick["q"]),
            ("follower", follower, rig.arms.X_WB, tick["q_follower"]),
        ):
            tip = base @ arm.fk(np.array(q[: arm.n]))
            last = arm.link_names[-1]
            to_tip = np.linalg.inv(base @ arm.link_poses(np.array(q[: arm.n]), 0.0)[last]) @ tip
            np.testing.assert_allclose(in_world(f"{side}/{last}", message, static) @ to_tip, tip, atol=1e-12)
        tool = pose(tick["p_WT"], tick["quat_WT"])
        np.testing.assert_allclose(in_world("follower_tool", message, static), tool, atol=1e-12)
        heights.append(in_world("palpate_object_ball", message, static)[2, 3])
        assert heights[-1] == pytest.approx(rig.snapshot.objects[0].pose(float(tick["t"]))[2, 3], abs=1e-12)
    assert np.ptp(heights) > 0.006, "the object moves"
    wrong = in_world(f"leader/{leader.link_names[-1]}", found["/tf"][0][1], static)
    assert not np.allclose(wrong, in_world(f"leader/{leader.link_names[-1]}", found["/tf"][-1][1], static))


def test_markers_and_models_describe_the_scene(recorded):
    rig, _, found = recorded
    ((_, objects),) = found["/scene/objects"]
    (ball,) = objects.markers
    points = np.array([[p.x, p.y, p.z] for p in ball.points])
    assert ball.type == 11
    assert ball.frame_locked
    assert ball.header.frame_id == "palpate_object_ball"
    assert len(points) % 3 == 0
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 0.03, atol=2e-4)
    ((_, arms),) = found["/scene/arms"]
    frames = {t.child_frame_id for t in found["/tf"][0][1].transforms}
    assert {m.header.frame_id for m in arms.markers} <= frames
    assert len(arms.markers) == sum(len(rig.scene.arm(side).visuals) for side in ("leader", "follower")) + 1
    assert all(m.scale.x > 0.0 and m.pose.orientation is not None and m.color.a > 0.0 for m in arms.markers)
    ((_, urdf),) = found["/leader/robot_description"]
    assert urdf.data == rig.scene.arm("leader").urdf


def test_frames_do_not_change_the_signals_or_the_bytes_of_a_second_run(tmp_path):
    scene = Scene.parse(SCENE)
    runs = []
    for k, frames in enumerate((True, True, False)):
        section = scene.record.model_copy(update={"frames": frames})
        with Session(scene.model_copy(update={"record": section}), out=tmp_path / str(k)) as session:
            runs.append(Record.open(session.run(0.6).record))
    assert runs[0].path.read_bytes() == runs[1].path.read_bytes()
    assert runs[0].ticks.tobytes() == runs[2].ticks.tobytes()
    assert len(runs[2].path.read_bytes()) < len(runs[0].path.read_bytes())
