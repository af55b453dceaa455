"""Progress of a run: a live line in a terminal, otherwise a few printed lines."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from palpate.console.live_line import LiveLine
from palpate.session import State

_LINES = 10  # lines over the whole run, without a terminal


class Progress(LiveLine):
    """Shows time, phase, force, penetration and cycle time while a run goes on.

    Args:
        console: output.
        duration: simulated time of the run [s].
        mode: words for the mode, such as "real time".
    """

    def __init__(self, console: Console, duration: float, mode: str) -> None:
        super().__init__(console)
        self._duration, self._mode = duration, mode
        self._start: float | None = None
        self._printed = 0

    def __call__(self, state: State) -> None:
        """Show the newest state."""
        if self._start is None:
            self._start = state.t
        done = state.t - self._start
        line = Text.assemble(
            (f"{done:6.1f} / {self._duration:g} s", "bold"),
            f"  {state.phase or 'run':<10}",
            ("force ", "dim"),
            (f"{state.force:5.2f} N", "red" if state.contacts else ""),
            ("  penetration ", "dim"),
            f"{1e3 * state.depth:5.2f} mm",
            ("  cycle ", "dim"),
            f"{state.cycle_us:5.1f} us",
            (f"  {self._mode}", "dim"),
        )
        if self._live is not None:
            self._live.update(line)
        elif done >= self._printed * self._duration / _LINES:
            self._printed += 1
            self._console.print(line, soft_wrap=True)
