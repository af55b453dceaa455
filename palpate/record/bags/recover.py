"""Reads MCAP files that are cut short, end in zeros, or have no chunks, up to there, and makes whole ones of them.

A recorder that was killed leaves no summary, and a half chunk; the library rosbags reads by the summary alone.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.writer import CompressionType, Writer

from palpate.base import limits
from palpate.base.errors import RecordError
from palpate.record.mcap_file import MAGIC
from palpate.record.mcap_scan import DAMAGE, chunk_data, whole_records

_PIECE = 4096  # packed bytes that are unpacked at once: damage costs what comes after it alone
_CHUNK = struct.Struct("<QQQI")  # first and last time, unpacked size, checksum


@dataclass
class Found:
    """What is whole in a file."""

    schemas: dict[int, records.Schema] = field(default_factory=dict)
    channels: dict[int, records.Channel] = field(default_factory=dict)
    messages: list[records.Message] = field(default_factory=list)
    end: str = ""
    """where and why the reading ended before the file's own end, in words; empty if it did not"""


def needs_recovery(path: Path) -> bool:
    """Whether an MCAP file has no end, no summary of chunks, or messages beside chunks; only record heads are read."""
    size, chunks, loose = path.stat().st_size, 0, 0
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            return False
        position = len(MAGIC)
        while position + 9 <= size:
            file.seek(position)
            opcode, length = struct.unpack("<BQ", file.read(9))
            if opcode == Opcode.FOOTER:
                summary = struct.unpack("<Q", file.read(8))[0] if length >= 8 else 0
                file.seek(position + 9 + length)
                return file.read(len(MAGIC)) != MAGIC or loose > 0 or (chunks > 0 and not summary)
            chunks += opcode == Opcode.CHUNK
            loose += opcode == Opcode.MESSAGE
            if opcode == 0 or position + 9 + length > size:
                return True
            position += 9 + length
    return True


def recover(path: Path, copy: Path) -> str:
    """Write what is whole in a file as a whole file; returns where the reading ended, in words.

    Raises:
        RecordError: nothing in it is whole. OSError: a file cannot be read or written.
    """
    found = read(path)
    if not found.messages:
        why = found.end or "it has no message"
        raise RecordError("the bag holds no whole message", where=str(path), why=why, mend="record again")
    with copy.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start(profile="ros2", library="palpate")
        schemas = {k: writer.register_schema(one.name, one.encoding, one.data) for k, one in found.schemas.items()}
        channels = {
            k: writer.register_channel(one.topic, one.message_encoding, schemas.get(one.schema_id, 0), one.metadata)
            for k, one in found.channels.items()
        }
        for one in found.messages:
            if one.channel_id in channels:
                writer.add_message(channels[one.channel_id], one.log_time, one.data, one.publish_time, one.sequence)
        writer.finish()  # type: ignore[no-untyped-call]
    return found.end


def read(path: Path) -> Found:
    """Everything that is whole. OSError: the file cannot be read."""
    data, found = memoryview(limits.read_bytes(path)), Found()
    position, unpacked = len(MAGIC), 0
    while position + 9 <= len(data):
        opcode, length = struct.unpack_from("<BQ", data, position)
        body = data[position + 9 : position + 9 + length]
        if opcode == 0:
            found.end = f"it is empty (zeros) from byte {position:,} on"
            return found
        if opcode in (Opcode.DATA_END, Opcode.FOOTER):  # what follows repeats what was read
            return found
        if len(body) < length:
            found.end = f"it is cut off in the record at byte {position:,}"
        try:
            if opcode == Opcode.CHUNK:
                inner, fault = _inside(body, path, whole=len(body) == length)
                found.end = found.end or (f"the chunk at byte {position:,} is damaged ({fault})" if fault else "")
                unpacked += len(inner)
                limits.require_unpacked(unpacked, max(limits.MOST_UNPACKED, 64 * len(data)))
                for one, part in whole_records(memoryview(inner)):
                    _take(found, one, part)
            elif len(body) == length:
                _take(found, opcode, body)
        except (*DAMAGE, EOFError) as error:
            why = " ".join(str(error).split())[:120]
            found.end = found.end or f"the record at byte {position:,} is damaged ({why})"
            return found
        if found.end:
            return found
        position += 9 + length
    found.end = "it has no end"
    return found


def _inside(body: memoryview, path: Path, whole: bool) -> tuple[bytes, str]:
    """The records in a chunk, as far as they are sound, and why not all are."""
    fault = ""
    if whole:
        try:
            return chunk_data(records.Chunk.read(ReadDataStream(BytesIO(body))), path), ""
        except RecordError as error:
            fault = str(error.why)
    *_, size, _crc = _CHUNK.unpack_from(body)
    limits.require_unpacked(size)
    (width,) = struct.unpack_from("<I", body, _CHUNK.size)
    kind = bytes(body[_CHUNK.size + 4 : _CHUNK.size + 4 + width]).decode()
    packed = bytes(body[_CHUNK.size + 12 + width :])
    sound = packed[:size] if not kind else _unpacked(kind, packed, size)
    return sound.rstrip(b"\0"), fault  # zeros at the end were never written: the message before them is incomplete


def _unpacked(kind: str, packed: bytes, size: int) -> bytes:
    """What can be unpacked before the data are damaged or end."""
    unpack: Any
    if kind == "zstd":
        unpack = zstandard.ZstdDecompressor(max_window_size=1 << 27).decompressobj()
    elif kind == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped, unused-ignore]

        unpack = LZ4FrameDecompressor()
    else:
        raise ValueError(f"compression {kind!r}; zstd and lz4 are read")
    found = bytearray()
    try:
        for at in range(0, len(packed), _PIECE):
            found += unpack.decompress(packed[at : at + _PIECE])
            if len(found) > size:
                break
    except (zstandard.ZstdError, RuntimeError, EOFError):
        pass
    return bytes(found[:size])


def _take(found: Found, opcode: int, body: memoryview) -> None:
    stream = ReadDataStream(BytesIO(body))
    if opcode == Opcode.SCHEMA:
        schema = records.Schema.read(stream)
        found.schemas[schema.id] = schema
    elif opcode == Opcode.CHANNEL:
        channel = records.Channel.read(stream)
        found.channels[channel.id] = channel
    elif opcode == Opcode.MESSAGE:
        found.messages.append(records.Message.read(stream, len(body)))
