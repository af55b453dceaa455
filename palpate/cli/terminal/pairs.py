"""Progress line and summary table of a run of several pairs."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rich.console import Console
from rich.table import Table

from palpate.cli.terminal.live_line import RunLine
from palpate.cli.terminal.output import say
from palpate.record.ticks import Ticks
from palpate.report.summary import rows
from palpate.session.pairs import States
from palpate.session.pairs_summary import PairsSummary


class PairsProgress(RunLine):
    """Shows the time, and of each pair phase, force, and what is nearest in the air, while a run goes on.

    Args:
        console, duration, mode: as those of `RunLine`.
        near: says for each pair what is nearest to a tool that touches nothing (`Session.nearest`).
        ended: says for each pair why it ended by itself, None if it did not; each is printed once.
    """

    def __init__(
        self,
        console: Console,
        duration: float | None,
        mode: str,
        near: Mapping[str, Callable[[Ticks], str]],
        ended: Callable[[], Mapping[str, str | None]] = dict,
    ) -> None:
        super().__init__(console, duration, mode)
        self._near, self._ended, self._said = near, ended, set[str]()

    def __call__(self, states: States) -> None:
        """Show the newest states."""
        for name, why in self._ended().items():
            if why is not None and name not in self._said:
                self._said.add(name)
                say(self._console, f"{name}: {why}; the others go on", "ended:", "red")
        words: list[str | tuple[str, str]] = []
        for name, state in states.items():
            words += [(f"  {name} ", "dim"), f"{state.phase or 'run':<8} "]
            words.append((f"{state.force:5.2f} N", "red" if state.contacts else ""))
            free = self._near[name](state.tick)
            words.append((f"  {free}" if free else "", "green"))
        self.show(max(state.t for state in states.values()), *words)


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
        forces = f"at most {meeting.peak_force_N:.2f} N, {meeting.peak_50ms_N:.2f} N over 50 ms"
        met = f"{meeting.contact_s:.2f} s, {forces}" if meeting.contact_s else "none"
        table.add_row("instruments closest", f"{1e3 * meeting.closest_m:.1f} mm")
        table.add_row("instruments in contact", met)
    if meeting.handles_closest_m is not None:
        near = f", {meeting.handles_close_s:.2f} s too close" if meeting.handles_close_s else ""
        table.add_row("handles closest", f"{1e3 * meeting.handles_closest_m:.0f} mm{near}")
    return table
