"""Writes a run as an MCAP file for rosbag2, Foxglove and PlotJuggler; every signal is a channel."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from palpate.arrays.yaml_loader import Dumper
from palpate.errors import OutputError
from palpate.record.channels import Channel, channels
from palpate.record.extra import Extra
from palpate.record.extra_writer import ExtraWriter
from palpate.record.mcap_file import MESSAGE_HEAD, Block, McapFile
from palpate.record.snapshots import Snapshot
from palpate.record.ticks import TICK, Ticks, as_ticks

CHUNKS_PER_SECOND = 4
"""Chunks per second of run time; a killed run loses at most one chunk."""

_LATEST = 2.0**31 - 1  # a ROS time has 32 bits of seconds


class Recorder:
    """Record a run into one MCAP file.

    A lockstep record depends on scene and seed only: it holds no wall-clock time, host name or computation time, so the
    same run gives the same bytes. A failed write (disk full) ends the recording but not the run: see `failure`.

    Args:
        path: file to create; its folder must exist.
        scene_yaml: the resolved scene, stored as attachment ``scene.yaml``.
        seed: seed of the run.
        rate: ticks per second of run time [Hz].
        deterministic: True for a lockstep record, which leaves out signals that depend on the machine.
        tracked: False leaves out the signals of live objects and tracked frames, for a scene without trackers.
        paired: True keeps the signals of contact with other pairs.
        bag: True writes the ``metadata.yaml`` of a rosbag2 into the folder, which then holds this record only.
        started: wall-clock time at t = 0 with its time zone; ignored in a lockstep record.
        every: record each tick whose number is a multiple of this.
        extra: frames and meshes that 3-D viewers of MCAP files show; None leaves them out.

    Raises:
        OutputError: the file cannot be created.
    """

    def __init__(
        self,
        path: str | Path,
        scene_yaml: str,
        seed: int,
        rate: float,
        deterministic: bool,
        bag: bool = False,
        started: datetime | None = None,
        every: int = 1,
        tracked: bool = True,
        paired: bool = True,
        extra: Extra | None = None,
    ) -> None:
        self.path = Path(path)
        self._bag, self._every, self._seen = bag, every, 0
        self._started = None if deterministic else started
        rate = rate / every
        self.failure: str | None = None
        """Reason for which recording stopped early; None without failure."""
        self.sha256: str | None = None
        """SHA-256 of the finished file (hexadecimal); None before `close` and after a failure."""
        self.ticks_written = 0
        """Number of ticks written to the file."""
        self._deterministic = deterministic
        self._channels = channels(deterministic, tracked, paired)
        self._encoder = TickEncoder(self._channels)
        self._extra = None if extra is None else ExtraWriter(extra, len(self._channels))
        self._chunk = max(1, round(rate / CHUNKS_PER_SECOND))
        self._pending: list[Ticks] = []
        self._pending_count = 0
        self._flushed_at = time.monotonic()
        self._span_ns = (0, 0)
        try:
            self._file = McapFile(self.path)
        except OSError as error:
            raise OutputError(
                f"the record cannot be written: {error.strerror}",
                where=str(self.path),
                mend="choose a folder you may write to with --out",
            ) from error
        self._guard(lambda: self._begin(scene_yaml, seed, rate))

    def append(self, rows: NDArray[Any], snapshots: Sequence[Snapshot] = ()) -> None:
        """Record ticks: (n, TICK_DOUBLES) float64 or (n,) `TICK`, in order of time. Ignored after a failure.

        snapshots: of the same time or later; they are written with the ticks of their time.
        """
        if self.failure is not None or self.sha256 is not None or not len(rows):
            return
        if self._extra is not None:
            self._extra.keep(snapshots)
        ticks = as_ticks(rows)
        kept = ticks[-self._seen % self._every :: self._every].copy()
        self._seen += len(ticks)
        self._pending.append(kept)
        self._pending_count += len(kept)
        late = not self._deterministic and time.monotonic() - self._flushed_at > 1.0 / CHUNKS_PER_SECOND
        if self._pending_count >= self._chunk or late:
            self._guard(lambda: self._flush(everything=late))

    def close(self, faults: Sequence[str] = (), timing: Mapping[str, Any] | None = None) -> None:
        """Write the pending ticks and the summary.

        Args:
            faults: faults of the run, in words.
            timing: `Simulation.timing()` of a real-time run; ignored in a lockstep record.
        """
        if self.failure is not None or self.sha256 is not None:
            return
        outcome = {"faults": json.dumps(list(faults))}
        if timing is not None and not self._deterministic:
            outcome["timing"] = json.dumps(dict(timing))
        self._guard(lambda: self._end(outcome))

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _begin(self, scene_yaml: str, seed: int, rate: float) -> None:
        from palpate import __version__

        self._file.begin(profile="ros2", library=f"palpate {__version__}")
        run = {"version": __version__, "seed": str(seed), "rate_Hz": repr(float(rate))}
        self._file.add_metadata("palpate", run | {"deterministic": json.dumps(self._deterministic)})
        self._file.add_attachment("scene.yaml", "application/yaml", scene_yaml)
        if self._started is not None:
            zone = self._started.tzname() or ""
            self._file.add_metadata("clock", {"started": self._started.isoformat(), "time_zone": zone})
        table = [asdict(c.signal) | {"channel": c.topic, "type": c.schema} for c in self._channels]
        self._file.add_attachment("signals.json", "application/json", json.dumps(table, indent=1))
        schemas: dict[str, int] = {}
        for channel in self._channels:
            if channel.schema not in schemas:
                schemas[channel.schema] = self._file.add_schema(channel.schema, "ros2msg", channel.definition)
            self._file.add_channel(channel.topic, schemas[channel.schema], "cdr", channel.metadata)
        if self._extra is not None:
            self._extra.begin(self._file, schemas)

    def _flush(self, *, everything: bool) -> None:
        ticks = np.concatenate(self._pending) if self._pending else np.empty(0, TICK)
        whole = len(ticks) if everything else len(ticks) - len(ticks) % self._chunk
        for start in range(0, whole, self._chunk):
            chunk = ticks[start : min(start + self._chunk, whole)]
            block = self._encoder.encode(chunk, self.ticks_written)
            self._file.add_chunk(block)
            if self._extra is not None:
                self._extra.add(self._file, chunk, block.log_time)
            first = int(block.log_time[0]) if self.ticks_written == 0 else self._span_ns[0]
            self._span_ns = (first, int(block.log_time[-1]))
            self.ticks_written += len(block.data)
        self._pending = [ticks[whole:]] if whole < len(ticks) else []
        self._pending_count = len(ticks) - whole
        self._flushed_at = time.monotonic()

    def _end(self, outcome: dict[str, str]) -> None:
        self._flush(everything=True)
        self._file.add_metadata("outcome", outcome)
        self._file.add_metadata("rosbag2", {"serialized_metadata": self._rosbag2()})
        self.sha256 = self._file.finish()
        if self._bag:
            self._write_bag_metadata()

    def _write_bag_metadata(self) -> None:
        """Write ``metadata.yaml`` into the folder, so that `ros2 bag` accepts the folder."""
        data = {"rosbag2_bagfile_information": json.loads(self._rosbag2())}
        text = yaml.dump(data, sort_keys=False, Dumper=Dumper)
        self.path.with_name("metadata.yaml").write_text(text, encoding="utf-8")

    def _rosbag2(self) -> str:
        """The metadata that rosbag2's recorder would write, as JSON (which is valid YAML)."""
        start, end = self._span_ns
        others = {} if self._extra is None else self._extra.channels
        topics = {i: (c.topic, c.schema) for i, c in enumerate(self._channels, start=1)} | others
        counted = [
            {
                "topic_metadata": {
                    "name": topic,
                    "type": schema,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [],
                    "type_description_hash": "",
                },
                "message_count": self._file.counts.get(i, 0),
            }
            for i, (topic, schema) in topics.items()
        ]
        information = {
            "version": 9,
            "storage_identifier": "mcap",
            "duration": {"nanoseconds": end - start},
            "starting_time": {"nanoseconds_since_epoch": start},
            "message_count": sum(self._file.counts.values()),
            "topics_with_message_count": counted,
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self.path.name],
            "files": [],
            "custom_data": None,
            "ros_distro": "",
        }
        return json.dumps(information)

    def _guard(self, write: Any) -> None:
        """Call `write`; a failure ends the recording but not the run."""
        try:
            write()
        except OSError as error:
            reason = error.strerror or str(error)
            self.failure = f"recording stopped after {self.ticks_written} ticks: {reason} ({self.path})"
            self._pending, self._pending_count = [], 0
            self._file.abandon()


