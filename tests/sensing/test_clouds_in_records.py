"""A record holds the frames of sensors: other tools read them, and a run on them feels what the run felt."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import palpate
from palpate.base.errors import SceneError
from palpate.record import edit
from palpate.record.snapshots import CLOUD_QUANTUM
from palpate.sensing.replay import ReplaySource
from palpate.sensing.source import CloudFrame

TOPIC = "/sensors/seen/points"
DURATION = 1.5


def camera(sensor, **record):
    """The shipped scene with this sensor."""
    scene = yaml.safe_load(Path(palpate.Scene.load("camera").file).read_text())
    scene["sensors"]["camera"] = {**sensor, "pose": scene["sensors"]["camera"]["pose"]}
    return {**scene, "record": record}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The summary of a run with a simulated camera, and the frames that its objects got."""
    seen = {"simulated": {"rows": 96, "columns": 128, "noise_mm": 0.0, "step_mm": 0.0, "dropout": 0.02}}
    session = palpate.Session(camera(seen, sensors=True), out=tmp_path_factory.mktemp("runs"))
    got, keep = [], session.sensing.keep
    session.sensing.keep = lambda name, frame, now: (got.append((frame, now)), keep(name, frame, now))
    return session.run(DURATION), got


def messages(record, topic):
    with open(record, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return [one.decoded_message for one in reader.iter_decoded_messages(topics=[topic])]


def test_another_reader_finds_each_frame_with_the_pose_of_the_camera(run):
    summary, got = run
    clouds = messages(summary.record, TOPIC)
    assert len(clouds) == len(got) == pytest.approx(30 * DURATION, abs=2)
    poses = [
        transform
        for message in messages(summary.record, "/tf")
        for transform in message.transforms
        if transform.child_frame_id == "palpate_sensor_seen"
    ]
    assert len(poses) == len(got)
    for cloud, pose, (frame, _) in itertools.islice(zip(clouds, poses, got, strict=True), 0, None, 7):
        assert (cloud.height, cloud.width) == frame.points.shape[:2]
        assert cloud.header.frame_id == pose.child_frame_id
        assert cloud.header.stamp.sec + 1e-9 * cloud.header.stamp.nanosec == pytest.approx(frame.t, abs=1e-8)
        data = np.frombuffer(bytes(cloud.data), np.uint8).reshape(-1, cloud.point_step)
        read = np.ascontiguousarray(data[:, :12]).view("<f4").reshape(frame.points.shape)
        np.testing.assert_allclose(read, frame.points, rtol=0, atol=0.5 * CLOUD_QUANTUM)
        moved = pose.transform.translation
        np.testing.assert_allclose([moved.x, moved.y, moved.z], frame.X_WC[:3, 3], atol=1e-12)


def test_the_recorded_frames_can_be_touched_again(run, tmp_path):
    """A replay gives each frame at its time; a scene that knows of the organ only what the record holds feels it."""
    summary, got = run
    source = ReplaySource(Path(summary.record), topic=TOPIC)
    for frame, _ in got[:-1]:  # asked just before the next one is due
        again = source.latest(frame.t - got[0][0].t + 0.01)
        np.testing.assert_allclose(again.points, frame.points.reshape(again.points.shape), rtol=0, atol=CLOUD_QUANTUM)
    before = palpate.Record.open(summary.record)
    scene = camera({"replay": str(summary.record), "topic": TOPIC})
    scene["objects"] = [one for one in scene["objects"] if one["name"] == "seen"]
    path = zip(before["t"][::20].tolist(), before["p_WT"][::20].tolist(), strict=True)
    scene["operator"] = {"path": [{"t": t, "xyz": p} for t, p in path]}
    assert palpate.Session(scene, out=tmp_path).run(DURATION).peak_force_N > 0.3 * summary.peak_force_N > 0.03


def test_a_part_of_a_record_holds_the_frames_of_its_time(run, tmp_path):
    summary, got = run
    edit.copy([Path(summary.record)], tmp_path / "part.mcap", 0.5, 1.0)
    assert len(messages(tmp_path / "part.mcap", TOPIC)) == sum(0.5 <= now < 1.0 for _, now in got)


def test_nothing_is_kept_unless_it_is_asked_for(tmp_path):
    seen = {"simulated": {"rows": 48, "columns": 64}}
    summary = palpate.Session(camera(seen), out=tmp_path).run(0.2)
    assert not messages(summary.record, TOPIC)
    with pytest.raises(SceneError, match="sensors needs frames"):
        palpate.Scene.model_validate(camera(seen, sensors=True, frames=False))


def test_colours_and_clouds_without_rows_are_kept(tmp_path):
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.02, 0.02, (200, 3))
    colors = rng.integers(0, 256, (200, 3), dtype=np.uint8)
    frames = (CloudFrame(points, 0.03 * k, colors=colors) for k in range(20))
    scene = {"objects": [{"name": "a cloud", "cloud": {"sensor": "mine"}}], "record": {"sensors": True}}
    session = palpate.Session(scene, out=tmp_path, clouds={"mine": frames})
    (cloud, *_) = messages(session.run(0.3).record, "/sensors/a_cloud/points")
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "rgb"]
    data = np.frombuffer(bytes(cloud.data), np.uint8).reshape(-1, cloud.point_step)
    np.testing.assert_array_equal(data[:, 12:15], colors[:, ::-1])


