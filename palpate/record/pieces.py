"""Where the ticks of a record stand in its file, and their decoding: piece by piece, only what is asked."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from palpate.base.errors import RecordError
from palpate.record import per_signal
from palpate.record.layout import CDR, Layout, field_name, group_of_topic
from palpate.record.mcap_file import MESSAGE_HEAD, strided
from palpate.record.mcap_scan import Index, Place, Places, damaged
from palpate.record.ticks import SIGNALS, Signal

if TYPE_CHECKING:
    from concurrent.futures import Future

Bytes = NDArray[np.uint8]
THREADS = 2
"""Threads that unpack the next pieces of a long reading: unpacking is most of its time."""
AHEAD_FROM = 10_000
"""Ticks from which a reading is long."""


class Column(NamedTuple):
    """Where the numbers of a signal stand in the bytes of a tick."""

    offset: int
    """Position of the first number [bytes]."""
    kind: str
    """numpy type of the numbers."""
    order: list[int]
    """Element of the signal of each number."""


@dataclass(frozen=True)
class Rows:
    """The bytes of a tick in a chunk: its messages one after the other, each of constant length."""

    width: int
    """Bytes of a tick."""
    columns: dict[str, Column]
    heads: tuple[tuple[int, int, int], ...] = ()
    """Position, length and channel of each message; empty for bytes that are known to be messages."""
    constant: dict[str, NDArray[Any]] = field(default_factory=dict)
    """Every element of each signal at the first of these ticks; those without a column stay as they are."""

    def has_form(self, rows: Bytes) -> bool:
        """True if bytes (n, width) have the heads of these messages."""
        for offset, length, channel in self.heads:
            head = MESSAGE_HEAD.pack(Opcode.MESSAGE, length, channel, 0, 0, 0)[:11]
            start, rest = np.frombuffer(head, "<u8", 1)[0], np.frombuffer(head, "<u2", 1, 9)[0]
            alike = strided(rows, offset, "<u8") == start, strided(rows, offset + 9, "<u2") == rest
            if not (alike[0].all() and alike[1].all()):
                return False
        return True


class Piece(NamedTuple):
    """Consecutive ticks."""

    start: int
    length: int
    """Number of ticks."""
    rows: Rows
    source: Place | Bytes
    """Chunk of the file, or the bytes themselves (length, width)."""


class Group:
    """The pieces of the signals that one message carries, in the order of time."""

    def __init__(self, index: Index, signals: dict[str, Signal]) -> None:
        self.signals = signals
        self.kept = 1
        """Number of pieces that stay unpacked."""
        self._index = index
        self._starts = array("q", [0])  # number of the first tick of each piece, and of the tick after the last
        self._forms: list[Rows] = []
        self._places = Places()  # of the pieces in the file
        self._bytes: list[Bytes] = []  # of the pieces in memory
        self._unpacked: dict[int, Bytes] = {}  # by the number of the first tick, the newest last

    @property
    def count(self) -> int:
        """Number of ticks."""
        return self._starts[-1]

    @property
    def pieces(self) -> Sequence[Piece]:
        """Its pieces, made when they are asked for: an hour has 14,400."""
        return _Pieces(self)

    def piece(self, k: int) -> Piece:
        """Piece number k."""
        start = self._starts[k]
        source = self._bytes[k] if self._bytes else self._places[k]
        return Piece(start, self._starts[k + 1] - start, self._forms[k], source)

    def add(self, count: int, rows: Rows, source: Place | Bytes) -> None:
        """Append a piece; all are in the file, or all in memory."""
        self._starts.append(self.count + count)
        self._forms.append(rows)
        if isinstance(source, np.ndarray):
            self._bytes.append(source)
        else:
            self._places.append(source)

    def within(self, start: int, stop: int) -> Iterator[Piece]:
        """The pieces that hold ticks from `start` up to `stop`."""
        first = max(0, bisect_right(self._starts, start) - 1)
        for piece in map(self.piece, range(first, len(self._forms))):
            if piece.start >= stop or start >= stop:
                return
            if piece.start + piece.length > start:
                yield piece

    def fill(self, target: NDArray[Any], names: list[str], start: int) -> None:
        """Write signals of the ticks from number `start` on into the fields of a structured array (n,)."""
        stop = start + len(target)
        pieces = self.within(start, stop)
        if len(target) > AHEAD_FROM and not self._bytes:
            pieces = self._unpacked_ahead(pieces, names)
        for piece in pieces:
            a, b = max(start, piece.start), min(stop, piece.start + piece.length)
            into = target[a - start : b - start]
            moving = [name for name in names if name in piece.rows.columns]
            for name in names:
                still = piece.rows.constant.get(name)
                column = piece.rows.columns.get(name)
                if still is not None and (column is None or len(column.order) < len(still)):
                    whole = into[name].reshape(len(into), -1)
                    whole[:, : still.size] = still[: whole.shape[1]]
            if moving:
                rows = self._load(piece)[a - piece.start : b - piece.start]
                for name in moving:
                    _set(into, name, piece.rows.columns[name], rows)

    def _unpacked_ahead(self, pieces: Iterator[Piece], names: list[str]) -> Iterator[Piece]:
        """The pieces, of which the next ones are unpacked meanwhile by threads."""
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(THREADS, "palpate-record") as pool:
            ahead: deque[tuple[Piece, Future[Bytes] | None]] = deque()
            for piece in pieces:
                needed = any(name in piece.rows.columns for name in names)
                ahead.append((piece, pool.submit(self._rows, piece) if needed else None))
                if len(ahead) > THREADS:
                    yield self._with_rows(*ahead.popleft())
            while ahead:
                yield self._with_rows(*ahead.popleft())

    @staticmethod
    def _with_rows(piece: Piece, rows: Future[Bytes] | None) -> Piece:
        return piece if rows is None else piece._replace(source=rows.result())

    def _load(self, piece: Piece) -> Bytes:
        if isinstance(piece.source, np.ndarray):
            return piece.source
        known = self._unpacked.pop(piece.start, None)
        if known is not None:
            self._unpacked[piece.start] = known
            return known
        rows = self._unpacked[piece.start] = self._rows(piece)
        if len(self._unpacked) > self.kept:
            del self._unpacked[next(iter(self._unpacked))]
        return rows

    def _rows(self, piece: Piece) -> Bytes:
        """The bytes (length, width) of a piece in the file."""
        assert not isinstance(piece.source, np.ndarray)
        rows = np.frombuffer(self._index.load(piece.source), np.uint8).reshape(piece.length, piece.rows.width)
        if not piece.rows.has_form(rows):
            raise damaged(self._index.path, ValueError("a chunk holds other messages than its index says"))
        return rows


class _Pieces(Sequence[Piece]):
    """The pieces of a group."""

    def __init__(self, group: Group) -> None:
        self._group = group

    def __len__(self) -> int:
        return len(self._group._forms)

    @overload
    def __getitem__(self, k: int) -> Piece: ...
    @overload
    def __getitem__(self, k: slice) -> list[Piece]: ...
    def __getitem__(self, k: int | slice) -> Piece | list[Piece]:
        numbers = range(len(self))[k]
        return self._group.piece(numbers) if isinstance(numbers, int) else [self._group.piece(i) for i in numbers]


def _set(into: NDArray[Any], name: str, column: Column, rows: Bytes) -> None:
    if not len(into):
        return
    values = strided(rows, column.offset, column.kind, len(column.order))
    target = into[name].reshape(len(into), -1)  # a view
    n = min(len(column.order), target.shape[1])  # another version may have fewer elements
    where = slice(0, n) if column.order[:n] == list(range(n)) else column.order[:n]
    with np.errstate(invalid="ignore"):  # bits of a damaged record may be no whole number
        target[:, where] = values[:, :n]


def groups_of(index: Index, signals: dict[str, Signal]) -> list[Group]:
    """The groups of a record; empty if the file holds no signal.

    Args:
        index: of the file.
        signals: described in the file, by name.

    Raises:
        RecordError: messages are missing in the middle, or the file is damaged.
    """
    return _typed(index, signals) or _per_signal(index)


# Records with a message for a group of signals


def _typed(index: Index, described: dict[str, Signal]) -> list[Group]:
    layouts, wholes = _layouts(index, {field_name(name): name for name in (*SIGNALS, *described)})
    if not layouts:
        return []
    for _, group in wholes.values():
        layouts.setdefault(group, {})  # a file that is cut in its first block lacks the later groups: it has no ticks
    first = _first_ticks(index, wholes)
    rows: dict[int, Rows] = {}
    signals: dict[str, dict[str, Signal]] = {}
    for name, by_channel in layouts.items():
        whole = next((layout for layout, group in wholes.values() if group == name), None)
        known = signals.setdefault(name, {})
        for layout in ([whole] if whole is not None else []) + list(by_channel.values()):
            for one in layout.fields:
                known.setdefault(one.name, _signal(one.name, one.count, one.kind, described))
        for k, (channel, layout) in enumerate(by_channel.items()):
            constant = first.get(name, [])
            rows[channel] = _rows(layout, channel, known, constant[k] if k < len(constant) else {})
    placed = _placed(index, rows)
    found = {name: Group(index, signals[name]) for name in layouts}
    of_channel = {channel: name for name, by_channel in layouts.items() for channel in by_channel}
    for channel, count, form, source in placed:
        found[of_channel[channel]].add(count, form, source)
    return list(found.values())


def _layouts(index: Index, names: dict[str, str]) -> tuple[dict[str, dict[int, Layout]], dict[int, tuple[Layout, str]]]:
    """The layouts of each group by channel, and by channel those with all signals, with their group.

    names: of the signals by their fields.
    """
    layouts: dict[str, dict[int, Layout]] = {}
    wholes: dict[int, tuple[Layout, str]] = {}
    for number, channel in sorted(index.channels.items()):
        found, schema = group_of_topic(channel.topic), index.schema_of(number)
        layout = None if found is None or schema is None else Layout.parse(schema.data.decode(errors="replace"), names)
        if found is None or layout is None:
            continue
        if found[1]:
            wholes[number] = (layout, found[0])
        else:
            layouts.setdefault(found[0], {})[number] = layout
    return layouts, wholes


def _first_ticks(index: Index, wholes: dict[int, tuple[Layout, str]]) -> dict[str, list[dict[str, NDArray[Any]]]]:
    """All signals at the begin of each layout, by group."""
    found: dict[str, list[dict[str, NDArray[Any]]]] = {}
    for message in index.messages(set(wholes)):
        layout, group = wholes[message.channel_id]
        if len(message.data) != layout.message_bytes:
            continue
        values: dict[str, NDArray[Any]] = {}
        for one in layout.fields:
            kind = "<u8" if one.kind == "uint64" else "<f8"
            numbers = np.frombuffer(message.data, kind, one.count, len(CDR) + 8 * one.place)
            values[one.name] = np.empty_like(numbers)
            values[one.name][one.order] = numbers
        found.setdefault(group, []).append(values)
    return found


def _signal(name: str, size: int, kind: str, described: dict[str, Signal]) -> Signal:
    """Description of a recorded signal: as the file has it, else as this version has it, else its name alone."""
    found = described.get(name) or SIGNALS.get(name)
    if found is not None and found.size >= size:
        return found
    return Signal(name, -1, size, "bits" if kind == "uint64" else "1", "", "", True, "")


def _rows(layout: Layout, channel: int, known: dict[str, Signal], constant: dict[str, NDArray[Any]]) -> Rows:
    head = MESSAGE_HEAD.size + len(CDR)
    columns = {
        one.name: Column(head + 8 * one.place, "<u8" if one.kind == "uint64" else "<f8", one.order)
        for one in layout.fields if one.name in known and one.count <= known[one.name].size
    }  # fmt: skip
    length = MESSAGE_HEAD.size - 9 + layout.message_bytes
    return Rows(MESSAGE_HEAD.size + layout.message_bytes, columns, ((0, length, channel),), constant)


def _placed(index: Index, rows: dict[int, Rows]) -> list[tuple[int, int, Rows, Place | Bytes]]:
    """Channel, number of ticks, layout and source of each piece, in the order of the file."""
    placed: list[tuple[int, int, Rows, Place | Bytes]] = []
    for place in index.chunks:
        ours = [channel for channel in place.channels if channel in rows]
        if not ours:
            continue
        one = rows[ours[0]]
        if len(place.channels) > 1 or place.size % one.width:
            return _collected(index, rows)  # rewritten by another tool
        placed.append((ours[0], place.size // one.width, one, place))
    return placed or _collected(index, rows)


def _collected(index: Index, rows: dict[int, Rows]) -> list[tuple[int, int, Rows, Place | Bytes]]:
    """The pieces of a record that another tool rewrote (mcap recover, ros2 bag convert): message by message."""
    bodies: dict[int, list[bytes]] = {}
    times: dict[int, list[int]] = {}
    for message in index.messages(set(rows)):
        if len(message.data) == rows[message.channel_id].width - MESSAGE_HEAD.size:
            bodies.setdefault(message.channel_id, []).append(message.data)
            times.setdefault(message.channel_id, []).append(message.log_time)
    _require_step(index, times)
    placed: list[tuple[int, int, Rows, Place | Bytes]] = []
    for channel, found in bodies.items():
        data = np.frombuffer(b"".join(found), np.uint8).reshape(len(found), -1)
        columns = {n: c._replace(offset=c.offset - MESSAGE_HEAD.size) for n, c in rows[channel].columns.items()}
        width = rows[channel].width - MESSAGE_HEAD.size
        placed.append((channel, len(found), Rows(width, columns, (), rows[channel].constant), data))
    return sorted(placed, key=lambda one: times[one[0]][0])


def _require_step(index: Index, times: dict[int, list[int]]) -> None:
    """Refuse groups whose messages do not have the same times."""
    by_topic: dict[str, list[int]] = {}
    for channel, found in times.items():
        by_topic.setdefault(index.channels[channel].topic, []).extend(found)
    n = min((len(one) for one in by_topic.values()), default=0)
    reference = next(iter(by_topic.values()), [])[:n]
    for topic, found in by_topic.items():
        if found[:n] != reference:
            raise RecordError(
                f"channel {topic} is out of step with the others",
                where=str(index.path),
                why="messages are missing in the middle of the record",
                mend="use the record as `palpate run` wrote it",
            )


# Records with a message for each signal, the first of palpate 0.1.0


def _per_signal(index: Index) -> list[Group]:
    by_topic = {channel.topic: number for number, channel in index.channels.items()}
    found: dict[int, per_signal.Channel] = {}
    for signal in SIGNALS.values():
        layout = per_signal.channel_of(signal)
        number = by_topic.get(layout.topic)
        schema = None if number is None else index.schema_of(number)
        if number is not None and schema is not None and schema.name == layout.schema:
            found[number] = layout
    if not found:
        return []
    return _blocks_of_ticks(index, found) or _single_channels(index, found)


def _blocks_of_ticks(index: Index, found: dict[int, per_signal.Channel]) -> list[Group]:
    """Ticks as the recorder wrote them; empty for another order of the messages."""
    rows = _rows_per_signal(dict(sorted(found.items())))
    group = Group(index, {one.signal.name: one.signal for one in found.values()})
    numbers = set(found)
    for place in index.chunks:
        if numbers.isdisjoint(place.channels):
            continue
        first = not group.pieces
        if set(place.channels) != numbers or place.size % rows.width:
            return []
        if first and not rows.has_form(np.frombuffer(index.load(place), np.uint8).reshape(-1, rows.width)):
            return []
        group.add(place.size // rows.width, rows, place)
    return [group] if group.pieces else []


def _rows_per_signal(found: dict[int, per_signal.Channel]) -> Rows:
    columns: dict[str, Column] = {}
    heads: list[tuple[int, int, int]] = []
    at = 0
    for number, one in found.items():
        heads.append((at, MESSAGE_HEAD.size - 9 + len(one.message), number))
        columns[one.signal.name] = Column(at + MESSAGE_HEAD.size + one.data, "<f8", one.order)
        at += MESSAGE_HEAD.size + len(one.message)
    return Rows(at, columns, tuple(heads))


def _single_channels(index: Index, found: dict[int, per_signal.Channel]) -> list[Group]:
    """One group a signal, in a record that another tool rewrote."""
    rows = {number: _rows_per_signal({number: one}) for number, one in found.items()}
    groups = []
    for channel, count, one, source in _collected(index, rows):
        group = Group(index, {found[channel].signal.name: found[channel].signal})
        group.add(count, one, source)
        groups.append(group)
    return groups
