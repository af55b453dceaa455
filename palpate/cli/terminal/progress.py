"""Progress of a run: a live line in a terminal, otherwise a few printed lines."""

from __future__ import annotations

from collections.abc import Callable

from rich.console import Console

from palpate.cli.terminal.live_line import RunLine
from palpate.record.ticks import Ticks
from palpate.session import State


class Progress(RunLine):
    """Shows time, phase, force, penetration, cycle time, and what is nearest in the air, while a run goes on.

    Args:
        console, duration, mode: as those of `RunLine`.
        near: says what is nearest to a tool that touches nothing (`Session.nearest`).
    """

    def __init__(self, console: Console, duration: float, mode: str, near: Callable[[Ticks], str]) -> None:
        super().__init__(console, duration, mode)
        self._near = near

    def __call__(self, state: State) -> None:
        """Show the newest state."""
        free = self._near(state.tick)
        self.show(
            state.t,
            f"  {state.phase or 'run':<10}",
            ("force ", "dim"),
            (f"{state.force:5.2f} N", "red" if state.contacts else ""),
            ("  penetration ", "dim"),
            f"{1e3 * state.depth:5.2f} mm",
            ("  cycle ", "dim"),
            f"{state.cycle_us:5.1f} us",
            (f"  {free}" if free else "", "green"),
        )
