"""Progress line and summary table of a run of several pairs."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from palpate.console.live_line import LiveLine
from palpate.report.summary import rows
from palpate.session.pairs import States
from palpate.session.pairs_summary import PairsSummary

_LINES = 10  # lines over the whole run, without a terminal


class PairsProgress(LiveLine):
    """Shows the time, and phase and force of each pair, while a run goes on.

    Args:
        console: output.
        duration: time of the run [s].
        mode: words for the mode, such as "real time".
    """

    def __init__(self, console: Console, duration: float, mode: str) -> None:
        super().__init__(console)
        self._duration, self._mode = duration, mode
        self._start: float | None = None
        self._printed = 0

    def __call__(self, states: States) -> None:
        """Show the newest states."""
        now = max(state.t for state in states.values())
        if self._start is None:
            self._start = now
        done = now - self._start
        line = Text.assemble((f"{done:6.1f} / {self._duration:g} s", "bold"))
        for name, state in states.items():
            line.append(f"  {name} ", "dim")
            line.append(f"{state.phase or 'run':<8} ")
            line.append(f"{state.force:5.2f} N", "red" if state.contacts else "")
        line.append(f"  {self._mode}", "dim")
        if self._live is not None:
            self._live.update(line)
        elif done >= self._printed * self._duration / _LINES:
            self._printed += 1
            self._console.print(line, soft_wrap=True)


def pairs_table(summary: PairsSummary) -> Table:
    """The summaries of all pairs as one table, with a column for each."""
    head = f"{summary.duration_s:.2f} s, {len(summary.pairs)} pairs"
    table = Table(title=head, title_justify="left", box=None)
    table.add_column("", style="bold")
    for name in summary.pairs:
        table.add_column(name, justify="right", style="cyan")
    each = [{quantity: value for quantity, value, _ in rows(one)} for one in summary.pairs.values()]
    for quantity in dict.fromkeys(key for one in each for key in one):
        table.add_row(quantity, *(one.get(quantity, "-") for one in each))
    meeting = summary.instruments
    if meeting.closest_m is not None:
        met = f"{meeting.contact_s:.2f} s, at most {meeting.peak_force_N:.2f} N" if meeting.contact_s else "none"
        table.add_row("instruments closest", f"{1e3 * meeting.closest_m:.1f} mm")
        table.add_row("instruments in contact", met)
    if meeting.handles_closest_m is not None:
        near = f", {meeting.handles_close_s:.2f} s too close" if meeting.handles_close_s else ""
        table.add_row("handles closest", f"{1e3 * meeting.handles_closest_m:.0f} mm{near}")
    return table
