"""Reads a record: the ticks of the run, its scene, its faults, and whether the file is complete."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from mcap import records
from mcap.opcode import Opcode

from palpate.errors import RecordError
from palpate.record.channels import OPTIONAL, Channel, channels
from palpate.record.mcap_file import MESSAGE_HEAD
from palpate.record.mcap_scan import Scan, chunk_data, damaged, scan
from palpate.record.snapshots import CAMERA, QUANTUM, SHAPE, SHAPES, Track, joints_of, shape_of
from palpate.record.ticks import TICK, TICK_BYTES, Signal, Ticks, Timing
from palpate.record.writer import TickEncoder, column

if TYPE_CHECKING:
    import pandas as pd

Numbered = dict[int, Channel]
"""Channel id in the file -> layout of the channel."""

_TOPICS = frozenset(channel.topic for channel in channels(deterministic=False))


@dataclass(frozen=True)
class Record:
    """A run read back from its file."""

    path: Path
    ticks: Ticks = field(repr=False)
    """(n,) of `TICK`, bit for bit as recorded. Signals that were not recorded are NaN (see `signals`)."""
    scene: str = field(repr=False)
    """The resolved scene at the start of the run (YAML); empty if the file lacks it."""
    signals: dict[str, Signal] = field(repr=False)
    """The recorded signals by name, with unit, frame and meaning."""
    complete: bool
    """False if the run was killed or the disk was full; `ticks` then ends with the last complete chunk."""
    metadata: dict[str, dict[str, str]] = field(repr=False)
    """Every metadata table of the file, by name."""

    @classmethod
    def open(cls, path: str | Path) -> Record:
        """Read a record.

        Raises:
            RecordError: the file is missing, empty, not MCAP, not a record of Palpate, damaged, or without ticks.
        """
        path = Path(path)
        content = scan(path)
        found = _match(content, path)
        ticks = _decode(content, found, path)
        if not len(ticks):
            raise RecordError(
                "the record has no ticks",
                where=str(path),
                why="the run ended before its first quarter of a second was written",
                mend="run again, longer",
            )
        signals = {c.signal.name: c.signal for c in found.values()}
        scene = content.attachments.get("scene.yaml", b"").decode(errors="replace")
        record = cls(path, ticks, scene, signals, content.complete, content.metadata)
        try:
            _ = record.rate, record.seed, record.faults, record.timing, record.started
        except (ValueError, TypeError) as error:
            raise damaged(path, error) from error
        return record

    def snapshots(self, topic: str) -> Track | None:
        """Shape of a soft object or joints of the camera over time (`palpate.record.snapshots`).

        None if the file does not hold the topic, or another tool has rewritten it in another layout.
        """
        content = scan(self.path)
        number = next((k for k, one in content.channels.items() if one.topic == topic), None)
        if number is None:
            return None
        read = shape_of if content.schemas.get(content.channels[number].schema_id) == SHAPE else joints_of
        signals = {k for k, one in content.channels.items() if one.topic in _TOPICS}
        content.chunks = [chunk for chunk in content.chunks if _first_channel(chunk, self.path) not in signals]
        found = [message for message in content.messages(self.path) if message.channel_id == number]
        try:
            values = [read(bytes(message.data)) for message in found]
        except ValueError:
            return None
        if not found or len({value.shape for value in values}) != 1:
            return None
        times = np.array([message.log_time for message in found]) / 1e9
        return Track(times, np.stack(values), QUANTUM if read is shape_of else 1.0)

    @cached_property
    def snapshot_topics(self) -> list[str]:
        """Topics that `snapshots` reads."""
        found = [one.topic for one in scan(self.path).channels.values()]
        return [topic for topic in found if topic == CAMERA or topic.startswith(SHAPES)]

    @property
    def duration(self) -> float:
        """Time from the first tick to the end of the last tick [s]."""
        return float(self.ticks["t"][-1] - self.ticks["t"][0]) + 1.0 / self.rate

    @property
    def rate(self) -> float:
        """Ticks per second [Hz]."""
        stored = self._run.get("rate_Hz")
        if stored is not None:
            return float(stored)
        steps = np.diff(self.ticks["t"])
        return float(1.0 / np.median(steps)) if len(steps) else 1000.0

    @property
    def seed(self) -> int | None:
        """Seed of the run; None if the file lacks it."""
        return int(self._run["seed"]) if "seed" in self._run else None

    @property
    def version(self) -> str:
        """Version of Palpate that recorded the run; empty if the file lacks it."""
        return self._run.get("version", "")

    @property
    def deterministic(self) -> bool:
        """True for a lockstep record, which has no signals that depend on the machine."""
        return not any(not s.deterministic for s in self.signals.values())

    @cached_property
    def faults(self) -> list[str]:
        """Faults of the run, in words."""
        return list(json.loads(self.metadata.get("outcome", {}).get("faults", "[]")))

    @cached_property
    def timing(self) -> Timing | None:
        """`Simulation.timing()` at the end of a real-time run; None in lockstep or if the run was killed."""
        stored = self.metadata.get("outcome", {}).get("timing")
        return None if stored is None else dict(json.loads(stored))

    @property
    def started(self) -> datetime | None:
        """Wall-clock time at t = 0 with its time zone, for a run in real time; None for a lockstep run."""
        stored = self.metadata.get("clock", {}).get("started")
        return None if stored is None else datetime.fromisoformat(stored)

    def to_pandas(self) -> pd.DataFrame:
        """A table with one row per tick: the time as index, and columns such as ``F_T_W.x [N]``.

        ``attrs["started"]`` is `started`.

        Raises:
            MissingExtraError: pandas is not installed.
        """
        from palpate.record.frame import to_pandas

        table = to_pandas(self.ticks, self.signals)
        table.attrs["started"] = self.started
        return table

    @property
    def note(self) -> str | None:
        """A message for the user about an incomplete file; None for a complete file."""
        if self.complete:
            return None
        return (
            f"{self.path}: the file has no end (run killed, or disk full): "
            f"read the {self.duration:.2f} s ({len(self.ticks)} ticks) that were written"
        )

    @property
    def _run(self) -> dict[str, str]:
        return self.metadata.get("palpate", {})


def _match(content: Scan, path: Path) -> Numbered:
    """Find the channel of every signal; raises RecordError if deterministic signals are missing."""
    by_topic = {c.topic: (number, c.schema_id) for number, c in content.channels.items()}
    found: Numbered = {}
    missing = []
    for layout in channels(deterministic=False):
        number, schema = by_topic.get(layout.topic, (None, 0))
        if number is not None and content.schemas.get(schema) == layout.schema:
            found[number] = layout
        elif layout.signal.deterministic and layout.signal.stage not in OPTIONAL:
            missing.append(layout.topic)
    if missing and not content.complete and not content.chunks:
        raise RecordError(
            "the record ends before its first tick", where=str(path), why="the file is cut short", mend="run again"
        )
    if missing:
        required = channels(deterministic=False, tracked=False, paired=False)
        version = content.metadata.get("palpate", {}).get("version")
        have = ", ".join(sorted(by_topic)[:4]) or "none"
        raise RecordError(
            f"not a record that this Palpate can read: {len(missing)} of {len(required)} channels are missing: "
            + ", ".join(missing[:6])
            + (", ..." if len(missing) > 6 else ""),
            where=str(path),
            why=f"recorded by palpate {version}" if version else f"made by other software; its channels: {have}",
            mend=f"read it with palpate {version}" if version else "give a record.mcap that `palpate run` wrote",
        )
    return found


def _decode(content: Scan, found: Numbered, path: Path) -> Ticks:
    """All ticks of the file."""
    numbers = sorted(found)
    if numbers == list(range(1, len(numbers) + 1)):
        encoder = TickEncoder([found[n] for n in numbers])
        blocks: list[Ticks] = []
        for chunk in content.chunks:
            if _first_channel(chunk, path) not in found:
                continue  # frames and meshes
            block = _decode_block(encoder, chunk, sum(len(b) for b in blocks), path)
            if block is None:
                break
            blocks.append(block)
        else:
            return np.concatenate(blocks) if blocks else np.empty(0, TICK)
    return _decode_messages(content, found, path)


def _first_channel(chunk: records.Chunk, path: Path) -> int:
    """Channel of the first message of a chunk; 0 if it begins with another record."""
    head = chunk_data(chunk, path)[: MESSAGE_HEAD.size]
    if len(head) < MESSAGE_HEAD.size or head[0] != Opcode.MESSAGE:
        return 0
    return int(MESSAGE_HEAD.unpack(head)[2])


def _decode_block(encoder: TickEncoder, chunk: records.Chunk, first: int, path: Path) -> Ticks | None:
    """The ticks of a chunk in the layout of `Recorder`; None for a chunk of another tool."""
    raw = np.frombuffer(chunk_data(chunk, path), np.uint8)
    if len(raw) % encoder.tick_bytes:
        return None
    data = raw.reshape(-1, encoder.tick_bytes)
    ticks = _blank(len(data))
    for channel, start in zip(encoder.layout, encoder.offsets.values(), strict=True):
        values = column(data, start + MESSAGE_HEAD.size + channel.data, "<f8", channel.signal.size)
        _set(ticks, channel, values)
    # Encoding the ticks again must reproduce the bytes: a cheap check that the layout is as assumed.
    return ticks if np.array_equal(encoder.encode(ticks, first).data, data) else None


def _decode_messages(content: Scan, found: Numbered, path: Path) -> Ticks:
    """The ticks of a record that another tool rewrote (mcap recover, ros2 bag convert): message by message."""
    bodies: dict[int, list[bytes]] = {number: [] for number in found}
    times: dict[int, list[int]] = {number: [] for number in found}
    for message in content.messages(path):
        if message.channel_id in bodies and len(message.data) == len(found[message.channel_id].message):
            bodies[message.channel_id].append(message.data)
            times[message.channel_id].append(message.log_time)
    n = min((len(b) for b in bodies.values()), default=0)
    reference = next(iter(times.values()), [])[:n]
    ticks = _blank(n)
    for number, channel in found.items():
        if times[number][:n] != reference:
            raise RecordError(
                f"channel {channel.topic} is out of step with the others",
                where=str(path),
                why="messages are missing in the middle of the record",
                mend="use the record as `palpate run` wrote it",
            )
        data = np.frombuffer(b"".join(bodies[number][:n]), np.uint8).reshape(n, len(channel.message))
        _set(ticks, channel, column(data, channel.data, "<f8", channel.signal.size))
    return ticks


def _blank(n: int) -> Ticks:
    return np.full((n, TICK_BYTES // 8), np.nan).view(TICK).reshape(n)


def _set(ticks: Ticks, channel: Channel, values: Any) -> None:
    target = ticks[channel.signal.name].reshape(len(ticks), -1)
    with np.errstate(invalid="ignore"):  # bits of a damaged record may be no whole number
        target[:, channel.order] = values
