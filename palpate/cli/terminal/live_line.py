"""A line that a terminal rewrites while a command runs, or a few printed lines of the progress of a run."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from rich.console import Console
from rich.live import Live
from rich.text import Text

_LINES = 10  # lines over the whole run, without a terminal


class LiveLine:
    """A context manager for a line that the terminal rewrites; without a terminal `_live` is None."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._live = Live(console=console, refresh_per_second=12, transient=True) if console.is_terminal else None

    def __enter__(self) -> Self:
        """Start rewriting the line."""
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Erase the line."""
        if self._live is not None:
            self._live.stop()


class RunLine(LiveLine):
    """The line of a run of known duration.

    Args:
        console: output.
        duration: time of the run [s]; None: until Ctrl-C.
        mode: words for the mode, such as "real time".
    """

    def __init__(self, console: Console, duration: float | None, mode: str) -> None:
        super().__init__(console)
        self._duration, self._mode = duration, mode
        self._start: float | None = None
        self._printed = 0

    def show(self, t: float, *words: str | Text | tuple[str, str]) -> None:
        """Show the time and these words, with styles as `rich.text.Text.assemble` takes them.

        Args:
            t: time of the newest state; the first one is the start [s].
            words: what follows the time.
        """
        if self._start is None:
            self._start = t
        done = t - self._start
        end = "" if self._duration is None else f" / {self._duration:g}"
        line = Text.assemble((f"{done:6.1f}{end} s", "bold"), *words, (f"  {self._mode}", "dim"))
        if self._live is not None:
            self._live.update(line)
        elif self._duration is not None and done >= self._printed * self._duration / _LINES:
            self._printed += 1
            self._console.print(line, soft_wrap=True)
