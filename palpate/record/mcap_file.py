"""Writes an MCAP file one chunk at a time.

The record classes are those of the `mcap` library, but for chunks. Its `Writer` takes one message per call, 3 us each.
`McapFile` takes whole chunks of serialised messages.
Writes are unbuffered: a killed process only loses the chunk that is not yet written.
"""

from __future__ import annotations

import hashlib
import os
import struct
import tempfile
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import zstandard
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from numpy.typing import NDArray

MAGIC = b"\x89MCAP0\r\n"
MESSAGE_HEAD = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
_KIND = b"zstd"
# The records that a chunk needs, packed here: the library's classes take longer than the compression. Opcode and length
# of a record; a chunk up to its data; a message index up to its entries; an entry of a chunk index; its begin and end.
_RECORD = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<BQQQQII4sQ")
_MESSAGE_INDEX = struct.Struct("<BQHI")
_OFFSET = struct.Struct("<HQ")
_CHUNK_INDEX = struct.Struct("<QQQQI")
_CHUNK_INDEX_END = struct.Struct("<QI4sQQ")
PIECE = 1 << 20  # [bytes] of the chunks' index that are read back at once


@dataclass(frozen=True)
class Block:
    """Messages of one chunk: n ticks of equal length, with one message per channel and tick."""

    data: NDArray[np.uint8]
    """(n, bytes per tick) serialised MCAP message records."""
    log_time: NDArray[np.uint64]
    """(n,) [ns], ascending."""
    offsets: dict[int, int]
    """Channel id -> position of its message within a tick [bytes]."""