def test_frames_that_are_none_are_left_out_and_empty_ones_are_kept(tmp_path):
    """A stream that talks nonsense ends neither the run nor its record; what is left out is told by the stream."""
    points = np.random.default_rng(0).uniform(-0.02, 0.02, (200, 3))
    scaled = np.diag([2.0, 2.0, 2.0, 1.0])
    frames = [
        CloudFrame(points[:, :2], 0.0),
        CloudFrame(points, 0.0, X_WC=scaled),
        CloudFrame(points, 0.0, X_WC=np.full((4, 4), np.nan)),
        CloudFrame(points, math.nan),
        CloudFrame(points, 1e12),
        CloudFrame(points[0], 0.0),
        CloudFrame(np.full((4, 5, 3), np.nan), 0.2),
        CloudFrame(np.zeros((0, 3)), 0.24),
        CloudFrame(points, 0.27, colors=np.zeros((7, 3), np.uint8)),
        CloudFrame((1000 * points).astype(int), 0.3),
    ]
    scene = {"objects": [{"name": "one", "cloud": {"sensor": "mine"}}], "record": {"sensors": True}}
    summary = palpate.Session(scene, out=tmp_path, clouds={"mine": iter(frames)}).run(0.6)
    kept = messages(summary.record, "/sensors/one/points")
    assert [(cloud.height, cloud.width, cloud.point_step) for cloud in kept] == [
        (4, 5, 12), (1, 0, 12), (1, 200, 12), (1, 200, 12)
    ]  # fmt: skip
    again = ReplaySource(Path(summary.record), topic="/sensors/one/points")
    assert again.latest(0.0).points.shape == (4, 5, 3)
    assert again.latest(1.0).points.shape == (200, 3)


def test_of_several_pairs_one_keeps_the_frames(tmp_path):
    scene = yaml.safe_load(Path(palpate.Scene.load("two_hands").file).read_text())
    points = np.random.default_rng(0).uniform(-0.005, 0.005, (400, 3)) + np.array([0.0, 0.0, 0.3])
    np.savetxt(tmp_path / "0.xyz", points)
    np.savetxt(tmp_path / "1.xyz", points + 1e-4)
    scene["sensors"] = {"camera": {"replay": str(tmp_path), "unit": "m", "repeat": True}}
    scene["objects"].append({"name": "seen", "cloud": {"sensor": "camera"}, "stiffness": 200})
    scene["record"] = {"sensors": True}
    summary = palpate.PairsSession(scene, out=tmp_path / "runs").run(0.5)
    counts = [len(messages(one.record, "/sensors/seen/points")) for one in summary.pairs.values()]
    assert counts == [pytest.approx(15, abs=1), 0]
