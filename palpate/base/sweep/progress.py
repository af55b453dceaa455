"""Progress of a sweep: a bar on a terminal, ten lines elsewhere."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

_LINES = 10  # number of progress lines over the whole sweep without a terminal


class Bar:
    """Shows the number of finished points.

    Args:
        console: output console; None: a bar on the standard error if it is a terminal, otherwise no output.
        title: name of the sweep.
        total: number of points.
    """

    def __init__(self, console: Console | None, title: str, total: int) -> None:
        self._console, self._title, self._total = console or Console(stderr=True), title, total
        self._quiet = console is None
        self._done, self._taken_up, self._printed, self._start = 0, 0, 0, time.monotonic()
        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
        )
        shown = self._console.is_terminal and total > 0
        self._bar = Progress(*columns, console=self._console, transient=True) if shown else None
        self._task = self._bar.add_task(title, total=total) if self._bar else None

    def advance(self, points: int, *, taken_up: bool = False) -> None:
        """Count further finished points; ``taken_up``: the points of an earlier run."""
        self._done += points
        self._taken_up += points if taken_up else 0
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=self._done)
        elif not self._quiet and self._done * _LINES >= (self._printed + 1) * self._total and not taken_up:
            self._printed = self._done * _LINES // self._total
            self._say(f"{self._title}: {self._done:,} of {self._total:,} points")

    def _say(self, text: str) -> None:
        self._console.print(text, soft_wrap=True, markup=False, highlight=False)

    def __enter__(self) -> Self:
        """Show the bar."""
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Remove the bar and print a summary."""
        if self._bar is not None:
            self._bar.stop()
        if self._quiet and self._bar is None:
            return
        seconds, new = time.monotonic() - self._start, self._done - self._taken_up
        before = f", {self._taken_up:,} of them taken up" if self._taken_up else ""
        rate = f" in {seconds:.1f} s ({new / max(seconds, 1e-9):.3g} a second)" if new else ""
        self._say(f"{self._title}: {self._done:,} of {self._total:,} points{before}{rate}")