class McapFile:
    """An MCAP file in the making: header, schemas, channels, attachments, metadata, chunks, and finally the summary.

    Raises:
        OSError: from any method, if the file cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb", buffering=0)
        self._sha256 = hashlib.sha256()
        self._zstd = zstandard.ZstdCompressor(level=1)
        self._size = 0
        self._schemas: list[records.Schema] = []
        self._channels: list[records.Channel] = []
        #: Serialised, in a file without a name: a run of days has hundreds of thousands, which would fill the memory.
        #: Beside the record, where there is space for it, unless the record is a device, such as /dev/full.
        beside = path.parent if os.access(path.parent, os.W_OK) else None
        self._chunk_indexes = tempfile.TemporaryFile(dir=beside)  # noqa: SIM115 (closed with the record)
        self._chunk_count = 0
        self._start, self._end = 0, 0  # times of the first and the last message [ns]
        self._attachments: list[records.AttachmentIndex] = []
        self._metadata: list[records.MetadataIndex] = []
        self.counts: dict[int, int] = {}
        """Number of messages of each channel."""

    def begin(self, *, profile: str, library: str) -> None:
        """Write the header."""
        self._write(MAGIC + _bytes(records.Header(profile, library)))

    def add_schema(self, name: str, encoding: str, text: str) -> int:
        """Register a message type; returns its id."""
        schema = records.Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=text.encode())
        self._schemas.append(schema)
        self._write(_bytes(schema))
        return schema.id

    def add_channel(self, topic: str, schema: int, encoding: str, metadata: dict[str, str]) -> int:
        """Register a channel; returns its id."""
        channel = records.Channel(len(self._channels) + 1, topic, encoding, metadata, schema)
        self._channels.append(channel)
        self._write(_bytes(channel))
        return channel.id

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Write a table of strings."""
        data = _bytes(records.Metadata(name=name, metadata=values))
        self._metadata.append(records.MetadataIndex(offset=self._size, length=len(data), name=name))
        self._write(data)

    def add_attachment(self, name: str, media_type: str, text: str) -> None:
        """Write a text as an attachment."""
        content = text.encode()
        data = _bytes(records.Attachment(0, 0, name, media_type, content))
        index = records.AttachmentIndex(self._size, len(data), 0, 0, len(content), name, media_type)
        self._attachments.append(index)
        self._write(data)

    def topics(self) -> list[tuple[str, str, int]]:
        """Topic, message type and number of messages; of a topic with several channels, the type of the first."""
        found: dict[str, tuple[str, int]] = {}
        for channel in self._channels:
            schema, count = found.get(channel.topic, (self._schemas[channel.schema_id - 1].name, 0))
            found[channel.topic] = (schema, count + self.counts.get(channel.id, 0))
        return [(topic, schema, count) for topic, (schema, count) in found.items()]

    def add_chunk(self, block: Block) -> None:
        """Write the messages of a block of ticks, with the index of each channel."""
        ticks = np.arange(len(block.data), dtype=np.uint64) * block.data.shape[1]
        index = {channel: np.stack([block.log_time, ticks + offset], 1) for channel, offset in block.offsets.items()}
        self._add(block.data.tobytes(), int(block.log_time[0]), int(block.log_time[-1]), index)

    def add_messages(self, messages: Sequence[tuple[int, int, bytes]]) -> None:
        """Write messages of any length as a chunk: channel, time [ns] and serialised data of each, in order of time."""
        raw, index = bytearray(), dict[int, list[tuple[int, int]]]()
        for channel, time, data in messages:
            index.setdefault(channel, []).append((time, len(raw)))
            sequence = self.counts.get(channel, 0) + len(index[channel]) - 1
            raw += MESSAGE_HEAD.pack(Opcode.MESSAGE, MESSAGE_HEAD.size - 9 + len(data), channel, sequence, time, time)
            raw += data
        entries = {channel: np.array(places, dtype=np.uint64) for channel, places in index.items()}
        self._add(bytes(raw), messages[0][1], messages[-1][1], entries)

    def _add(self, raw: bytes, start: int, end: int, entries: dict[int, NDArray[np.uint64]]) -> None:
        """Write a chunk; entries: time [ns] and position of each message, (n, 2), by channel."""
        packed = self._zstd.compress(raw)
        body = _CHUNK_HEAD.size - 9 + len(packed)
        head = _CHUNK_HEAD.pack(
            Opcode.CHUNK, body, start, end, len(raw), zlib.crc32(raw), len(_KIND), _KIND, len(packed)
        )
        parts, at, offsets = [head, packed], self._size + len(head) + len(packed), bytearray()
        after = at
        for channel, places in entries.items():
            offsets += _OFFSET.pack(channel, at)
            parts.append(_MESSAGE_INDEX.pack(Opcode.MESSAGE_INDEX, 6 + places.nbytes, channel, places.nbytes))
            parts.append(places.astype("<u8").tobytes())
            at += _MESSAGE_INDEX.size + places.nbytes
            self.counts[channel] = self.counts.get(channel, 0) + len(places)
        chunk = (start, end, self._size, len(head) + len(packed), len(offsets))
        index = _CHUNK_INDEX.pack(*chunk) + offsets
        index += _CHUNK_INDEX_END.pack(at - after, len(_KIND), _KIND, len(packed), len(raw))
        self._write(b"".join(parts))
        self._chunk_indexes.write(_RECORD.pack(Opcode.CHUNK_INDEX, len(index)) + index)
        self._start = self._start if self._chunk_count else start
        self._end = max(self._end, end)
        self._chunk_count += 1

    def finish(self) -> str:
        """Write the summary and close the file; returns its SHA-256 (hexadecimal)."""
        self._write(_bytes(records.DataEnd(0)))
        start = self._size
        statistics = records.Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=dict(sorted(self.counts.items())),
            chunk_count=self._chunk_count,
            message_count=sum(self.counts.values()),
            message_end_time=self._end,
            message_start_time=self._start,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        self._chunk_indexes.seek(0)
        groups: list[tuple[Opcode, Iterable[bytes]]] = [
            (Opcode.SCHEMA, map(_bytes, self._schemas)),
            (Opcode.CHANNEL, map(_bytes, self._channels)),
            (Opcode.STATISTICS, [_bytes(statistics)]),
            (Opcode.CHUNK_INDEX, iter(lambda: self._chunk_indexes.read(PIECE), b"")),
            (Opcode.ATTACHMENT_INDEX, map(_bytes, self._attachments)),
            (Opcode.METADATA_INDEX, map(_bytes, self._metadata)),
        ]
        offsets, crc = b"", 0
        for opcode, pieces in groups:
            begin = self._size
            for piece in pieces:
                crc = zlib.crc32(piece, crc)
                self._write(piece)
            if self._size > begin:
                offsets += _bytes(records.SummaryOffset(opcode, begin, self._size - begin))
        rest = offsets + _bytes(records.Footer(start, self._size, 0))[:-4]  # without its checksum, which is 0 here
        self._write(rest + zlib.crc32(rest, crc).to_bytes(4, "little") + MAGIC)
        self._chunk_indexes.close()
        self._file.close()
        return self._sha256.hexdigest()

    def abandon(self) -> None:
        """Close after a failed write, truncated to the last complete record. Does not raise."""
        try:
            self._file.truncate(self._size)
        except OSError:
            pass  # the reader ignores an incomplete record at the end
        finally:
            self._chunk_indexes.close()
            self._file.close()

    def _write(self, data: bytes) -> None:
        rest = memoryview(data)
        while rest:
            rest = rest[self._file.write(rest) :]
        self._sha256.update(data)
        self._size += len(data)


def _bytes(record: records.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]


def strided(data: NDArray[np.uint8], offset: int, kind: str, count: int = 1) -> NDArray[Any]:
    """A view of `count` numbers of type `kind` at byte `offset` of each row: (n, count)."""
    dtype = np.dtype(kind)
    return np.ndarray((len(data), count), dtype, data, offset, (data.strides[0], dtype.itemsize))
