"""The live line of a scene on a device."""

from __future__ import annotations

from collections.abc import Callable

from rich.console import Console
from rich.text import Text

from palpate.cli.terminal.live_line import LiveLine
from palpate.record.ticks import STATUS, Ticks
from palpate.session import State


class DeviceLine(LiveLine):
    """Force, the conditions that reduce it, and what is nearest; without a terminal nothing is printed.

    Args:
        console: output.
        near: says what is nearest to a tool that touches nothing (`Session.nearest`).
    """

    def __init__(self, console: Console, near: Callable[[Ticks], str]) -> None:
        super().__init__(console)
        self._near = near

    def __call__(self, state: State) -> None:
        """Show the newest state."""
        if self._live is None:
            return
        status = int(state.tick["status"])
        words = [words for bit, words in STATUS.values() if status & bit]
        self._live.update(
            Text.assemble(
                (f"{state.t:7.1f} s", "bold"),
                ("  force ", "dim"),
                (f"{state.force:5.2f} N  ", "red" if state.contacts else ""),
                ("; ".join(words[:2]) or self._near(state.tick) or "free to push", "yellow" if words else "green"),
            )
        )
