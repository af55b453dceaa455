"""What a haptic node that has ended still answers. The node itself has left the network, and its arm is free."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from palpate.base.errors import StateError


class EndedNode:
    """The last ticks, figures and shapes of a haptic node, with its interface. Scenes and controls have no effect.

    Args:
        node: a native HapticNode after its `stop`.
        soft: numbers of the soft objects of its scene.
    """

    def __init__(self, node: Any, soft: Iterable[int]) -> None:
        self._rows, self._latest, self._timing = node.drain(), node.latest(), node.timing()
        self._events: list[str] = node.take_events()
        self._shapes = {k: node.soft_vertices(k) for k in soft}
        self.dropped, self.controls = node.dropped, node.controls

    def start(self) -> None:
        """Refuse to run again.

        Raises:
            StateError: always.
        """
        raise StateError("the node of this session has ended: its guardian works only once", mend="make a new session")

    def drain(self) -> Any:
        """Ticks since the last call."""
        rows, self._rows = self._rows, self._rows[:0]
        return rows

    def latest(self) -> Any:
        """The last tick."""
        return self._latest

    def timing(self) -> dict[str, Any]:
        """Computation times, response times, counts and rates of the run."""
        return dict(self._timing)

    def take_events(self) -> list[str]:
        """Messages for the user since the last call, oldest first."""
        events, self._events = self._events, []
        return events

    def soft_vertices(self, object: int, /) -> Any:
        """Last shape (n, 3) of a soft object, in the object's frame O [m]."""
        return self._shapes[object]

    def set_snapshot(self, snapshot: Any) -> None:
        """No effect."""

    def set_live(self, targets: Any) -> None:
        """No effect."""

    def set_fixtures(self, fixtures: Any) -> None:
        """No effect."""
