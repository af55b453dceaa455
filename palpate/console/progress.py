"""Progress of a run: a live line in a terminal, otherwise a few printed lines."""

from __future__ import annotations

from palpate.console.live_line import RunLine
from palpate.session import State


class Progress(RunLine):
    """Shows time, phase, force, penetration and cycle time while a run goes on."""

    def __call__(self, state: State) -> None:
        """Show the newest state."""
        self.show(
            state.t,
            f"  {state.phase or 'run':<10}",
            ("force ", "dim"),
            (f"{state.force:5.2f} N", "red" if state.contacts else ""),
            ("  penetration ", "dim"),
            f"{1e3 * state.depth:5.2f} mm",
            ("  cycle ", "dim"),
            f"{state.cycle_us:5.1f} us",
        )
