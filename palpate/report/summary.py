"""The summary of a record, and how a summary looks in a terminal."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

from rich.table import Table

from palpate.session.summary import Summary, summarise

if TYPE_CHECKING:
    from palpate.record.reader import Record


def summary_of(record: Record) -> Summary:
    """Sum up a record.

    Times of computation are in the record of a real-time run only; in lockstep they are 0, as a summary says
    "unknown".
    """
    return summarise(
        record.ticks,
        record.rate,
        timing=record.timing,
        realtime=not record.deterministic,
        faults=(*record.faults, *([record.note] if record.note else [])),
        record=str(record.path),
        record_sha256=hashlib.sha256(record.path.read_bytes()).hexdigest(),
    )


def rows(summary: Summary) -> list[tuple[str, str, str]]:
    """The summary in words: (quantity, value with unit, what it means)."""
    s = summary
    share = 100.0 * s.contact_s / s.duration_s if s.duration_s else 0.0
    lines = [
        ("peak force", f"{s.peak_force_N:.2f} N", "largest force commanded on the hand (1 N: 100 g lie on it)"),
        ("mean force", f"{s.mean_force_N:.2f} N", "the same, averaged over the time in contact"),
        ("deepest penetration", f"{1e3 * s.max_penetration_m:.2f} mm", "how far the tool was inside the surface"),
        ("time in contact", f"{s.contact_s:.2f} s", f"{share:.0f} % of the {s.duration_s:.2f} s run"),
        ("force capped", f"{s.capped_s:.2f} s", "time in which the safety stage held the force back"),
        ("passivity", f"{s.passivity_s:.2f} s", "time in which it held the force back to what the hand had put in"),
        ("energy", energy(s.energy_J), "taken from the hand" if s.energy_J >= 0 else given(s)),
    ]
    lines.append(("top speed", f"{s.peak_speed_m_s:.3f} m/s", "of the handle"))
    calm = "inertia and Coriolis forces that the control law leaves to the hand stayed small"
    fast = "too fast for the control law: the hand felt the arm's inertia beside the force"
    lines.append(("fast motion", f"{s.fast_s:.2f} s", fast if s.fast_s > 0 else calm))
    if s.cycle_max_us > 0:
        cycle = f"{s.cycle_p50_us:.1f} / {s.cycle_p99_us:.1f} / {s.cycle_p999_us:.1f} / {s.cycle_max_us:.0f} us"
        lines.append(("haptic cycle", cycle, "time to compute one: p50 / p99 / p99.9 / longest"))
    if s.realtime:
        lines.append(("missed ticks", f"{s.missed_ticks} of {s.ticks}", "cycles that began a whole period late"))
    elif s.realtime_factor > 0:
        lines.append(("speed", f"{s.realtime_factor:.1f} x", "simulated time over the time it took (lockstep)"))
    return lines


def given(s: Summary) -> str:
    """An energy below zero in words: fixtures brought it, or it came of nothing."""
    if -s.energy_J <= s.energy_lent_J:
        return f"given, of {energy(s.energy_lent_J)} that fixtures brought"
    return "generated: more than it took"


def energy(joules: float) -> str:
    """An energy [J] with the unit that suits it."""
    return f"{1e3 * joules:.2f} mJ" if abs(joules) < 1.0 else f"{joules:.3f} J"


def summary_table(summary: Summary) -> Table:
    """The summary as a table for the terminal."""
    table = Table(title=f"{summary.duration_s:.2f} s, {summary.ticks} ticks", title_justify="left", box=None)
    table.add_column("", style="bold")
    table.add_column("", justify="right", style="cyan")
    table.add_column("", style="dim")
    table.show_header = False
    for quantity, value, meaning in rows(summary):
        table.add_row(quantity, value, meaning)
    return table
