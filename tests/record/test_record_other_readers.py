"""Independent readers open the record: the mcap library, and rosbags, which has its own ROS 2 decoder."""

import re
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import synthetic_run
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from palpate.record import SIGNALS, Record, Recorder, as_rows, mcap_scan
from palpate.record.layout import GROUPS, group_of, topic
from palpate.record.mcap_file import McapFile

rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="rosbags (test group) is not installed")
from rosbags.highlevel import AnyReader  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("record") / "record.mcap"
    ticks = synthetic_run.run(0.7)
    with Recorder(path, "name: floor\n", seed=0, rate=1000.0, deterministic=False) as recorder:
        recorder.append(ticks)
    return path, ticks


def test_stock_mcap_finds_every_signal_by_name_with_unit_and_frame(recorded):
    """The type of `/leader/all` and its kin names every signal; the comment has unit, frame and meaning."""
    path, ticks = recorded
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
        assert [a.name for a in reader.iter_attachments()] == ["scene.yaml", "signals.json"]
        assert {m.name for m in reader.iter_metadata()} == {"palpate", "outcome", "rosbag2"}
        count = sum(1 for _ in reader.iter_messages(topics=["/follower"], starting_at=250_000_000))
    text = {c.topic: summary.schemas[c.schema_id].data.decode() for c in summary.channels.values()}
    for name, signal in SIGNALS.items():
        assert topic(signal) == f"/{group_of(signal)}/{name}"
        (line,) = [one for one in text[f"/{group_of(signal)}/all"].splitlines() if one.split()[1:2] == [name.lower()]]
        assert line.split()[3] == name
        assert line.endswith(signal.doc)
        assert (f"[{signal.unit}]" in line) == (signal.unit not in ("1", "bits"))
        assert (f"in {signal.frame}: " in line) == bool(signal.frame)
    by_topic = dict.fromkeys(GROUPS, 0)
    for channel in summary.channels.values():
        if channel.topic[1:] in by_topic:
            by_topic[channel.topic[1:]] += summary.statistics.channel_message_counts.get(channel.id, 0)
    assert set(by_topic.values()) == {len(ticks)}
    assert count == len(ticks) - 250


def number(value) -> list[float]:
    """The numbers of a field, in the order of the tick."""
    if hasattr(value, "w"):
        return [value.w, value.x, value.y, value.z]
    return [value.x, value.y, value.z] if hasattr(value, "x") else list(np.atleast_1d(value))


def fields(message):
    return {name: number(getattr(message, name)) for name in message.__dataclass_fields__ if name != "__msgtype__"}


def test_rosbags_reads_each_column_by_name(recorded):
    """A constant signal stands in the newest message of /all, a moving one in each tick's message."""
    path, ticks = recorded
    by_field, seen_names = {name.lower(): name for name in SIGNALS}, set[str]()
    seen: dict[str, int] = {}
    whole: dict[str, dict[str, list[float]]] = {}
    with AnyReader([path]) as bag:
        for connection, time, data in bag.messages():
            message = fields(bag.deserialize(data, connection.msgtype))
            group = connection.topic.split("/")[1]
            if connection.topic.endswith("/all"):
                whole[group] = message
                continue
            row = seen[group] = seen.get(group, -1) + 1
            assert time == round(ticks["t"][row] * 1e9)
            for name, first in whole[group].items():
                moving = message.get(name, [])
                expected = np.atleast_1d(ticks[by_field[name]][row])
                assert [*moving, *first[len(moving) :]] == list(expected), name
                seen_names.add(name)
    assert seen_names == {name.lower() for name in SIGNALS}
    assert set(seen) == set(GROUPS)
    assert set(seen.values()) == {len(ticks) - 1}


