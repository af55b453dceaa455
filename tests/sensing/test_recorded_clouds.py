"""Recorded streams and PointCloud2 messages: round trips, times, and damaged data."""

from types import SimpleNamespace

import numpy as np
import pytest

from palpate.base.errors import CloudError
from palpate.sensing import messages
from palpate.sensing.replay import ReplaySource
from palpate.world.clouds import PointCloud

P = np.arange(24, dtype=np.float32).reshape(2, 4, 3) / 8
C = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)


def message(points=P, colors=C, frame="camera", **more):
    fields, step, data = messages.fields_of(points, colors)
    header = SimpleNamespace(frame_id=frame, stamp=SimpleNamespace(sec=1, nanosec=0))
    named = [SimpleNamespace(name=n, offset=o, datatype=k, count=c) for n, o, k, c in fields]
    rows, columns = points.shape[:2] if points.ndim == 3 else (1, len(points))
    values = {"header": header, "height": rows, "width": columns, "fields": named, "is_bigendian": False,
              "point_step": step, "row_step": step * columns, "data": data, "is_dense": False}  # fmt: skip
    return SimpleNamespace(**(values | more))


def test_a_message_gives_back_points_and_colours():
    for colors in (C, None):
        found = messages.decode(message(colors=colors))
        assert np.array_equal(found.points, P)
        assert (found.colors is None) == (colors is None)
    assert np.array_equal(messages.decode(message()).colors, C.reshape(-1, 3))
    assert messages.decode(message(P.reshape(-1, 3))).points.shape == (8, 3)


def test_padded_rows_and_other_layouts():
    padded = np.zeros((2, 100), np.uint8)
    padded[:, :64] = messages.fields_of(P, C)[2].reshape(2, 64)
    assert np.array_equal(messages.decode(message(row_step=100, data=padded.reshape(-1))).points, P)
    swapped = P.astype(">f8").reshape(-1, 3)
    fields = [SimpleNamespace(name=n, offset=8 * k, datatype=8, count=1) for k, n in enumerate("xyz")]
    data = np.frombuffer(swapped.tobytes(), np.uint8)
    found = messages.decode(message(fields=fields, point_step=24, row_step=96, data=data, is_bigendian=True))
    assert np.array_equal(found.points, P)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"data": np.zeros(50, np.uint8)}, "contradict each other"),
        ({"row_step": 20}, "contradict each other"),
        ({"point_step": 0}, "contradict each other"),
        ({"point_step": 8, "row_step": 32}, "is not in a point"),
        ({"width": 50_000_000, "height": 1}, "are more than"),
        ({"fields": []}, "no field 'x'"),
    ],
)
def test_contradictions_are_refused(change, words):
    with pytest.raises(CloudError, match=words):
        messages.decode(message(**change))


@pytest.fixture
def folder(tmp_path):
    for k in range(3):
        PointCloud(P.reshape(-1, 3) + k).save(tmp_path / f"frame{k}.pcd")
    return tmp_path


def test_files_follow_each_other_at_their_rate(folder):
    source = ReplaySource(folder, rate=10.0)
    seen = [source.latest(5.0 + t) for t in (0.0, 0.05, 0.1, 0.15, 0.25, 0.5)]
    assert [None if f is None else round(float(f.points[0, 0])) for f in seen] == [0, None, 1, None, 2, None]
    assert seen[2].t == 5.1


def test_late_calls_get_the_newest_frame_and_repetition_begins_again(folder):
    source = ReplaySource(folder, rate=10.0, repeat=True)
    assert source.latest(0.0).points[0, 0] == 0
    assert source.latest(0.25).points[0, 0] == 2
    assert source.latest(0.29) is None
    assert source.latest(0.31).points[0, 0] == 0


def test_a_bag_is_replayed_by_its_stamps(tmp_path):
    rosbags = pytest.importorskip("rosbags.rosbag2", reason="rosbags is not installed")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_KILTED)
    kinds = {name.rsplit("/", 1)[1]: store.types[name] for name in store.types}
    with rosbags.Writer(tmp_path / "bag", version=9, storage_plugin=rosbags.StoragePlugin.MCAP) as bag:
        topics = [bag.add_connection(f"/{n}/points", "sensor_msgs/msg/PointCloud2", typestore=store) for n in "ab"]
        for k, t in enumerate((100.0, 100.5)):
            for connection in topics:
                m = message(P + k)
                fields = [kinds["PointField"](f.name, f.offset, f.datatype, f.count) for f in m.fields]
                header = kinds["Header"](kinds["Time"](int(t), int(1e9 * (t % 1))), "camera")
                made = kinds["PointCloud2"](header, 2, 4, fields, False, m.point_step, m.row_step, m.data, False)
                bag.write(connection, int(1e9 * t), store.serialize_cdr(made, "sensor_msgs/msg/PointCloud2"))
    source = ReplaySource(tmp_path / "bag", topic="/b/points")
    first, none, second = (source.latest(t) for t in (3.0, 3.4, 3.6))
    assert none is None
    assert np.array_equal(first.points, P)
    assert np.array_equal(second.points, P + 1)
    with pytest.raises(CloudError, match=r"2 topics have clouds(.|\n)*/a/points, /b/points"):
        ReplaySource(tmp_path / "bag")
    with pytest.raises(CloudError, match="no clouds on /c"):
        ReplaySource(tmp_path / "bag", topic="/c")


def test_what_is_no_recording_is_refused(tmp_path):
    for path, words in ((tmp_path / "none", "does not exist"), (tmp_path, "cannot be read|no cloud")):
        with pytest.raises(CloudError, match=words):
            ReplaySource(path)
    (tmp_path / "a.txt").write_text("")
    with pytest.raises(CloudError, match="not a recording"):
        ReplaySource(tmp_path / "a.txt")
    (tmp_path / "b.mcap").write_bytes(b"nonsense")
    with pytest.raises(CloudError, match="cannot be read"):
        ReplaySource(tmp_path / "b.mcap")
