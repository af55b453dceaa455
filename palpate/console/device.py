"""The live line of a scene on a device."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from palpate.console.live_line import LiveLine
from palpate.record.ticks import STATUS
from palpate.scene.rig import Rig
from palpate.session import State, nearest


class DeviceLine(LiveLine):
    """Force, the conditions that reduce it, and what is nearest; without a terminal nothing is printed."""

    def __init__(self, console: Console, rig: Rig | None = None) -> None:
        super().__init__(console)
        self._rig = rig

    def __call__(self, state: State) -> None:
        """Show the newest state."""
        if self._live is None:
            return
        status = int(state.tick["status"])
        free = "" if self._rig is None else nearest.in_words(self._rig, state.tick)
        words = [words for bit, words in STATUS.values() if status & bit]
        self._live.update(
            Text.assemble(
                (f"{state.t:7.1f} s", "bold"),
                ("  force ", "dim"),
                (f"{state.force:5.2f} N  ", "red" if state.contacts else ""),
                ("; ".join(words[:2]) or free or "free to push", "yellow" if words else "green"),
            )
        )
