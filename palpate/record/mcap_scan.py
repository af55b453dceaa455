"""Finds what an MCAP file holds without loading it: by the index at its end, or record by record in a file without end.

The file of a killed run has no index, but its records before the first chunk and the heads of its chunks hold the same
information. Chunks are unpacked one at a time, when their messages are asked for.
"""

from __future__ import annotations

import os
import struct
import zlib
from array import array
from collections.abc import Callable, Iterable, Iterator, MutableSequence
from dataclasses import dataclass, field
from io import BytesIO
from operator import add
from pathlib import Path
from threading import Lock
from typing import IO, Any, NamedTuple, overload

import numpy as np
import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from numpy.typing import NDArray

from palpate.base import limits
from palpate.base.errors import RecordError
from palpate.record.mcap_file import MAGIC, MESSAGE_HEAD

_MOST_RATIO = 64  # unpacked bytes for each byte of a file: telemetry reaches 10
_MOST_SIZE = 1 << 42  # largest record that is opened [bytes]: a month
_FOOTER = struct.Struct("<BQQQI")
_CHUNK_HEAD = struct.Struct("<BQQQQII")  # opcode, length, start, end, unpacked size, checksum, length of the kind
_INDEX_ENTRY = struct.Struct("<xQQQQQI")  # length, start, end, offset, length, bytes of the places of message indexes
_INDEX_REST = struct.Struct("<QI")  # length of the message indexes, length of the kind
_AT_ONCE = 256  # entries of chunks that are read at once: all that are left, each time, would take their square
DAMAGE = (
    McapError,
    struct.error,
    UnicodeDecodeError,
    zstandard.ZstdError,
    ValueError,
    RuntimeError,
    MemoryError,
    OverflowError,
)
"""Exceptions that the libraries raise on damaged bytes."""


class Place(NamedTuple):
    """A chunk of the file."""

    offset: int
    """Position of its record in the file [bytes]."""
    length: int
    """Length of its record [bytes]."""
    start: int
    """Time of its first message [ns]."""
    end: int
    """Time of its last message [ns]."""
    size: int
    """Unpacked size [bytes]."""
    channels: tuple[int, ...]
    """Channels of its messages, in ascending order; empty if unknown."""


class Places(MutableSequence[Place]):
    """Chunks in the order of the file, in 50 bytes each: an hour has 40,000."""

    def __init__(self, places: Iterable[Place] = ()) -> None:
        self._numbers = array("Q")  # of each place all but its channels
        self._kinds: list[tuple[int, ...]] = []  # of the places, of which most are alike
        self._known: dict[tuple[int, ...], tuple[int, ...]] = {}
        self.extend(places)

    def __len__(self) -> int:
        """Number of chunks."""
        return len(self._kinds)

    @overload
    def __getitem__(self, k: int) -> Place: ...
    @overload
    def __getitem__(self, k: slice) -> Places: ...
    def __getitem__(self, k: int | slice) -> Place | Places:
        """Chunk number k, or some of them."""
        if isinstance(k, slice):
            return Places(self[i] for i in range(*k.indices(len(self))))
        kind = self._kinds[k]
        at = 5 * (k % len(self._kinds))
        offset, length, start, end, size = self._numbers[at : at + 5]
        return Place(offset, length, start, end, size, kind)

    def __setitem__(self, k: Any, place: Any) -> None:
        """Replace chunk number k."""
        at = 5 * (k % len(self._kinds))
        self._numbers[at : at + 5] = array("Q", place[:5])
        self._kinds[k] = self._known.setdefault(place.channels, place.channels)

    def __delitem__(self, k: Any) -> None:
        """Drop the chunks of a slice."""
        kept = Places(place for i, place in enumerate(self) if i not in range(len(self))[k])
        self._numbers, self._kinds = kept._numbers, kept._kinds

    def __iter__(self) -> Iterator[Place]:
        """All chunks."""
        columns = [self._numbers[k::5] for k in range(5)]  # by steps: an hour has 20,000
        return map(Place, *columns, list(self._kinds))

    def insert(self, index: int, value: Place) -> None:
        """Insert a chunk; only at the end."""
        assert index >= len(self._kinds)
        self.append(value)

    def append(self, value: Place) -> None:
        """Append a chunk."""
        self._numbers.extend(value[:5])
        self._kinds.append(self._known.setdefault(value.channels, value.channels))

    def append_rows(self, numbers: NDArray[np.uint64], kinds: Iterable[tuple[int, ...]]) -> None:
        """Append chunks by their numbers (n, 5) in the order of `Place`, and the channels of each."""
        self._numbers.frombytes(np.ascontiguousarray(numbers).tobytes())
        self._kinds += [self._known.setdefault(kind, kind) for kind in kinds]

    def holding(self, wanted: set[int]) -> Iterator[Place]:
        """Chunks that may hold messages of some channels."""
        kinds = {kind for kind in self._known if not kind or not wanted.isdisjoint(kind)}
        return (self[k] for k, kind in enumerate(self._kinds) if kind in kinds)

    def column(self, name: str) -> list[int]:
        """One number of all chunks, a field of `Place`."""
        return self._numbers[Place._fields.index(name) :: 5].tolist()


