"""Reads an MCAP file sequentially, up to the last complete record.

The file of a killed run has no summary at its end, but the records before the first chunk hold the same information.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from palpate import limits
from palpate.errors import RecordError
from palpate.record.mcap_file import MAGIC

_MOST_RATIO = 64  # unpacked bytes for each byte of a file: telemetry reaches 10
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


@dataclass
class Scan:
    """Contents of a file."""

    channels: dict[int, records.Channel] = field(default_factory=dict)
    schemas: dict[int, str] = field(default_factory=dict)
    """Schema id -> name."""
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    chunks: list[records.Chunk] = field(default_factory=list)
    loose: list[records.Message] = field(default_factory=list)
    """Messages outside any chunk."""
    complete: bool = False
    """True if the file has its footer."""

    def messages(self, path: Path) -> Iterator[records.Message]:
        """Every message, in the order of the file."""
        for chunk in self.chunks:
            for opcode, body in whole_records(memoryview(chunk_data(chunk, path))):
                if opcode == Opcode.MESSAGE:
                    yield _parse_message(body, path)
        yield from self.loose


def scan(path: Path) -> Scan:
    """Read the file.

    Raises:
        RecordError: the file is missing, unreadable, empty, not MCAP, or damaged.
    """
    content, unpacked = Scan(), 0
    data = memoryview(_load(path))
    most = max(limits.MOST_UNPACKED, _MOST_RATIO * len(data))
    position = len(MAGIC)
    for opcode, body in whole_records(data[position:]):
        position += 9 + len(body)
        if opcode == Opcode.FOOTER:
            content.complete = bytes(data[position:]) == MAGIC
            break
        _take(content, opcode, body, path)
        if opcode == Opcode.CHUNK:
            unpacked += content.chunks[-1].uncompressed_size
            if unpacked > most:
                raise damaged(path, limits.LimitError(f"it unfolds to more than {most:,} bytes"))
    if not content.complete and content.chunks:  # zeros that a full disk or a lost machine left in the last chunk
        try:
            chunk_data(content.chunks[-1], path)
        except RecordError:
            if len(content.chunks) == 1:
                raise
            content.chunks.pop()
    return content


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
        data = limits.unpack(chunk.data, chunk.compression, chunk.uncompressed_size)
        if chunk.uncompressed_crc not in (0, zlib.crc32(data)):
            raise ValueError("its checksum is wrong")
    except DAMAGE as error:
        raise damaged(path, error) from error
    return data


def _load(path: Path) -> bytes:
    try:
        data = limits.read_bytes(path)
    except OSError as error:
        raise RecordError(
            f"the record cannot be read: {error.strerror or error}",
            where=str(path),
            mend="give the record.mcap that `palpate run` wrote",
        ) from error
    if not data:
        raise RecordError("the record is empty", where=str(path), why="nothing was written", mend="run again")
    if not data.startswith(MAGIC):
        raise RecordError(
            "not an MCAP file" if len(data) >= len(MAGIC) else "the record is cut short",
            where=str(path),
            why=f"it begins with {data[:8]!r}",
            mend="give the record.mcap that `palpate run` wrote",
        )
    return data


def whole_records(data: memoryview) -> Iterator[tuple[int, memoryview]]:
    """Complete records in `data` as (opcode, body); stops at the first truncated record, and where zeros begin."""
    position = 0
    while position + 9 <= len(data):
        opcode, length = struct.unpack_from("<BQ", data, position)
        if opcode == 0 or position + 9 + length > len(data):
            return
        yield opcode, data[position + 9 : position + 9 + length]
        position += 9 + length


def _take(content: Scan, opcode: int, body: memoryview, path: Path) -> None:
    if opcode == Opcode.CHUNK:
        chunk = _parse(body, path, records.Chunk.read)
        content.chunks.append(chunk)
        if not content.channels:  # the writer of the mcap library puts schemas and channels into the first chunk
            for inner, inner_body in whole_records(memoryview(chunk_data(chunk, path))):
                if inner in (Opcode.SCHEMA, Opcode.CHANNEL):
                    _take(content, inner, inner_body, path)
    elif opcode == Opcode.SCHEMA:
        schema = _parse(body, path, records.Schema.read)
        content.schemas[schema.id] = schema.name
    elif opcode == Opcode.CHANNEL:
        channel = _parse(body, path, records.Channel.read)
        content.channels[channel.id] = channel
    elif opcode == Opcode.ATTACHMENT:
        attachment = _parse(body, path, records.Attachment.read)
        content.attachments[attachment.name] = attachment.data
    elif opcode == Opcode.METADATA:
        metadata = _parse(body, path, records.Metadata.read)
        content.metadata[metadata.name] = metadata.metadata
    elif opcode == Opcode.MESSAGE:
        content.loose.append(_parse_message(body, path))


def _parse(body: memoryview, path: Path, read: Callable[[ReadDataStream], Any]) -> Any:
    try:
        return read(ReadDataStream(BytesIO(body)))
    except DAMAGE as error:
        raise damaged(path, error) from error


def _parse_message(body: memoryview, path: Path) -> records.Message:
    message: records.Message = _parse(body, path, lambda stream: records.Message.read(stream, len(body)))
    return message


def damaged(path: Path, error: Exception) -> RecordError:
    """The error for a file that cannot be parsed."""
    return RecordError(
        "the record is damaged",
        where=str(path),
        why=f"{error or type(error).__name__}",
        mend="run again; the bytes were changed after they were written",
    )
