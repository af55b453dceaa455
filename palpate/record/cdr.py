"""Serialises ROS 2 messages of the kinds in a record that are not signals: little-endian CDR."""

from __future__ import annotations

import struct

import numpy as np

from palpate.base.arrays import Array

_HEAD = b"\x00\x01\x00\x00"


class Cdr:
    """The bytes of one message; numbers are aligned to their size, counted from after the four bytes of the head."""

    def __init__(self) -> None:
        self._body = bytearray()

    def __bytes__(self) -> bytes:
        return _HEAD + bytes(self._body)

    @property
    def end(self) -> int:
        """Position in the message after the last field [bytes]."""
        return len(_HEAD) + len(self._body)

    def number(self, kind: str, *values: float) -> Cdr:
        """Numbers of a kind of `struct`: i, I, d, f or B."""
        self._body += bytes(-len(self._body) % struct.calcsize(kind))
        self._body += struct.pack(f"<{len(values)}{kind}", *values)
        return self

    def text(self, value: str) -> Cdr:
        """A string."""
        data = value.encode() + b"\x00"
        self.number("I", len(data))
        self._body += data
        return self

    def points(self, p: Array) -> Cdr:
        """A sequence of `geometry_msgs/Point`: (n, 3)."""
        self.number("I", len(p))
        if len(p):
            self._body += bytes(-len(self._body) % 8)
            self._body += np.ascontiguousarray(p, "<f8").tobytes()
        return self

    def pose(self, p: Array, quat: Array) -> Cdr:
        """A position (3,) and an orientation (4,) w x y z, as `geometry_msgs/Pose` and `Transform`."""
        w, x, y, z = (float(value) for value in quat)
        return self.number("d", *map(float, p)).number("d", x, y, z, w)