@dataclass
class Index:
    """What a file holds, and where."""

    path: Path
    channels: dict[int, records.Channel] = field(default_factory=dict)
    schemas: dict[int, records.Schema] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    chunks: Places = field(default_factory=Places)
    loose: list[records.Message] = field(default_factory=list)
    """Messages outside any chunk."""
    complete: bool = False
    """True if the file has its end."""
    sound: int = 0
    """Bytes from the start of the file up to the end of its last whole record before the summary."""
    _file: IO[bytes] | None = field(default=None, repr=False)
    _opening: Lock = field(default_factory=Lock, repr=False)  # several threads may load chunks

    def schema_of(self, channel: int) -> records.Schema | None:
        """Message type of a channel."""
        return self.schemas.get(self.channels[channel].schema_id)

    def load(self, place: Place) -> bytes:
        """The unpacked messages of a chunk.

        Raises:
            RecordError: the chunk is damaged, or cannot be read.
        """
        try:
            with self._opening:
                if self._file is None:
                    self._file = self.path.open("rb", buffering=0)
            body = _read(self._file.fileno(), place.offset, place.length)
            *_, size, crc, width = _CHUNK_HEAD.unpack_from(body)
            at = _CHUNK_HEAD.size + width
            return _unpacked(body[at + 8 :], body[_CHUNK_HEAD.size : at].decode(), size, crc)
        except (*DAMAGE, OSError) as error:
            raise damaged(self.path, error) from error

    def messages(self, wanted: set[int] | None = None) -> Iterator[records.Message]:
        """The messages of some channels, or of all for None, in the order of the file."""
        for place in self.chunks if wanted is None else self.chunks.holding(wanted):
            yield from self.messages_in(place, wanted)
        yield from (one for one in self.loose if wanted is None or one.channel_id in wanted)

    def messages_in(self, place: Place, wanted: set[int] | None = None) -> Iterator[records.Message]:
        """The messages of a chunk, of some channels or of all for None."""
        if wanted is not None and place.channels and wanted.isdisjoint(place.channels):
            return
        for opcode, body in whole_records(memoryview(self.load(place))):
            if opcode == Opcode.MESSAGE and (wanted is None or _channel(body) in wanted):
                yield _parse_message(body, self.path)


def scan(path: Path) -> Index:
    """Find what a file holds.

    Raises:
        RecordError: the file is missing, unreadable, empty, not MCAP, or damaged.
    """
    try:
        size = limits.require_file(path, _MOST_SIZE)
        with path.open("rb", buffering=0) as file:
            start = _read(file.fileno(), 0, min(size, len(MAGIC)))
            _require_mcap(path, start)
            index = _by_summary(path, file.fileno(), size) or _by_records(path, file.fileno(), size)
    except limits.LimitError as error:
        raise damaged(path, error) from error
    except OSError as error:
        raise RecordError(
            f"the record cannot be read: {error.strerror or error}",
            where=str(path),
            mend="give the record.mcap that `palpate run` wrote",
        ) from error
    if not index.complete:
        _drop_unsound(index)
    return index


def require_unpackable(path: Path) -> None:
    """Refuse an MCAP file whose chunks announce more unpacked data than telemetry has; only their headers are read.

    Raises:
        LimitError: they do. OSError: the file cannot be read.
    """
    size, unpacked = limits.require_file(path), 0
    most = max(limits.MOST_UNPACKED, _MOST_RATIO * size)
    with path.open("rb") as file:
        position = len(MAGIC)
        while position + 9 <= size:
            file.seek(position)
            opcode, length = struct.unpack("<BQ", file.read(9))
            if opcode == 0 or length > size:
                return
            if opcode == Opcode.CHUNK and length >= 24:
                unpacked += int.from_bytes(file.read(24)[16:], "little")
                limits.require_unpacked(unpacked, most)
            position += 9 + length


def chunk_data(chunk: records.Chunk, path: Path) -> bytes:
    """The decompressed messages of a chunk.

    Raises:
        RecordError: the chunk is damaged.
    """
    try:
        return _unpacked(chunk.data, chunk.compression, chunk.uncompressed_size, chunk.uncompressed_crc)
    except DAMAGE as error:
        raise damaged(path, error) from error


