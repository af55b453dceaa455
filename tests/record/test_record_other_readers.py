"""Independent readers open the record: the mcap library, and rosbags, which has its own ROS 2 decoder."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import synthetic_run
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from palpate.record import SIGNALS, Record, Recorder, as_rows
from palpate.record.channels import channels
from palpate.record.mcap_file import McapFile

rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="rosbags (test group) is not installed")
from rosbags.typesys import Stores, get_typestore  # noqa: E402


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("record") / "record.mcap"
    ticks = synthetic_run.run(0.7)
    with Recorder(path, "name: floor\n", seed=0, rate=1000.0, deterministic=False) as recorder:
        recorder.append(ticks)
    return path, ticks


def test_stock_mcap_lists_every_signal_with_unit_and_frame(recorded):
    path, ticks = recorded
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
        assert [a.name for a in reader.iter_attachments()] == ["scene.yaml", "signals.json"]
        assert {m.name for m in reader.iter_metadata()} == {"palpate", "outcome", "rosbag2"}
        count = sum(1 for _ in reader.iter_messages(topics=["/force/F_T_W"], starting_at=250_000_000))
    by_signal = {c.metadata["signal"]: c for c in summary.channels.values()}
    assert set(by_signal) == set(SIGNALS)
    for name, signal in SIGNALS.items():
        channel = by_signal[name]
        assert channel.topic == f"/{signal.stage}/{name}"
        assert channel.metadata["unit"] == signal.unit
        assert channel.metadata["frame"] == signal.frame
        assert channel.metadata["meaning"] == signal.doc
        assert summary.statistics.channel_message_counts[channel.id] == len(ticks)
    assert count == len(ticks) - 250


def number(message, part: str) -> list[float]:
    value = {
        "data": lambda m: [m.data],
        "point": lambda m: [m.point.x, m.point.y, m.point.z],
        "vector": lambda m: [m.vector.x, m.vector.y, m.vector.z],
        "quaternion": lambda m: [m.quaternion.w, m.quaternion.x, m.quaternion.y, m.quaternion.z],
        "force": lambda m: [m.wrench.force.x, m.wrench.force.y, m.wrench.force.z],
        "position": lambda m: m.position,
        "velocity": lambda m: m.velocity,
        "effort": lambda m: m.effort,
    }[part](message)
    return list(value)


def test_rosbags_decodes_the_same_numbers(recorded):
    path, ticks = recorded
    store = get_typestore(Stores.ROS2_JAZZY)
    layout = {c.topic: c for c in channels(deterministic=False)}
    seen = dict.fromkeys(layout, 0)
    with rosbag2.Reader(path) as bag:
        assert {c.topic: c.msgtype for c in bag.connections} == {c.topic: c.schema for c in layout.values()}
        for connection, time, data in bag.messages(start=500_000_000, stop=560_000_000):
            channel = layout[connection.topic]
            message = store.deserialize_cdr(data, connection.msgtype)
            row = 500 + seen[connection.topic]
            seen[connection.topic] += 1
            expected = np.atleast_1d(ticks[channel.signal.name][row])
            assert number(message, channel.part) == list(expected), connection.topic
            assert time == round(ticks["t"][row] * 1e9)
            if channel.part != "data":
                stamp = message.header.stamp
                assert stamp.sec * 10**9 + stamp.nanosec == time
                assert message.header.frame_id == channel.signal.frame
    assert set(seen.values()) == {60}


def test_definitions_agree_with_ros(recorded):
    path, _ = recorded
    ours, theirs = get_typestore(Stores.EMPTY), get_typestore(Stores.ROS2_JAZZY)
    with rosbag2.Reader(path) as bag:
        from rosbags.typesys import get_types_from_msg

        for connection in bag.connections:
            ours.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
    for name, fields in ours.fielddefs.items():
        assert fields == theirs.fielddefs[name], name


def rewrite(source: Path, target: Path, keep=lambda topic: True, chunk_size: int = 100_000) -> None:
    """Write the same messages with another layout, as `mcap recover`, `mcap compress` or `ros2 bag convert` do."""
    with source.open("rb") as file, target.open("wb") as out:
        writer = Writer(out, chunk_size=chunk_size, compression=CompressionType.LZ4)
        writer.start(profile="ros2")
        reader = make_reader(file)
        ids: dict[int, int] = {}
        schemas: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages():
            if not keep(channel.topic):
                continue
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.id not in ids:
                ids[channel.id] = writer.register_channel(channel.topic, "cdr", schemas[schema.id])
            writer.add_message(ids[channel.id], message.log_time, message.data, message.publish_time)
        writer.finish()


def test_record_rewritten_by_another_tool_has_the_same_values(recorded, tmp_path):
    path, ticks = recorded
    rewrite(path, tmp_path / "other.mcap")
    record = Record.open(tmp_path / "other.mcap")
    np.testing.assert_array_equal(as_rows(record.ticks), as_rows(ticks))
    assert record.complete
    assert record.rate == pytest.approx(1000.0)
    assert record.scene == ""


def test_folder_of_a_run_is_a_bag_with_metadata(tmp_path):
    """`ros2 bag info|play FOLDER` needs metadata.yaml; rosbags reads the folder only with it."""
    ticks = synthetic_run.run(0.6)
    with Recorder(tmp_path / "record.mcap", "name: floor\n", 0, 1000.0, deterministic=True, bag=True) as recorder:
        recorder.append(ticks)
    with rosbag2.Reader(tmp_path) as bag:
        assert bag.message_count == len(ticks) * len(channels(deterministic=True))
        assert bag.duration == round(1e9 * (ticks["t"][-1] - ticks["t"][0])) + 1
        assert sum(1 for _ in bag.messages()) == bag.message_count


def test_a_long_record_takes_little_memory_in_its_writer(tmp_path):
    """A chunk is written each half second: its index may take 20 bytes a channel, or days would take gigabytes."""
    file = McapFile(tmp_path / "long.mcap")
    file.begin(profile="", library="palpate")
    schema = file.add_schema("one", "ros2msg", "float64 value")
    channels = [file.add_channel(f"/signal_{i}", schema, "cdr", {}) for i in range(70)]
    tracemalloc.start()
    for k in range(300):
        file.add_messages([(channel, k, b"12345678") for channel in channels])
    grown = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    file.finish()
    assert grown / 300 < 20 * 70
