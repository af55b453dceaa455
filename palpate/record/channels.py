"""The ROS 2 message that carries each signal, and its byte layout in the file.

Every message of a channel has the same length, because names and frames are constant. A tick is therefore a fixed
block of bytes, and a thousand ticks are written with one strided copy per signal.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from palpate.record.mcap_file import MESSAGE_HEAD
from palpate.record.messages import DEFINITIONS, TYPE_OF_PART
from palpate.record.ticks import SIGNALS, Signal

_OPCODE = 0x05
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
    def definition(self) -> str:
        """Definition text of the message type and its nested types."""
        return DEFINITIONS[self.schema]

    @property
    def order(self) -> list[int]:
        """Indices of the signal's elements in the message's order: a ROS quaternion is x y z w, a tick's w x y z."""
        return [1, 2, 3, 0] if self.part == "quaternion" else list(range(self.signal.size))

    @property
    def metadata(self) -> dict[str, str]:
        """Unit, frame and meaning of the signal, for readers other than Palpate."""
        s = self.signal
        return {
            "signal": s.name,
            "unit": s.unit,
            "frame": s.frame,
            "meaning": s.doc,
            "size": str(s.size),
            "part": self.part,
            "offered_qos_profiles": "",
        }

    def record(self, channel_id: int) -> bytes:
        """The MCAP message record with every number zero."""
        length = MESSAGE_HEAD.size - 9 + len(self.message)
        return MESSAGE_HEAD.pack(_OPCODE, length, channel_id, 0, 0, 0) + self.message


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


TRACKING = "tracking"
"""Stage of the signals that only a record of a scene with trackers holds."""


PAIRS = "pairs"
"""Stage of the signals that only a record of a scene with several pairs holds."""
OPTIONAL = (TRACKING, PAIRS)
"""Stages without which a record is complete."""


def channels(deterministic: bool, tracked: bool = True, paired: bool = True) -> list[Channel]:
    """The channels of a record, in the order of the tick.

    Args:
        deterministic: True leaves out signals that depend on the machine, as in a lockstep record.
        tracked: False leaves out the signals of live objects and tracked frames.
        paired: False leaves out the signals of contact with other pairs.
    """
    kept = [s for s in SIGNALS.values() if s.deterministic or not deterministic]
    left_out = {stage for stage, is_kept in ((TRACKING, tracked), (PAIRS, paired)) if not is_kept}
    return [channel_of(s) for s in kept if s.stage not in left_out]


def _string(text: str) -> bytes:
    data = text.encode() + b"\x00"
    return struct.pack("<I", len(data)) + data