def _unpacked(data: bytes, kind: str, size: int, crc: int) -> bytes:
    """Unpacked data of a chunk; ValueError for a wrong checksum, and as `limits.unpack`."""
    found = limits.unpack(data, kind, size)
    if crc not in (0, zlib.crc32(found)):
        raise ValueError("its checksum is wrong")
    return found


def whole_records(
    data: memoryview, take_chunks: Callable[[int], int] | None = None
) -> Iterator[tuple[int, memoryview]]:
    """Complete records in `data` as (opcode, body); stops at the first truncated record, and where zeros begin.

    take_chunks: takes the entries of chunks from a position on, and returns where they end.
    """
    position = 0
    while position + 9 <= len(data):
        opcode, length = struct.unpack_from("<BQ", data, position)
        if opcode == 0 or position + 9 + length > len(data):
            return
        if opcode == Opcode.CHUNK_INDEX and take_chunks is not None:
            position = take_chunks(position)
            continue
        yield opcode, data[position + 9 : position + 9 + length]
        position += 9 + length


def damaged(path: Path, error: Exception) -> RecordError:
    """The error for a file that cannot be parsed."""
    return RecordError(
        "the record is damaged",
        where=str(path),
        why=f"{error or type(error).__name__}",
        mend="run again; the bytes were changed after they were written",
    )


def _require_mcap(path: Path, start: bytes) -> None:
    if not start:
        raise RecordError("the record is empty", where=str(path), why="nothing was written", mend="run again")
    if start != MAGIC:
        raise RecordError(
            "not an MCAP file" if len(start) >= len(MAGIC) else "the record is cut short",
            where=str(path),
            why=f"it begins with {start!r}",
            mend="give the record.mcap that `palpate run` wrote",
        )


def _read(file: int, offset: int, length: int) -> bytes:
    """`length` bytes from `offset`, or fewer at the end of the file."""
    first = os.pread(file, min(length, 1 << 24), offset)
    if len(first) == length:
        return first
    found = bytearray(first)
    while first and len(found) < length:
        piece = os.pread(file, min(length - len(found), 1 << 24), offset + len(found))
        if not piece:
            break
        found += piece
    return bytes(found)


def _by_summary(path: Path, file: int, size: int) -> Index | None:
    """The content by the summary at the end of the file; None if there is none, or its checksum is wrong."""
    tail = _read(file, size - _FOOTER.size - len(MAGIC), _FOOTER.size + len(MAGIC)) if size > 64 else b""
    if len(tail) < _FOOTER.size + len(MAGIC) or not tail.endswith(MAGIC):
        return None
    opcode, length, start, _, crc = _FOOTER.unpack_from(tail)
    if opcode != Opcode.FOOTER or length != 20 or not len(MAGIC) < start < size - len(tail):
        return None
    summary = _read(file, start, size - len(tail) - start)
    if crc == 0 or zlib.crc32(tail[: _FOOTER.size - 4], zlib.crc32(summary)) != crc:
        return None
    index = Index(path, complete=True, sound=start)
    try:
        for kind, body in whole_records(memoryview(summary), lambda at: _take_places(index.chunks, summary, at)):
            if kind in (Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX):
                offset, length = struct.unpack_from("<QQ", body)
                inner = memoryview(_read(file, offset, _bounded(length)))
                for one, content in whole_records(inner):
                    _take(index, one, content)
            else:
                _take(index, kind, body)
    except (*DAMAGE, RecordError):
        return None
    limits.require_unpacked(sum(index.chunks.column("size")), max(limits.MOST_UNPACKED, _MOST_RATIO * size))
    inside = all(map(start.__ge__, map(add, index.chunks.column("offset"), index.chunks.column("length"))))
    return index if inside and index.channels else None


def _bounded(size: int) -> int:
    """The size of an attachment, refused if no file has one as large."""
    limits.require_unpacked(size)
    return size


