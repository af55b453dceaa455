"""What the live viewer needs from whatever runs: `palpate.Session`, or a small fake in a test."""

from __future__ import annotations

from typing import Any, Protocol

from palpate.guidance.steered import SteeredFixtures
from palpate.record.ticks import Ticks


class Source(Protocol):
    """Something that runs in real time by itself and can be looked at and steered."""

    controls: Any
    """`palpate._core.Controls`; reading gives a copy, assigning hands it to the loop."""

    @property
    def steered(self) -> SteeredFixtures:
        """Its virtual fixtures, to switch, weigh and move; asked only where the stage has some."""
        ...

    def latest(self) -> Ticks:
        """The newest tick: never waits for the loop."""
        ...

    def start(self) -> None:
        """Starts, or goes on, in real time."""
        ...

    def stop(self) -> None:
        """Stops with the force at zero."""
        ...