class TickEncoder:
    """Serialises ticks: copies a template of one tick's messages n times, then each signal by a strided copy."""

    def __init__(self, layout: Sequence[Channel]) -> None:
        self.layout = layout
        self.offsets: dict[int, int] = {}
        """Channel id (from 1) -> position of its message in a tick [bytes]."""
        template = bytearray()
        for i, channel in enumerate(layout, start=1):
            self.offsets[i] = len(template)
            template += channel.record(i)
        self.tick_bytes = len(template)
        """Length of the messages of one tick [bytes]."""
        self._template = np.frombuffer(bytes(template), np.uint8)

    def encode(self, ticks: Ticks, first: int) -> Block:
        """Serialise (n,) ticks; `first` is the sequence number of the first tick."""
        n = len(ticks)
        data = np.empty((n, self.tick_bytes), np.uint8)
        data[:] = self._template
        log_time = nanoseconds(ticks["t"])
        sequence = np.arange(first, first + n, dtype=np.uint64).astype("<u4")
        seconds, rest = (log_time // 10**9).astype("<i4"), (log_time % 10**9).astype("<u4")
        for start, channel in zip(self.offsets.values(), self.layout, strict=True):
            column(data, start + 11, "<u4")[:, 0] = sequence
            column(data, start + 15, "<u8", 2)[:] = log_time[:, None]
            message = start + MESSAGE_HEAD.size
            if channel.stamp >= 0:
                column(data, message + channel.stamp, "<i4")[:, 0] = seconds
                column(data, message + channel.stamp + 4, "<u4")[:, 0] = rest
            values = ticks[channel.signal.name].reshape(n, -1)
            column(data, message + channel.data, "<f8", channel.signal.size)[:] = values[:, channel.order]
        return Block(data, log_time, self.offsets)


def nanoseconds(t: NDArray[np.float64]) -> NDArray[np.uint64]:
    """Times [s] rounded to nanoseconds; NaN, infinity and negative values become zero."""
    seconds = np.clip(np.nan_to_num(t, nan=0.0, posinf=0.0, neginf=0.0), 0.0, _LATEST)
    return np.rint(seconds * 1e9).astype(np.uint64)


def column(data: NDArray[np.uint8], offset: int, kind: str, count: int = 1) -> NDArray[Any]:
    """A view of `count` numbers of type `kind` at byte `offset` of each row: (n, count)."""
    dtype = np.dtype(kind)
    return np.ndarray((len(data), count), dtype, data, offset, (data.strides[0], dtype.itemsize))
