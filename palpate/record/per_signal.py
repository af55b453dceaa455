"""Layout of the first records of palpate 0.1.0: one channel and one message a tick for each signal. Only read today.

Every message of a channel has the same length, because names and frames are constant. A tick is therefore a fixed
block of bytes. Later records have a message for a group of signals (`palpate.record.layout`).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from palpate.record.messages import TYPE_OF_PART
from palpate.record.ticks import Signal

_LITTLE_ENDIAN_CDR = b"\x00\x01\x00\x00"


def topic(signal: Signal) -> str:
    """Name of the channel, e.g. ``/force/F_T_W``."""
    return f"/{signal.stage}/{signal.name}"


def part(signal: Signal) -> str:
    """The field of a message that carries the signal: position, velocity, effort, point, vector, force, ..."""
    if signal.size == 1:
        return "data"
    if signal.size == 3:
        return "force" if signal.unit == "N" else "point" if signal.name.startswith("p_") else "vector"
    if signal.name.startswith("quat"):
        return "quaternion"
    return {"rad/s": "velocity", "N m": "effort"}.get(signal.unit, "position")


@dataclass(frozen=True)
class Channel:
    """One channel of a record: a signal, its message type, and the bytes of an empty message."""

    signal: Signal
    topic: str
    part: str
    """The field of the message that carries the signal (see `part`)."""
    message: bytes
    """The serialised message (CDR, little endian) with every number zero."""
    stamp: int
    """Position of the header's time in `message` [bytes]; -1 without a header."""
    data: int
    """Position of the signal's first number in `message` [bytes]; every number is stored as a double, bits too."""

    @property
    def schema(self) -> str:
        """Name of the message type, e.g. ``geometry_msgs/msg/WrenchStamped``."""
        return TYPE_OF_PART[self.part]

    @property
    def order(self) -> list[int]:
        """Indices of the signal's elements in the message's order: a ROS quaternion is x y z w, a tick's w x y z."""
        return [1, 2, 3, 0] if self.part == "quaternion" else list(range(self.signal.size))


def channel_of(signal: Signal) -> Channel:
    """Lay out the channel of a signal."""
    kind = part(signal)
    body = bytearray()
    stamp = -1
    if kind != "data":
        stamp = len(_LITTLE_ENDIAN_CDR)
        body += bytes(8) + _string(signal.frame)
    if kind in ("position", "velocity", "effort"):
        body += bytes(-len(body) % 4) + struct.pack("<I", signal.size)
        for joint in range(signal.size):
            body += bytes(-len(body) % 4) + _string(f"q{joint + 1}")
        for array in ("position", "velocity", "effort"):
            body += bytes(-len(body) % 4)
            if array == kind:
                body += struct.pack("<I", signal.size)
                body += bytes(-len(body) % 8)
                data = len(body)
                body += bytes(8 * signal.size)
            else:
                body += bytes(4)
    else:
        body += bytes(-len(body) % 8)
        data = len(body)
        body += bytes(48 if kind == "force" else 8 * signal.size)
    message = _LITTLE_ENDIAN_CDR + bytes(body)
    return Channel(signal, topic(signal), kind, message, stamp, data + len(_LITTLE_ENDIAN_CDR))


def _string(text: str) -> bytes:
    data = text.encode() + b"\x00"
    return struct.pack("<I", len(data)) + data
