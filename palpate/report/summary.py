"""The summary of a record, and its table for the terminal."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml
from rich.table import Table

from palpate.base.arrays.yaml_loader import load
from palpate.record.lag import WORDS as FILTERS
from palpate.record.withheld import LASTING, SHIFT, WORDS
from palpate.session.summary import Summary, Totals

if TYPE_CHECKING:
    from palpate.record.reader import Record


def summary_of(record: Record, totals: Totals | None = None) -> Summary:
    """Summarise a record; `totals` are those of all its ticks if they are known.

    Only a real-time record contains compute times; for a lockstep record they are 0, which means unknown.
    """
    if totals is None:
        totals = Totals(record.rate)
        for ticks in record.blocks(Totals.SIGNALS):
            totals.add(ticks)
    return totals.summary(
        record.timing,
        instrument=_instrument(record),
        realtime=not record.deterministic,
        faults=(*record.faults, *([record.note] if record.note else [])),
        record=str(record.path),
        record_sha256=_sha256(record.path),
    )


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _instrument(record: Record) -> str:
    """Model of the follower in the scene of a record; empty if the record holds no scene."""
    try:
        found: Any = load(record.scene)
        return Path(found["arms"]["follower"]["model"]).stem
    except (yaml.YAMLError, TypeError, KeyError):
        return ""


def rows(summary: Summary) -> list[tuple[str, str, str]]:
    """The summary in words: (quantity, value with unit, meaning)."""
    s = summary
    share = 100.0 * s.contact_s / s.duration_s if s.duration_s else 0.0
    lines = [
        ("peak force", f"{s.peak_force_N:.2f} N", "largest force commanded on the hand (1 N is the weight of 100 g)"),
        ("held force", f"{s.peak_50ms_N:.2f} N", "largest mean force over 50 ms, which noise does not raise"),
        ("mean force", f"{s.mean_force_N:.2f} N", "commanded force, averaged over the time in contact"),
        ("deepest penetration", f"{1e3 * s.max_penetration_m:.2f} mm", "largest depth of the tool inside the surface"),
        ("time in contact", f"{s.contact_s:.2f} s", f"{share:.0f} % of the {s.duration_s:.2f} s run"),
        ("force capped", f"{s.capped_s:.2f} s", "time in which the safety stage limited the force"),
        ("passivity", f"{s.passivity_s:.2f} s", "time in which passivity control limited the returned energy"),
        *withheld_rows(s),
        (
            "filter lag",
            filter_lag(s),
            "delay that each filter of the force adds, mean and largest (negative: it leads)",
        ),
        ("energy", energy(s.energy_J), "taken from the hand" if s.energy_J >= 0 else given(s)),
    ]
    lines.append(("top speed", f"{s.peak_speed_m_s:.3f} m/s", "peak speed of the handle"))
    calm = "the inertia and Coriolis forces that the control law neglects stayed small"
    fast = "too fast for the control law: the hand also felt the arm's inertia"
    lines.append(("fast motion", f"{s.fast_s:.2f} s", fast if s.fast_s > 0 else calm))
    if s.remote is not None:
        r = s.remote
        ages = f"{r['round_trip_ms']:.0f} ms; {r['age_p50_ms']:.0f}, 99 %: {r['age_p99_ms']:.0f} ms; {r['outages']}"
        lines.append(("remote", ages, f"smallest round trip; age of the newest packet from {r['at']}; outages"))
    if s.cycle_max_us > 0:
        cycle = f"{s.cycle_p50_us:.1f} / {s.cycle_p99_us:.1f} / {s.cycle_p999_us:.1f} / {s.cycle_max_us:.0f} us"
        lines.append(("haptic cycle", cycle, "compute time of a cycle: p50 / p99 / p99.9 / longest"))
    if s.instrument:
        lines.append(("instrument", s.instrument, "model of the follower with its instrument"))
    if s.realtime:
        lines.append(
            ("missed ticks", f"{s.missed_ticks} of {s.missed_ticks + s.ticks}", "periods in which no cycle began")
        )
    elif s.realtime_factor > 0:
        lines.append(("speed", f"{s.realtime_factor:.1f} x", "simulated time over the time it took (lockstep)"))
    return lines


def withheld_rows(s: Summary) -> list[tuple[str, str, str]]:
    """Rows on what withheld a force for longer than half a second, and on the shift that pauses have left."""
    found = [
        ("force withheld", f"{one['peak_N']:.2f} N", f"at most, by {WORDS[name]}, for {one['time_s']:.2f} s")
        for name, one in s.withheld.items() if one["time_s"] >= LASTING
    ]  # fmt: skip
    if s.shift_m >= SHIFT:
        found.append(("shift", f"{1e3 * s.shift_m:.1f} mm", "of the tool against the hand, by pauses after faults"))
    return found


def filter_lag(s: Summary) -> str:
    """The lags of the filters in words; ``none`` if no filter delayed the force."""
    words = (f"{FILTERS[name]} {one['mean_ms']:.2g}, {one['max_ms']:.2g} ms" for name, one in s.lag_ms.items())
    return "; ".join(words) or "none"


def given(s: Summary) -> str:
    """Explains a negative energy: credited when fixtures were switched on, or generated by the rendered force."""
    if -s.energy_J <= s.energy_lent_J:
        return f"given to the hand, within the {energy(s.energy_lent_J)} credited when fixtures were switched on"
    return "generated: more energy returned than taken"


def energy(joules: float) -> str:
    """An energy [J] as text, in mJ or J."""
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
