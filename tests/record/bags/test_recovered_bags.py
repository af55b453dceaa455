"""Bags that are cut off, end in zeros, have no chunks or no storage in their metadata are read up to there.

The bags are written by rosbags and by the library mcap, and cut here.
"""

import shutil
from pathlib import Path

import numpy as np
import pytest

from palpate.base.errors import RecordError
from palpate.record.bags.open import open_any
from palpate.record.bags.recover import needs_recovery

rosbags = pytest.importorskip("rosbags", reason="extra ros")
from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

N = 300


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """A folder with a bag of one arm: N poses at 100 Hz."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = store.types
    folder = tmp_path_factory.mktemp("bags") / "whole"
    pose = kinds["geometry_msgs/msg/PoseStamped"]
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("MTMR/measured_cp", pose.__msgtype__, typestore=store)
        for i in range(N):
            t = int(1.7e18 + i * 1e7)
            stamp = kinds["builtin_interfaces/msg/Time"](sec=t // 10**9, nanosec=t % 10**9)
            message = pose(
                header=kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="base"),
                pose=kinds["geometry_msgs/msg/Pose"](
                    position=kinds["geometry_msgs/msg/Point"](x=0.001 * i, y=0.0, z=0.0),
                    orientation=kinds["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
                ),
            )
            writer.write(connection, t, store.serialize_cdr(message, pose.__msgtype__))
    return folder


def rewritten(bag, path, **options):
    """The same messages by the library mcap, with other options."""
    from mcap.reader import make_reader
    from mcap.writer import Writer as Plain

    (source,) = bag.glob("*.mcap")
    with source.open("rb") as file, path.open("wb") as out:
        writer, ids = Plain(out, **options), {}
        writer.start(profile="ros2")
        for schema, channel, message in make_reader(file).iter_messages():
            if channel.id not in ids:
                kind = writer.register_schema(schema.name, schema.encoding, schema.data)
                ids[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, kind, channel.metadata
                )
            writer.add_message(ids[channel.id], message.log_time, message.data, message.publish_time)
        writer.finish()
    return path


def assert_begins_as_the_bag(found, least):
    values = found.arms["MTMR"].pose.values
    assert len(values) >= least
    np.testing.assert_allclose(values[:, 0], 0.001 * np.arange(len(values)), atol=1e-12)


@pytest.mark.parametrize("share", [0.97, 0.7, 0.4])
@pytest.mark.parametrize("tail", ["cut", "zeros"])
@pytest.mark.parametrize("kind", ["rosbags", "one chunk of zstd", "small chunks", "lz4", "none", "without chunks"])
def test_a_damaged_tail_is_read_up_to_there(bag, tmp_path, share, tail, kind):
    from mcap.writer import CompressionType

    options = {
        "one chunk of zstd": {"chunk_size": 1 << 24}, "small chunks": {"chunk_size": 2000},
        "lz4": {"compression": CompressionType.LZ4, "chunk_size": 4000},
        "none": {"compression": CompressionType.NONE, "chunk_size": 1 << 24}, "without chunks": {"use_chunking": False},
    }  # fmt: skip
    if kind == "lz4":
        pytest.importorskip("lz4")
    (source,) = bag.glob("*.mcap")
    path = (
        rewritten(bag, tmp_path / "a.mcap", **options[kind])
        if kind in options
        else Path(shutil.copy(source, tmp_path / "a.mcap"))
    )
    data = path.read_bytes()
    end = int(share * len(data))
    path.write_bytes(data[:end] + (bytes(len(data) - end) if tail == "zeros" else b""))
    assert needs_recovery(path)
    try:
        found = open_any(path)
    except RecordError:  # a compression whose first block is not whole gives nothing
        assert kind in ("rosbags", "one chunk of zstd")
        return
    assert_begins_as_the_bag(found, 1 if kind in ("rosbags", "one chunk of zstd", "lz4") else 0.5 * share * N)
    if share < 0.9:
        assert any("read up to there" in note for note in found.notes)


def test_a_bag_without_chunks_is_whole(bag, tmp_path):
    found = open_any(rewritten(bag, tmp_path / "a.mcap", use_chunking=False))
    assert_begins_as_the_bag(found, N)
    assert found.notes == []


@pytest.mark.parametrize("metadata", ["empty storage", "none", "damaged"])
def test_metadata_that_name_no_storage_are_no_hindrance(bag, tmp_path, metadata):
    folder = tmp_path / "reindexed"
    shutil.copytree(bag, folder)
    file = folder / "metadata.yaml"
    if metadata == "none":
        file.unlink()
    else:
        text = file.read_text().replace("storage_identifier: mcap", 'storage_identifier: ""')
        file.write_text(text if metadata == "empty storage" else "{}\n")
    assert_begins_as_the_bag(open_any(folder), N)


def test_a_bag_of_ros_1_is_told(tmp_path):
    (tmp_path / "a.bag").write_bytes(b"#ROSBAG V2.0\n" + bytes(200))
    with pytest.raises(RecordError, match=r"a bag of ROS 1, not of ROS 2\n  mend: rosbags-convert --src a.bag"):
        open_any(tmp_path / "a.bag")
