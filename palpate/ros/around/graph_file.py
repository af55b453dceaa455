"""Keeps beside the record who published and who listened: a bag holds messages, and not from whom they came."""

from __future__ import annotations

import json
import time
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

NAME = "graph.jsonl"
"""File in the folder of a run: one line for each change of the graph."""
PERIOD = 2.0
"""Interval at which the graph is looked at [s]."""
_HIDDEN = ("/rosout", "/parameter_events")


class _Recorded(Protocol):
    record: Path | None


class GraphFile:
    """Writes a line `{"t": s since 1970, "topics": {NAME: {"type", "publishers", "subscribers"}}}` at each change.

    Args:
        node: a node of rclpy.
        session: the session, whose record's folder gets the file.
    """

    def __init__(self, node: Any, session: _Recorded) -> None:
        self._node, self._session = node, session
        self._last: tuple[Path | None, dict[str, Any]] = (None, {})

    def look(self) -> None:
        """Write the graph if it has changed, or if a new record has begun."""
        record = self._session.record
        if record is None:
            return
        topics = graph_of(self._node)
        if (record, topics) == self._last:
            return
        self._last = (record, topics)
        line = json.dumps({"t": time.time(), "topics": topics}, sort_keys=True)
        with suppress(OSError), record.with_name(NAME).open("a", encoding="utf-8") as file:
            file.write(line + "\n")  # a full disk is told by the record itself


def graph_of(node: Any) -> dict[str, Any]:
    """Type, publishers and subscribers (full names of nodes, sorted) of each topic that somebody publishes."""
    found = {}
    for name, types in node.get_topic_names_and_types():
        publishers = _names(node.get_publishers_info_by_topic(name))
        if publishers and name not in _HIDDEN:
            subscribers = _names(node.get_subscriptions_info_by_topic(name))
            found[name] = {"type": types[0], "publishers": publishers, "subscribers": subscribers}
    return found


def _names(ends: Any) -> list[str]:
    return sorted(f"{end.node_namespace.rstrip('/')}/{end.node_name}" for end in ends)
