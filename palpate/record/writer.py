"""Writes a run as an MCAP file for rosbag2, Foxglove and PlotJuggler; every signal is a field of a message."""

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

from palpate.base.arrays.yaml_loader import Dumper
from palpate.base.errors import OutputError
from palpate.record.extra import RATE, Extra
from palpate.record.extra_writer import ExtraWriter
from palpate.record.group_writer import GroupWriter, nanoseconds
from palpate.record.layout import kept, kind_of
from palpate.record.mcap_file import McapFile
from palpate.record.snapshots import Snapshot
from palpate.record.ticks import TICK_DOUBLES, as_rows, as_ticks

CHUNKS_PER_SECOND = 4
"""Chunks per second of a run in real time, which loses at most one chunk when it is killed."""
LOCKSTEP_CHUNKS_PER_SECOND = 2
"""Chunks per second of simulated time: a lockstep run is faster than real time, and half as many take less time."""


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
        linked: True keeps the signals of a remote site.
        bag: True writes the ``metadata.yaml`` of a rosbag2 into the folder, which then holds this record only.
        started: wall-clock time at t = 0 with its time zone; ignored in a lockstep record.
        every: record each tick whose number is a multiple of this.
        extra: frames and meshes that 3-D viewers of MCAP files show; None leaves them out.
        signals: names of the signals to keep, besides the time; None keeps all.

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
        linked: bool = True,
        extra: Extra | None = None,
        signals: Sequence[str] | None = None,
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
        self._groups = [
            GroupWriter(name, found) for name, found in kept(deterministic, tracked, paired, signals, linked).items()
        ]
        self._extra = None if extra is None else ExtraWriter(extra, round(RATE) if deterministic else 1)
        per_second = LOCKSTEP_CHUNKS_PER_SECOND if deterministic else CHUNKS_PER_SECOND
        self._chunk = max(1, round(rate / per_second))
        self._pending = np.empty((self._chunk, TICK_DOUBLES))  # the next chunk
        self._pending_count = 0
        self._flushed_at = time.monotonic()
        self._span_ns = (0, 0)
        self._first: NDArray[np.uint64] | None = None  # bits of the first tick
        try:
            self._file = McapFile(self.path)
        except OSError as error:
            raise OutputError(
                f"the record cannot be written: {error.strerror}",
                where=str(self.path),
                mend="choose a folder you may write to with --out",
            ) from error
        self._guard(lambda: self._begin(scene_yaml, seed, rate))

    @property
    def size(self) -> int:
        """Size of the file so far [bytes]."""
        return self.path.stat().st_size if self.path.exists() else 0

    def append(self, rows: NDArray[Any], snapshots: Sequence[Snapshot] = ()) -> None:
        """Record ticks: (n, TICK_DOUBLES) float64 or (n,) `TICK`, in order of time. Ignored after a failure.

        snapshots: of the same time or later; they are written with the ticks of their time.
        """
        if self.failure is not None or self.sha256 is not None or not len(rows):
            return
        if self._extra is not None:
            self._extra.keep(snapshots)
        numbers = as_rows(as_ticks(rows))  # copied as plain numbers: numpy handles records field by field
        taken = numbers[-self._seen % self._every :: self._every]
        self._seen += len(numbers)
        while len(taken) and self.failure is None:
            some = taken[: self._chunk - self._pending_count]
            self._pending[self._pending_count : self._pending_count + len(some)] = some
            self._pending_count += len(some)
            taken = taken[len(some) :]
            if self._pending_count == self._chunk:
                self._guard(self._flush)
        if not self._deterministic and time.monotonic() - self._flushed_at > 1.0 / CHUNKS_PER_SECOND:
            self._guard(self._flush)

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
        table = [asdict(s) | {"channel": f"/{g.name}", "type": kind_of(s)} for g in self._groups for s in g.signals]
        self._file.add_attachment("signals.json", "application/json", json.dumps(table, indent=1))
        for group in self._groups:
            group.begin(self._file)
        if self._extra is not None:
            self._extra.begin(self._file)

    def _flush(self) -> None:
        """Write the ticks that wait as a chunk."""
        self._flushed_at, count = time.monotonic(), self._pending_count
        if not count:
            return
        chunk, bits = as_ticks(self._pending[:count]), self._pending[:count].view(np.uint64)
        log_time = nanoseconds(chunk["t"])
        self._first = bits[0].copy() if self._first is None else self._first
        moved = (bits != self._first).any(axis=0)
        for group in self._groups:
            group.add(self._file, bits, moved, log_time, self.ticks_written)
        if self._extra is not None:
            self._extra.add(self._file, chunk, log_time)
        first = int(log_time[0]) if self.ticks_written == 0 else self._span_ns[0]
        self._span_ns = (first, int(log_time[-1]))
        self.ticks_written += count
        self._pending_count = 0

    def _end(self, outcome: dict[str, str]) -> None:
        self._flush()
        if self._extra is not None:
            self._extra.finish(self._file)
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
        counted = [
            {
                "topic_metadata": {
                    "name": topic,
                    "type": schema,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [],
                    "type_description_hash": "",
                },
                "message_count": count,
            }
            for topic, schema, count in self._file.topics()
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
            self._pending_count = 0
            self._file.abandon()
