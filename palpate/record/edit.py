"""Writes a part of a record, several records after each other, or what is whole of a cut one, chunk by chunk."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from palpate.base.errors import OutputError, RecordError
from palpate.record.layout import GROUPS, group_of_topic, type_name
from palpate.record.mcap_file import MESSAGE_HEAD, Block, McapFile, strided
from palpate.record.mcap_scan import Index, Place, scan
from palpate.record.pieces import groups_of
from palpate.record.snapshots import CAMERA, SENSORS, SHAPES

_END = 2**63  # later than any message [ns]


def copy(sources: Sequence[Path], out: Path, start: float = 0.0, stop: float | None = None) -> None:
    """Write the ticks of some records, in the order given, as one record: bit for bit, with frames and meshes.

    Args:
        sources: the records; each begins after the end of the one before.
        out: file to write.
        start, stop: the ticks from `start` up to `stop` [s]; all when left out.

    Raises:
        RecordError: a record cannot be read, has the first layout of palpate 0.1.0, or begins before the end of the
            one before. OutputError: the file cannot be written.
    """
    if out.resolve() in {path.resolve() for path in sources}:
        raise OutputError("the record would overwrite itself", where=str(out), mend="give another file with --out")
    found = [scan(path) for path in sources]
    for index in found:
        _require_typed(index)
    for before, after in pairwise(found):
        _require_later(before, after)
    first, last = round(1e9 * start), _END if stop is None else round(1e9 * stop)
    try:
        file = McapFile(out)
        try:
            _write(file, found, first, last)
            file.finish()
        except BaseException:
            file.abandon()
            raise
    except OSError as error:
        raise OutputError(f"the record cannot be written: {error.strerror or error}", where=str(out)) from error


def _write(file: McapFile, found: Sequence[Index], first: int, last: int) -> None:
    file.begin(profile="ros2", library="palpate")
    for name, values in found[0].metadata.items():
        if name != "rosbag2":  # counts of messages, which are others now
            file.add_metadata(name, values)
    for name, data in found[0].attachments.items():
        file.add_attachment(name, "text/plain", data.decode(errors="replace"))
    layouts = dict.fromkeys(GROUPS, 0)
    others: dict[str, int] = {}
    for k, index in enumerate(found):
        used = {c for place in index.chunks if place.start < last and place.end >= first for c in place.channels}
        numbers = _register(file, index, used, layouts, others)
        begun = dict.fromkeys(GROUPS, 0)
        for place in index.chunks:
            _copy_chunk(file, index, place, numbers, begun, (first, last), k == 0)


def _register(
    file: McapFile, index: Index, used: set[int], layouts: dict[str, int], others: dict[str, int]
) -> dict[int, int]:
    """Register the channels of a record, without layouts that are not used; returns the new channel by the old one.

    Each layout of each record is a channel of its own, since it has its own constant signals.
    """
    numbers: dict[int, int] = {}
    for number, channel in sorted(index.channels.items()):
        schema, group = index.schema_of(number), group_of_topic(channel.topic)
        is_layout = group is not None and not group[1]
        if schema is None or (is_layout and number not in used):
            continue
        if not is_layout and channel.topic in others:
            numbers[number] = others[channel.topic]
            continue
        name = schema.name
        if group is not None and is_layout:
            layouts[group[0]] += 1
            name = type_name(group[0], layouts[group[0]])
        new = file.add_schema(name, schema.encoding, schema.data.decode(errors="replace"))
        numbers[number] = file.add_channel(channel.topic, new, channel.message_encoding, dict(channel.metadata))
        if not is_layout:
            others[channel.topic] = numbers[number]
    return numbers


def _copy_chunk(
    file: McapFile,
    index: Index,
    place: Place,
    numbers: dict[int, int],
    begun: dict[str, int],
    span: tuple[int, int],
    is_first: bool,
) -> None:
    """Copy the messages of a chunk within a time [ns], and those that hold for the whole run.

    begun: number of messages with every signal so far, by group; each begins a layout.
    """
    first, last = span
    topics = {index.channels[channel].topic for channel in place.channels if channel in index.channels}
    lasting = {topic for topic in topics if _lasts(topic)}
    if place.start >= last or (not lasting and place.end < first):
        return
    group = group_of_topic(next(iter(topics))) if len(topics) == 1 else None
    if group is not None and not group[1]:
        _copy_ticks(file, index, place, numbers[place.channels[0]], first, last)
        return
    kept: list[tuple[int, int, bytes]] = []
    for message in index.messages_in(place):
        topic = index.channels[message.channel_id].topic
        whole = group_of_topic(topic)
        if whole is not None:
            begun[whole[0]] += 1
            wanted = _layout(index, whole[0], begun[whole[0]]) in numbers
        else:
            wanted = is_first if topic in lasting else first <= message.log_time < last
        if wanted:
            kept.append((numbers[message.channel_id], max(first, message.log_time), bytes(message.data)))
    if kept:
        file.add_messages(kept)


def _layout(index: Index, group: str, number: int) -> int:
    """Channel of layout `number` (from 1) of a group; -1 without."""
    found = [k for k, channel in sorted(index.channels.items()) if channel.topic == f"/{group}"]
    return found[number - 1] if number <= len(found) else -1


def _copy_ticks(file: McapFile, index: Index, place: Place, number: int, first: int, last: int) -> None:
    data = np.frombuffer(index.load(place), np.uint8)
    width = 9 + int.from_bytes(data[1:9].tobytes(), "little")
    rows = data.reshape(-1, width)
    times = strided(rows, 15, "<u8")[:, 0]
    rows = rows[(times >= first) & (times < last)].copy()
    if len(rows):
        strided(rows, 9, "<u2")[:, 0] = number
        file.add_chunk(Block(rows, strided(rows, 15, "<u8")[:, 0].copy(), {number: 0}))


def _lasts(topic: str) -> bool:
    """True for a topic whose messages hold from their time on: models, meshes, constant signals."""
    group = group_of_topic(topic)
    moving = topic == "/tf" or topic == CAMERA or topic.startswith((SHAPES, SENSORS))
    return group[1] if group is not None else not moving


def _require_typed(index: Index) -> None:
    groups = groups_of(index, {})
    typed = any(group_of_topic(channel.topic) for channel in index.channels.values())
    sound = all(
        piece.rows.width >= MESSAGE_HEAD.size and isinstance(piece.source, Place) for g in groups for piece in g.pieces
    )
    if not groups or not typed or not sound:
        raise RecordError(
            "not a record in the layout of this version",
            where=str(index.path),
            why="it is of another program, of the first palpate 0.1.0, or was rewritten by another tool",
            mend="palpate report and Record.open read such records as they are",
        )


def _require_later(before: Index, after: Index) -> None:
    end = max((place.end for place in before.chunks), default=0)
    start = min((place.start for place in after.chunks), default=_END)
    if start <= end:
        raise RecordError(
            f"{after.path.name} begins at {1e-9 * start:.3f} s, before the end of the one before at {1e-9 * end:.3f} s",
            where=str(after.path),
            mend="give parts of one session, the earlier first; palpate record info tells their times",
        )