def test_every_name_is_legal_in_ros(recorded):
    """By rosidl's own patterns: Foxglove's decoder for Python and ROS itself refuse any other name."""
    path, _ = recorded
    with path.open("rb") as file:
        schemas = make_reader(file).get_summary().schemas.values()
    field, kind = re.compile(r"(?!.*__)(?!.*_$)[a-z][a-z0-9_]*"), re.compile(r"[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*")
    for schema in schemas:
        assert kind.fullmatch(schema.name), schema.name
        for line in schema.data.decode().splitlines():
            if line and not line.startswith(("=", "MSG:")):
                assert field.fullmatch(line.split()[1]), line


def test_the_decoder_of_foxglove_reads_each_column_by_name(recorded):
    """`mcap-ros2-support`, which Foxglove keeps: the same numbers, through another parser of the definitions."""
    decoder = pytest.importorskip("mcap_ros2.decoder", reason="mcap-ros2-support (test group) is not installed")
    path, ticks = recorded
    seen: dict[str, int] = {}
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[decoder.DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            if channel.topic[1:] in GROUPS:
                row = seen[channel.topic] = seen.get(channel.topic, -1) + 1
                for name in SIGNALS:
                    value = getattr(message, name.lower(), None)
                    expected = np.atleast_1d(ticks[name][row])
                    assert value is None or number(value) == list(expected[: len(number(value))]), name
    assert seen == dict.fromkeys((f"/{name}" for name in GROUPS), len(ticks) - 1)


def test_definitions_agree_with_ros(recorded):
    path, _ = recorded
    ours, theirs = get_typestore(Stores.EMPTY), get_typestore(Stores.ROS2_JAZZY)
    with rosbag2.Reader(path) as bag:
        from rosbags.typesys import get_types_from_msg

        for connection in bag.connections:
            ours.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
    known = [name for name in ours.fielddefs if not name.startswith("palpate_msgs/")]
    assert {"geometry_msgs/msg/Vector3", "geometry_msgs/msg/Quaternion"} <= set(known)
    for name in known:
        assert ours.fielddefs[name] == theirs.fielddefs[name], name


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
        firsts = sum(c.msgcount for c in bag.connections if c.topic.endswith("/all"))
        assert bag.message_count == len(ticks) * len(GROUPS) + firsts
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


def chunks_by_the_library(path):
    """The chunks of a file as the mcap library reads them: the reference."""
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    return [
        (c.chunk_start_offset, c.chunk_length, c.message_start_time, c.message_end_time, c.uncompressed_size,
         tuple(sorted(c.message_index_offsets)))
        for c in summary.chunk_indexes
    ]  # fmt: skip


@pytest.mark.parametrize("at_once", [7, 256])
def test_entries_of_chunks_of_any_forms_are_those_of_the_library(tmp_path, monkeypatch, at_once):
    """Runs of alike entries are taken at once: chunks of one to three channels, in any order."""
    monkeypatch.setattr(mcap_scan, "_AT_ONCE", at_once)
    path, rng = tmp_path / "any.mcap", np.random.default_rng(0)
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=300)
        writer.start()
        numbers = [writer.register_channel(f"/c{k}", "", 0) for k in range(3)]
        for k in range(2000):
            some = numbers[: 1 + int(rng.integers(3))] if k // 200 % 2 else numbers[k // 400 % 3 :][:1]
            writer.add_message(int(rng.choice(some)), 10**9 + k, bytes(int(rng.integers(5, 60))), 10**9 + k)
        writer.finish()
    expected = chunks_by_the_library(path)
    assert len({one[-1] for one in expected}) > 3
    found = mcap_scan.scan(path)
    assert found.complete
    assert [tuple(one) for one in found.chunks] == expected
    for wanted in ({numbers[0]}, {numbers[1], numbers[2]}):
        assert [tuple(p) for p in found.chunks.holding(wanted)] == [one for one in expected if wanted & set(one[-1])]
        count = sum(1 for one in found.messages(wanted))
        assert count == sum(1 for one in found.messages() if one.channel_id in wanted) > 100