def _take_places(chunks: Places, summary: bytes, position: int) -> int:
    """Append the chunks whose entries of one form follow each other from a position on; returns where they end.

    An hour has 25,000 entries of one form.
    """
    length, *_, width = _INDEX_ENTRY.unpack_from(summary, position)
    at = _INDEX_ENTRY.size + width
    _, kind = _INDEX_REST.unpack_from(summary, position + at)
    size = at + _INDEX_REST.size + kind + 8
    row = 9 + length
    if size + 8 > row or width % 10:
        raise ValueError("the entry of a chunk is damaged")
    most = min((len(summary) - position) // row, _AT_ONCE)
    rows = np.frombuffer(summary, np.uint8, most * row, position).reshape(-1, row)
    form = np.r_[0:9, 41:45, at + 8 : at + 12]  # opcode, length, bytes of the places of message indexes, of the kind
    alike = (rows[:, form] == rows[0, form]).all(axis=1)
    rows = rows[: len(rows) if alike.all() else int(alike.argmin())]
    numbers = np.hstack([rows[:, 25:41], rows[:, 9:25], rows[:, size : size + 8]])
    of = rows[:, _INDEX_ENTRY.size : at].reshape(len(rows), -1, 10)[:, :, :2]
    channels = np.sort(np.ascontiguousarray(of).view("<u2")[..., 0], axis=1).tolist()
    chunks.append_rows(numbers.view("<u8"), map(tuple, channels))
    return position + int(len(rows) * row)


def _by_records(path: Path, file: int, size: int) -> Index:
    """The content record by record, up to the last whole one; the data of chunks are passed over."""
    index, unpacked = Index(path), 0
    position = index.sound = len(MAGIC)
    while position + 9 <= size:
        opcode, length = struct.unpack("<BQ", _read(file, position, 9))
        if opcode == 0 or position + 9 + length > size:
            return index
        if opcode == Opcode.FOOTER:
            index.complete = _read(file, position + 9 + length, len(MAGIC) + 1) == MAGIC
            return index
        if opcode == Opcode.CHUNK:
            head = _CHUNK_HEAD.unpack(_read(file, position, _CHUNK_HEAD.size))
            index.chunks.append(Place(position, 9 + length, head[2], head[3], head[4], ()))
            unpacked += head[4]
            limits.require_unpacked(unpacked, max(limits.MOST_UNPACKED, _MOST_RATIO * size))
            if not index.channels:  # the writer of the mcap library puts schemas and channels into the first chunk
                for inner, body in whole_records(memoryview(index.load(index.chunks[-1]))):
                    if inner in (Opcode.SCHEMA, Opcode.CHANNEL):
                        _take(index, inner, body)
        elif opcode == Opcode.MESSAGE_INDEX and index.chunks:
            channel = int.from_bytes(_read(file, position + 9, 2), "little")
            last = index.chunks[-1]
            index.chunks[-1] = last._replace(channels=tuple(sorted({*last.channels, channel})))
        elif opcode in (Opcode.DATA_END, Opcode.CHUNK_INDEX, Opcode.STATISTICS, Opcode.SUMMARY_OFFSET):
            pass
        else:
            limits.require_unpacked(length)
            _take(index, opcode, memoryview(_read(file, position + 9, length)))
        position += 9 + length
        index.sound = position
    return index


def _drop_unsound(index: Index) -> None:
    """Drop the chunks from the first damaged one on: a full disk or a lost machine leaves zeros at the end."""
    for k, place in enumerate(index.chunks[:-1]):
        if not place.channels:
            index.chunks[k] = place._replace(channels=_channels_in(index, place))
    for k in range(max(0, len(index.chunks) - 64), len(index.chunks)):
        try:
            found = _channels_in(index, index.chunks[k])
        except RecordError:
            if k == 0:
                raise
            index.sound = index.chunks[k].offset
            del index.chunks[k:]
            return
        index.chunks[k] = index.chunks[k]._replace(channels=found)


def _channels_in(index: Index, place: Place) -> tuple[int, ...]:
    """Channels of the messages of a chunk, from its messages."""
    data = memoryview(index.load(place))
    return tuple(sorted({_channel(body) for opcode, body in whole_records(data) if opcode == Opcode.MESSAGE}))


def _channel(body: memoryview) -> int:
    return body[0] | body[1] << 8 if len(body) >= MESSAGE_HEAD.size - 9 else -1


def _take(index: Index, opcode: int, body: memoryview) -> None:
    path = index.path
    if opcode == Opcode.SCHEMA:
        schema = _parse(body, path, records.Schema.read)
        index.schemas[schema.id] = schema
    elif opcode == Opcode.CHANNEL:
        channel = _parse(body, path, records.Channel.read)
        index.channels[channel.id] = channel
    elif opcode == Opcode.ATTACHMENT:
        attachment = _parse(body, path, records.Attachment.read)
        index.attachments[attachment.name] = attachment.data
    elif opcode == Opcode.METADATA:
        metadata = _parse(body, path, records.Metadata.read)
        index.metadata[metadata.name] = metadata.metadata
    elif opcode == Opcode.MESSAGE:
        index.loose.append(_parse_message(body, path))


def _parse(body: memoryview, path: Path, read: Callable[[ReadDataStream], Any]) -> Any:
    try:
        return read(ReadDataStream(BytesIO(body)))
    except DAMAGE as error:
        raise damaged(path, error) from error


def _parse_message(body: memoryview, path: Path) -> records.Message:
    message: records.Message = _parse(body, path, lambda stream: records.Message.read(stream, len(body)))
    return message
