"""Writes frames and meshes into a record, in chunks of their own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from palpate.record.extra import RATE, TF, Extra, TransformTemplate
from palpate.record.mcap_file import McapFile
from palpate.record.messages import DEFINITIONS
from palpate.record.snapshots import Snapshot
from palpate.record.ticks import Ticks, as_rows, as_ticks


class ExtraWriter:
    """The channels of an `Extra`.

    Args:
        extra: what to write.
        together: number of moments whose frames are computed at once: one takes as long as twenty.
    """

    def __init__(self, extra: Extra, together: int = 1) -> None:
        self._topics = {"/tf": TF, **extra.topics}
        self._extra, self._together = extra, together
        self._number: dict[str, int] = {}  # channel by topic
        self._template: TransformTemplate | None = None
        self._begun = False
        self._due = -np.inf
        self._waiting: list[Ticks] = []  # ticks whose frames are due
        self._times: list[NDArray[np.uint64]] = []  # and their times [ns]
        self._snapshots: list[Snapshot] = []

    def begin(self, file: McapFile) -> None:
        """Register the channels."""
        schemas: dict[str, int] = {}
        for topic, schema in self._topics.items():
            if schema not in schemas:
                schemas[schema] = file.add_schema(schema, "ros2msg", DEFINITIONS[schema])
            self._number[topic] = file.add_channel(topic, schemas[schema], "cdr", {"offered_qos_profiles": ""})

    def keep(self, snapshots: Sequence[Snapshot]) -> None:
        """Keep snapshots, in order of time, until the ticks up to theirs are written; unknown topics are left out."""
        self._snapshots += [one for one in snapshots if one.topic in self._topics]

    def add(self, file: McapFile, ticks: Ticks, log_time: NDArray[np.uint64]) -> None:
        """Write the frames of some of the ticks (n,), the snapshots up to them, and at first what does not change."""
        messages = []
        if not self._begun:
            messages = [(self._number[topic], int(log_time[0]), data) for topic, data in self._extra.first()]
            self._begun = True
        self._wait(ticks, log_time)
        if sum(map(len, self._waiting)) >= self._together:
            messages += self._frames()
        due = sum(one.t <= float(ticks["t"][-1]) for one in self._snapshots)
        for one in self._snapshots[:due]:
            messages.append((self._number[one.topic], max(round(1e9 * one.t), int(log_time[0])), one.data))
        del self._snapshots[:due]
        messages.sort(key=lambda message: message[1])
        if messages:
            file.add_messages(messages)

    def finish(self, file: McapFile) -> None:
        """Write the frames that wait."""
        if self._waiting:
            file.add_messages(self._frames())

    def _wait(self, ticks: Ticks, log_time: NDArray[np.uint64]) -> None:
        """Keep the ticks at which frames are due."""
        due = []
        for k, t in enumerate(ticks["t"].tolist()):
            if t >= self._due:
                due.append(k)
                self._due = max(self._due + 1.0 / RATE, t)
        if due:
            self._waiting.append(ticks[due])
            self._times.append(log_time[due])

    def _frames(self) -> list[tuple[int, int, bytes]]:
        """The messages of /tf at the ticks that wait."""
        ticks, times = as_ticks(np.concatenate(list(map(as_rows, self._waiting)))), np.concatenate(self._times)
        self._waiting, self._times = [], []
        found = self._extra.transforms(ticks)
        if self._template is None:
            self._template = TransformTemplate(tuple(found))
        data = self._template.messages(np.stack(list(found.values()), axis=1), times)
        return [(self._number["/tf"], time, message) for time, message in zip(times.tolist(), data, strict=True)]
