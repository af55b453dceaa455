"""Writes the signals that one topic of a record carries, in the layout that the run needs so far."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from palpate.record.layout import CDR, HEAD, Layout, type_name, whole
from palpate.record.mcap_file import MESSAGE_HEAD, Block, McapFile, strided
from palpate.record.ticks import SIGNALS, Signal

Bits = NDArray[np.uint64]
"""Numbers of ticks as their bits, which compare also NaN: (n, TICK_DOUBLES)."""
_LATEST = 2.0**31 - 1  # a ROS time has 32 bits of seconds


class GroupWriter:
    """The topics of one group: the signals that move, and all of them whenever another one begins to move.

    Args:
        name: of the group, which is that of its topic.
        signals: of the group; the first one is always in the messages.
    """

    def __init__(self, name: str, signals: Sequence[Signal]) -> None:
        self.name, self.signals = name, list(signals)
        self._whole = whole(self.signals)
        self._counts = dict.fromkeys(self.signals, 0)
        self._counts[self.signals[0]] = self.signals[0].size
        self._element = {s.offset // 8 + k: (s, k) for s in self.signals for k in range(s.size)}
        self._still = np.array(list(self._element), dtype=np.intp)  # positions in a tick that no message carries
        self._layouts, self._all = 0, 0
        self._encoder: Encoder | None = None

    def begin(self, file: McapFile) -> None:
        """Register the channel of the messages with every signal."""
        self._all = self._channel(file, self._whole, None)

    def add(
        self, file: McapFile, bits: Bits, moved: NDArray[np.bool_], log_time: NDArray[np.uint64], first: int
    ) -> None:
        """Write ticks as a chunk.

        Args:
            file: where to.
            bits: of the numbers of each tick (n, TICK_DOUBLES).
            moved: True for each number that is not in all of them as in the first tick of the record (TICK_DOUBLES,).
            log_time: times of the ticks (n,) [ns].
            first: number of the first tick.
        """
        moved = moved[self._still]
        if self._encoder is None or moved.any():
            self._grow(moved)
            layout = Layout.of(self._counts)
            data = CDR + bits[0, self._whole.elements()].tobytes()
            self._layouts += 1
            self._encoder = Encoder(layout, self._channel(file, layout, self._layouts))
            file.add_messages([(self._all, int(log_time[0]), data)])
            inside = {SIGNALS[f.name].offset // 8 + k for f in layout.fields for k in range(f.count)}
            self._still = np.array([e for e in self._element if e not in inside], dtype=np.intp)
        file.add_chunk(self._encoder.encode(bits, log_time, first))

    def _grow(self, moved: NDArray[np.bool_]) -> None:
        for place in self._still[moved].tolist():
            signal, element = self._element[place]
            self._counts[signal] = max(self._counts[signal], element + 1)

    def _channel(self, file: McapFile, layout: Layout, number: int | None) -> int:
        definition = layout.definition({s.name: s for s in self.signals})
        schema = file.add_schema(type_name(self.name, number), "ros2msg", definition)
        topic = f"/{self.name}" + ("/all" if number is None else "")
        return file.add_channel(topic, schema, "cdr", {"offered_qos_profiles": ""})


class Encoder:
    """Serialises ticks in a layout: the numbers of each tick are gathered behind the head of its message."""

    def __init__(self, layout: Layout, channel: int) -> None:
        self.channel = channel
        self._elements = layout.elements()
        head = MESSAGE_HEAD.pack(Opcode.MESSAGE, MESSAGE_HEAD.size - 9 + layout.message_bytes, channel, 0, 0, 0) + CDR
        self._head = np.frombuffer(head, np.uint8)

    def encode(self, bits: Bits, log_time: NDArray[np.uint64], first: int) -> Block:
        """Serialise ticks, given as the bits of their numbers (n, TICK_DOUBLES)."""
        n = len(bits)
        data = np.empty((n, HEAD + 8 * len(self._elements)), np.uint8)
        data[:, :HEAD] = self._head
        strided(data, 11, "<u4")[:, 0] = np.arange(first, first + n, dtype=np.uint64).astype("<u4")
        strided(data, 15, "<u8", 2)[:] = log_time[:, None]
        data[:, HEAD:] = bits.take(self._elements, axis=1).view(np.uint8)
        return Block(data, log_time, {self.channel: 0})


def nanoseconds(t: NDArray[np.float64]) -> NDArray[np.uint64]:
    """Times [s] rounded to nanoseconds; NaN, infinity and negative values become zero."""
    seconds = np.clip(np.nan_to_num(t, nan=0.0, posinf=0.0, neginf=0.0), 0.0, _LATEST)
    return np.rint(seconds * 1e9).astype(np.uint64)
