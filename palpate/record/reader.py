"""Reads a record: what it holds, and its ticks, of which only those that are asked for are unpacked."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from palpate.base.errors import RecordError
from palpate.record.mcap_scan import Index, damaged, scan
from palpate.record.pieces import Group, groups_of
from palpate.record.snapshots import CAMERA, SHAPES, BodyTrack, Track
from palpate.record.ticks import TICK, TICK_BYTES, Signal, Ticks, Timing
from palpate.record.tracks import bodies_of, track_of

if TYPE_CHECKING:
    import pandas as pd

BLOCK = 1000
"""Ticks of a block of `Record.blocks`, about."""


class Record:
    """A run read back from its file: ``Record.open(path)["F_H_L"]`` is the force on the hand, (n, 3).

    Only what is asked for is read: `read` and `frame` take some signals of some ticks, `blocks` walks through a record
    of any length in constant memory, and `ticks` loads all signals of all ticks (3.5 kB each).
    """

    def __init__(self, index: Index, groups: list[Group]) -> None:
        self.path: Path = index.path
        self.scene = index.attachments.get("scene.yaml", b"").decode(errors="replace")
        """The resolved scene at the start of the run (YAML); empty if the file lacks it."""
        self.signals: dict[str, Signal] = {name: one for group in groups for name, one in group.signals.items()}
        """The recorded signals by name, with unit, frame and meaning; also those that this version does not know."""
        order = {name: k for k, name in enumerate(TICK.names or ())}
        self.signals = dict(sorted(self.signals.items(), key=lambda one: order.get(one[0], len(order))))
        self.complete = index.complete
        """False if the run was killed or the disk was full; the ticks then end with the last complete chunk."""
        self.metadata = index.metadata
        """Every metadata table of the file, by name."""
        self._index, self._groups = index, groups
        self._group = {name: group for group in groups for name in group.signals}
        self._count = min((group.count for group in groups), default=0)

    @classmethod
    def open(cls, path: str | Path) -> Record:
        """Open a record. Signals that it does not hold read as NaN.

        Raises:
            RecordError: the file is missing, empty, not MCAP, not a record of Palpate, damaged, or without ticks.
        """
        path = Path(path)
        index = scan(path)
        record = cls(index, groups_of(index, _described(index)))
        record._require_ticks()
        try:
            _ = record.rate, record.seed, record.faults, record.timing, record.started
        except (ValueError, TypeError) as error:
            raise damaged(path, error) from error
        return record

    def __len__(self) -> int:
        """Number of ticks."""
        return self._count

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A signal at every tick: (n,), or (n, size) for a signal of several numbers.

        Raises:
            KeyError: neither the record nor this version has the signal.
        """
        return np.ascontiguousarray(self.read([name])[name])

    def read(
        self, signals: Sequence[str] | None = None, start: int = 0, stop: int | None = None, every: int = 1
    ) -> Ticks:
        """Some signals of some ticks, bit for bit as recorded.

        Args:
            signals: names; all of `TICK` when left out. A signal that the record does not hold is NaN.
            start: number of the first tick.
            stop: number of the tick after the last.
            every: keep each tick whose number, counted from `start`, is a multiple of this.

        Returns:
            A structured array (n,) with a field for each signal.
        """
        start, stop, _ = slice(start, stop).indices(self._count)
        if every <= 1:
            return self._filled(signals, start, stop)
        parts = [
            self._filled(signals, a, min(a + span, stop))[::every]
            for span in [max(1, BLOCK // every) * every] for a in range(start, stop, span)
        ]  # fmt: skip
        return np.concatenate(parts) if parts else self._filled(signals, start, start)

    def remember(self, seconds: float) -> None:
        """Keep about so much of the run unpacked, for a reader that returns to the same ticks."""
        for group in self._groups:
            group.kept = 2 + round(seconds * self.rate * len(group.pieces) / self._count)

    def blocks(self, signals: Sequence[str] | None = None) -> Iterator[Ticks]:
        """All ticks, about a thousand at a time: arrays as of `read`, whose memory is used again for the next block."""
        found = self._blank(signals, 2 * BLOCK)
        for start, stop in self._spans():
            if stop - start > len(found):
                found = self._blank(signals, stop - start)
            yield self._fill(found[: stop - start], start)

    def frame(
        self,
        columns: Sequence[str] | None = None,
        start: float | None = None,
        stop: float | None = None,
        every: int = 1,
    ) -> pd.DataFrame:
        """A table with one row per tick: the time as index, and columns such as ``F_T_W.x [N]``.

        ``attrs["started"]`` is `started`.

        Args:
            columns: names of signals; all that were recorded when left out.
            start: first time [s].
            stop: time before which the table ends [s].
            every: keep each n-th tick.

        Raises:
            KeyError: the record does not have a signal. MissingExtraError: pandas is not installed.
        """
        from palpate.record.frame import to_pandas

        names = list(self.signals if columns is None else columns)
        unknown = [name for name in names if name not in self.signals]
        if unknown:
            raise KeyError(f"{', '.join(unknown)} not recorded; recorded are {', '.join(self.signals)}")
        first, last = 0, self._count
        if start is not None or stop is not None:
            t = self["t"]
            first = 0 if start is None else int(np.searchsorted(t, start))
            last = len(t) if stop is None else int(np.searchsorted(t, stop))
        ticks = self.read(list(dict.fromkeys(["t", *names])), first, max(first, last), every)
        table = to_pandas(ticks, {name: self.signals[name] for name in names})
        table.attrs["started"] = self.started
        return table

    def to_pandas(self) -> pd.DataFrame:
        """The table of `frame` with every recorded signal at every tick."""
        return self.frame()

    @cached_property
    def ticks(self) -> Ticks:
        """All signals of all ticks, (n,) of `TICK`, kept in memory: for records of minutes."""
        return self.read()

    def snapshots(self, topic: str) -> Track | None:
        """Shape of a soft object or joints of the camera over time (`palpate.record.snapshots`).

        None if the file does not hold the topic, or another tool has rewritten it in another layout.
        """
        return track_of(self._index, topic)

    @cached_property
    def bodies(self) -> BodyTrack | None:
        """Poses of the rigid bodies over time; None if the file does not hold them, as for `snapshots`."""
        return bodies_of(self._index)

    @cached_property
    def snapshot_topics(self) -> list[str]:
        """Topics that `snapshots` reads."""
        found = [one.topic for one in self._index.channels.values()]
        return [topic for topic in found if topic == CAMERA or topic.startswith(SHAPES)]

    @cached_property
    def span(self) -> tuple[float, float]:
        """Time of the first and of the last tick [s]."""
        ends = [self.read(["t"], k, k + 1)["t"][0] for k in (0, self._count - 1)]
        return float(ends[0]), float(ends[1])

    @property
    def duration(self) -> float:
        """Time from the first tick to the end of the last tick [s]."""
        return self.span[1] - self.span[0] + 1.0 / self.rate

    @cached_property
    def rate(self) -> float:
        """Ticks per second [Hz]."""
        stored = self._run.get("rate_Hz")
        if stored is not None:
            return float(stored)
        steps = np.diff(self.read(["t"], 0, 10_000)["t"])
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
        stored = self._run.get("deterministic")
        return not any(not s.deterministic for s in self.signals.values()) if stored is None else stored == "true"

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

    @property
    def note(self) -> str | None:
        """A message for the user about an incomplete file; None for a complete file."""
        if self.complete:
            return None
        return (
            f"{self.path}: the file has no end (run killed, or disk full): "
            f"read the {self.duration:.2f} s ({self._count} ticks) that were written"
        )

    @property
    def _run(self) -> dict[str, str]:
        return self.metadata.get("palpate", {})

    def _filled(self, signals: Sequence[str] | None, start: int, stop: int) -> Ticks:
        return self._fill(self._blank(signals, max(0, stop - start)), start)

    def _blank(self, signals: Sequence[str] | None, n: int) -> Ticks:
        """Ticks (n,) in which every signal is NaN, and bits are zero."""
        if signals is None:
            ticks: Ticks = np.full((n, TICK_BYTES // 8), np.nan).view(TICK).reshape(n)
            names: Sequence[str] = TICK.names or ()
        else:
            known = [self._signal(name) for name in signals]
            ticks = np.empty(n, np.dtype([(s.name, s.format, (s.size,) if s.size > 1 else ()) for s in known]))
            names = signals
        for name in names:
            ticks[name] = 0 if ticks.dtype[name].base.kind == "u" else np.nan
        return ticks

    def _signal(self, name: str) -> Signal:
        from palpate.record.ticks import SIGNALS

        found = self.signals.get(name) or SIGNALS.get(name)
        if found is None:
            raise KeyError(f"no signal {name!r}; recorded are {', '.join(self.signals)}")
        return found

    def _fill(self, ticks: Ticks, start: int) -> Ticks:
        for group in self._groups:
            names = [name for name in ticks.dtype.names or () if name in group.signals]
            if names:
                group.fill(ticks, names, start)
        return ticks

    def _spans(self) -> Iterator[tuple[int, int]]:
        """First tick, and the one after the last, of each block: whole pieces, so that each is unpacked once."""
        start = 0
        for piece in max(self._groups, key=lambda group: len(group.pieces)).pieces:
            stop = min(piece.start + piece.length, self._count)
            while stop - start > 2 * BLOCK:
                yield start, start + BLOCK
                start += BLOCK
            if stop - start >= BLOCK:
                yield start, stop
                start = stop
        if start < self._count:
            yield start, self._count

    def _require_ticks(self) -> None:
        path = str(self.path)
        if self._groups and "t" in self.signals and self._count:
            return
        if not self._groups and not self._index.complete and not self._index.chunks and "palpate" in self.metadata:
            raise RecordError(
                "the record ends before its first tick", where=path, why="the file is cut short", mend="run again"
            )
        if "palpate" in self.metadata or (self._groups and "t" in self.signals):
            raise RecordError(
                "the record has no ticks",
                where=path,
                why="the run ended before its first quarter of a second was written",
                mend="run again, longer",
            )
        topics = sorted(channel.topic for channel in self._index.channels.values())
        raise RecordError(
            "not a record of Palpate: it has no /loop with the time t",
            where=path,
            why=f"made by other software; its channels: {', '.join(topics[:4]) or 'none'}",
            mend="give a record.mcap that `palpate run` wrote",
        )


def _described(index: Index) -> dict[str, Signal]:
    """The signals as the file describes them, by name; empty if it does not."""
    try:
        rows = json.loads(index.attachments.get("signals.json", b"[]"))
        return {
            row["name"]: Signal(
                str(row["name"]), -1, int(row["size"]), str(row["unit"]), str(row["frame"]), str(row["doc"]),
                bool(row["deterministic"]), str(row["stage"]),
            ) for row in rows
        }  # fmt: skip
    except (ValueError, TypeError, KeyError, AttributeError):
        return {}
