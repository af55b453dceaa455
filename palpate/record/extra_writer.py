"""Writes frames and meshes into a record, in chunks of their own beside those of the signals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from palpate.record.extra import RATE, TF, Extra, TransformTemplate
from palpate.record.mcap_file import McapFile
from palpate.record.messages import DEFINITIONS
from palpate.record.snapshots import Snapshot
from palpate.record.ticks import Ticks


class ExtraWriter:
    """The channels of an `Extra` after those of the signals.

    Args:
        extra: what to write.
        before: number of channels of the signals.
    """

    def __init__(self, extra: Extra, before: int) -> None:
        topics = {"/tf": TF, **extra.topics}
        self.channels = {before + k: entry for k, entry in enumerate(topics.items(), start=1)}
        """Topic and message type by channel id."""
        self._extra, self._number = extra, {topic: i for i, (topic, _) in self.channels.items()}
        self._template: TransformTemplate | None = None
        self._due = -np.inf
        self._snapshots: list[Snapshot] = []

    def begin(self, file: McapFile, schemas: dict[str, int]) -> None:
        """Register the channels; schemas: ids of the message types that the file has."""
        for topic, schema in self.channels.values():
            if schema not in schemas:
                schemas[schema] = file.add_schema(schema, "ros2msg", DEFINITIONS[schema])
            file.add_channel(topic, schemas[schema], "cdr", {"offered_qos_profiles": ""})

    def keep(self, snapshots: Sequence[Snapshot]) -> None:
        """Keep snapshots, in order of time, until the ticks up to theirs are written; unknown topics are left out."""
        self._snapshots += [one for one in snapshots if one.topic in self._number]

    def add(self, file: McapFile, ticks: Ticks, log_time: NDArray[np.uint64]) -> None:
        """Write the frames of some of the ticks (n,), the snapshots up to them, and at first what does not change."""
        messages = []
        if self._template is None:
            messages = [(self._number[topic], int(log_time[0]), data) for topic, data in self._extra.first()]
        for tick, time in zip(ticks, log_time.tolist(), strict=True):
            if float(tick["t"]) < self._due:
                continue
            self._due = max(self._due + 1.0 / RATE, float(tick["t"]))
            found = self._extra.transforms(tick)
            if self._template is None:
                self._template = TransformTemplate(tuple(found))
            poses = np.array(list(found.values())).reshape(-1, 4, 4)
            messages.append((self._number["/tf"], time, self._template.message(poses, time)))
        due = sum(one.t <= float(ticks["t"][-1]) for one in self._snapshots)
        for one in self._snapshots[:due]:
            messages.append((self._number[one.topic], max(round(1e9 * one.t), int(log_time[0])), one.data))
        del self._snapshots[:due]
        messages.sort(key=lambda message: message[1])
        if messages:
            file.add_messages(messages)
