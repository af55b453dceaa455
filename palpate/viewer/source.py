"""Interface between the live viewer and a running session: `palpate.Session`, or a small fake in a test."""

from __future__ import annotations

from typing import Any, Protocol

from palpate.record.ticks import Ticks
from palpate.scene.guidance.steered import SteeredFixtures


class Source(Protocol):
    """A simulation that runs in real time by itself, and can be observed and controlled."""

    controls: Any
    """`palpate._core.Controls`: reading returns a copy, assignment sends it to the loop."""

    @property
    def steered(self) -> SteeredFixtures:
        """The virtual fixtures, to switch, weight and move; used only if the stage has fixtures."""
        ...

    def latest(self) -> Ticks:
        """The newest tick, without waiting for the loop."""
        ...

    def start(self) -> None:
        """Starts or continues in real time."""
        ...

    def stop(self) -> None:
        """Stops with zero force."""
        ...
