"""Messages of OpenIGTLink from the bytes of a connection, as PLUS, 3D Slicer and bridges of NDI trackers send them.

Poses come as TRANSFORM, QTDATA, TDATA or POSITION (openigtlink.org, versions 1 to 3 of the header). All other messages
are skipped without being kept, whatever their size, and are counted by type and name.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from palpate.base.arrays import Array

LONGEST_NAME = 20
"""Most bytes of a device's name on the wire."""
_HEADER = struct.Struct(">H12s20sIIQQ")
_EXTENDED = struct.Struct(">HHII")
_LONGEST_POSE = 2**20  # a longer message of a known type is damage: poses and their metadata are hundreds of bytes
_LONGEST = 2**30  # a longer message of any type is damage: a volume is 100 MB [bytes]
_MOST_KINDS = 64  # kinds of messages that are told apart


@dataclass(frozen=True)
class Pose:
    """A pose from a message."""

    tool: str
    """device's name of a TRANSFORM or POSITION, tool's name inside a QTDATA or TDATA; at most 20 bytes are sent"""
    X: Array
    """(4, 4), in millimetres as sent"""
    stamp: float
    """seconds since 1970; 0: the sender has no clock"""
    metadata: dict[str, str]
    """by key in lower case"""


@dataclass
class Decoder:
    """Poses of a stream of bytes; `counts` says what else arrived.

    Args:
        crc: checksum of a body; None: checksums are not compared.
    """

    crc: Callable[[bytes], int] | None = None
    counts: dict[tuple[str, str], int] = field(default_factory=dict)
    """number of messages by type and name"""
    damaged: int = 0
    """number of messages whose checksum or content was wrong"""
    fault: str = ""
    """what was wrong with the last of these, in words"""
    _buffer: bytearray = field(default_factory=bytearray)
    _skip: int = 0

    def feed(self, data: bytes) -> list[Pose]:
        """Poses that are complete with these bytes, in their order.

        Raises:
            ValueError: the bytes are no OpenIGTLink; the connection must be made again.
        """
        skipped = min(self._skip, len(data))
        self._skip -= skipped
        self._buffer += memoryview(data)[skipped:]
        found: list[Pose] = []
        while len(self._buffer) >= _HEADER.size:
            version, kind_, name_, seconds, fraction, size, crc = _HEADER.unpack_from(self._buffer)
            kind, name = _text(kind_), _text(name_)
            if not 1 <= version <= 16 or not kind.replace("_", "").isalnum():
                raise ValueError(f"a header of version {version} and type {kind_!r}")
            known = _CONTENTS.get(kind)
            if size > (_LONGEST if known is None else _LONGEST_POSE):
                raise ValueError(f"a {kind} of {size:,} bytes is announced")
            if known is not None and len(self._buffer) < _HEADER.size + size:
                break
            self._count(kind, name)
            body = bytes(self._buffer[_HEADER.size : _HEADER.size + size])
            self._skip = _HEADER.size + size - min(len(self._buffer), _HEADER.size + size)
            del self._buffer[: _HEADER.size + size]
            if known is not None:
                found += self._poses(kind, name, version, seconds + fraction / 2**32, body, crc)
        return found

    def _count(self, kind: str, name: str) -> None:
        if (kind, name) in self.counts or len(self.counts) < _MOST_KINDS:
            self.counts[kind, name] = self.counts.get((kind, name), 0) + 1

    def _poses(self, kind: str, name: str, version: int, stamp: float, body: bytes, crc: int) -> list[Pose]:
        if crc and self.crc is not None and self.crc(body) != crc:  # 0: the sender computes none
            self.damaged, self.fault = self.damaged + 1, f"the checksum of a {kind} of {name} is wrong"
            return []
        try:
            content, metadata = _parts(body) if version > 1 else (body, {})
            return [Pose(tool or name, X, stamp, metadata) for tool, X in _CONTENTS[kind](content)]
        except (struct.error, ValueError) as error:
            why = "it has no pose" if isinstance(error, struct.error) else str(error)
            self.damaged, self.fault = self.damaged + 1, f"a {kind} of {name} with {len(body)} bytes: {why}"
            return []


def first_message() -> bytes:
    """GET_STATUS with a header of version 2: a server then answers in version 2, whose metadata carry validity."""
    body = _EXTENDED.pack(_EXTENDED.size, 2, 0, 1) + struct.pack(">H", 0)
    return _HEADER.pack(2, b"GET_STATUS", b"palpate", 0, 0, len(body), 0) + body


def _text(data: bytes) -> str:
    return data.split(b"\0")[0].decode("utf-8", "replace").strip()


def _parts(body: bytes) -> tuple[bytes, dict[str, str]]:
    """Content and metadata of the body of a message of version 2 or more."""
    size, index, data, _ = _EXTENDED.unpack_from(body)
    end = len(body) - index - data
    if size < _EXTENDED.size or end < size:
        raise ValueError("the extended header does not fit its message")
    found, at, value_at = {}, end + 2, end + index
    for _ in range(struct.unpack_from(">H", body, end)[0] if index >= 2 else 0):
        key_size, _encoding, value_size = struct.unpack_from(">HHI", body, at)
        at += 8
        key = body[value_at : value_at + key_size].decode("utf-8", "replace")
        value = body[value_at + key_size : value_at + key_size + value_size].decode("utf-8", "replace")
        value_at += key_size + value_size
        found[key.strip().lower()] = value.strip()
    return body[size:end], found


def _transform(data: bytes) -> Iterator[tuple[str, Array]]:
    yield "", _matrix(struct.unpack_from(">12f", data))


def _tdata(data: bytes) -> Iterator[tuple[str, Array]]:
    for name, *numbers in struct.Struct(">20sxx12f").iter_unpack(data):
        yield _text(name), _matrix(numbers)


def _qtdata(data: bytes) -> Iterator[tuple[str, Array]]:
    for name, *numbers in struct.Struct(">20sxx7f").iter_unpack(data):
        yield _text(name), _turned(numbers[:3], numbers[3:])


def _position(data: bytes) -> Iterator[tuple[str, Array]]:
    if len(data) == 24:  # compressed: a quaternion of unit length without its real part
        *p, x, y, z = struct.unpack(">6f", data)
        yield "", _turned(p, [x, y, z, math.sqrt(max(0.0, 1.0 - x * x - y * y - z * z))])
        return
    if len(data) != 28:
        raise ValueError("a POSITION of 24 or 28 bytes is read" if len(data) != 12 else "it has no orientation")
    *p, x, y, z, w = struct.unpack(">7f", data)
    yield "", _turned(p, [x, y, z, w])


_CONTENTS = {"TRANSFORM": _transform, "TDATA": _tdata, "QTDATA": _qtdata, "POSITION": _position}


def _matrix(numbers: tuple[float, ...] | list[float]) -> Array:
    X = np.eye(4)
    X[:3, :] = np.array(numbers, dtype=np.float64).reshape(4, 3).T
    return X


def _turned(p: list[float], q: list[float]) -> Array:
    """Pose of a position and a quaternion x, y, z, w, whose wrong length stays in the matrix and is refused."""
    x, y, z, w = (float(c) for c in q)
    X = np.eye(4)
    X[:3, :3] = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    X[:3, 3] = p
    return X
