"""``palpate soak ros``: the haptic node beside the simulated robot for hours, while a simulated hand presses on a wall.

Robot and node are `palpate ros sim` and `palpate ros haptics` in processes of their own. A row of counts goes to a log
in fixed intervals; a later start with the same log continues it. `judge` says what is not as it should be.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
from rich.table import Table

from palpate.base.errors import PalpateError
from palpate_lab.verify.soak.ros_row import PARTS, RATE, Row

INTERVAL = 60.0  # [s]
MOST_GROWTH = 1.0  # growth of a process's memory that is accepted [MB/h]
MOST_LINES = 120.0  # lines of the node per hour that are accepted, after the first twenty
MOST_UNANSWERED = 1e-3  # share of the leader's states without a wrench that is accepted
_WARM = 0.2  # share of a segment before the memory is fitted
_SHORTEST = 60.0  # shortest time over which a growth is fitted [s]


@dataclass
class Soak:
    """Result of all segments. The keys are the documented contract of ``--json``."""

    hours: float
    asked_h: float
    segments: int
    wrenches: int
    expected: int
    missed: int
    unanswered: int
    touches: int
    guarded: int
    left_out: int
    lines: int
    lines_per_hour: float
    load: float
    memory_MB: dict[str, float]
    growth_MB_per_h: dict[str, float] | None
    wrong: list[str] = field(default_factory=list)


def run(hours: float, log: Path, interval: float = INTERVAL, on_row: Callable[[Row], None] = lambda _: None) -> Soak:
    """Run until the log holds `hours` [h]; one row each `interval` [s].

    Raises:
        PalpateError: `hours` or `interval` is out of range, robot or node does not start, or the log is not one of this
            command.
        RosMissingError: ROS 2 is not installed.
    """
    if not (0.0 < hours <= 1e4 and 0.5 <= interval <= 3600.0):
        raise PalpateError(
            f"--hours {hours:g}, --interval {interval:g}: hours must be above 0, the interval 0.5 to 3600 s",
            mend="e.g. --hours 50 --interval 60",
        )
    rows = read(log)
    left = 3600.0 * hours - done(rows)
    if left > 0.0:
        from palpate_lab.verify.soak.ros_segment import Segment

        number = 1 + max((row.segment for row in rows), default=0)
        with Segment(number, log.parent) as segment, log.open("a", encoding="utf-8") as file:
            while segment.t < left and not (rows and rows[-1].segment == number and rows[-1].ended):
                segment.press(min(interval, left - segment.t))
                rows.append(segment.row())
                file.write(json.dumps(asdict(rows[-1])) + "\n")
                file.flush()
                os.fsync(file.fileno())
                on_row(rows[-1])
    return judge(rows, hours)


def read(log: Path) -> list[Row]:
    """The rows of a log; a last line that was cut off is ignored, no log gives none.

    Raises:
        PalpateError: a line is no row.
    """
    rows: list[Row] = []
    lines = log.read_text(encoding="utf-8").splitlines(keepends=True) if log.exists() else []
    for number, line in enumerate(lines, 1):
        try:
            rows.append(Row(**json.loads(line)))
        except (ValueError, TypeError):
            if number == len(lines) and not line.endswith("\n"):
                log.write_text("".join(lines[:-1]), encoding="utf-8")
                break
            mend = "choose another file with --log, or delete it"
            raise PalpateError(f"line {number} is no row of a soak", where=str(log), mend=mend) from None
    return rows


def done(rows: list[Row]) -> float:
    """Time of all segments together [s]."""
    return sum(row.t_s for row in _last_of_segments(rows))


def judge(rows: list[Row], hours: float) -> Soak:
    """Sum the segments up and say what is wrong."""
    ends = _last_of_segments(rows)
    total = {key: sum(getattr(row, key) for row in ends)
             for key in ("wrenches", "states", "left_out", "guarded", "touches", "lines")}  # fmt: skip
    seconds = max(done(rows), 1e-9)
    longest = max(ends, key=lambda row: row.t_s).segment
    soak = Soak(
        hours=seconds / 3600.0,
        asked_h=hours,
        segments=len(ends),
        wrenches=total["wrenches"],
        expected=total["states"],
        missed=max(0, round(RATE * seconds) - total["states"]),
        unanswered=max(0, total["states"] - total["wrenches"]),
        touches=total["touches"],
        guarded=total["guarded"],
        left_out=total["left_out"],
        lines=total["lines"],
        lines_per_hour=total["lines"] / (seconds / 3600.0),
        load=float(np.mean([row.load for row in rows])),
        memory_MB=ends[-1].memory_MB,
        growth_MB_per_h=growth([row for row in rows if row.segment == longest]),
    )
    soak.wrong = _wrong(soak, ends)
    return soak


def growth(rows: list[Row]) -> dict[str, float] | None:
    """Slope of each process's memory after the warm-up of a segment [MB/h]; None if the segment is too short."""
    warm = [row for row in rows if row.t_s >= _WARM * rows[-1].t_s]
    if len(warm) < 3 or warm[-1].t_s - warm[0].t_s < _SHORTEST:
        return None
    t = np.array([row.t_s for row in warm]) / 3600.0
    return {part: float(np.polyfit(t, [row.memory_MB[part] for row in warm], 1)[0]) for part in PARTS}


def table(soak: Soak) -> Table:
    """The result as a table for a terminal."""
    out = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    out.add_row("time", f"{soak.hours:.3f} of {soak.asked_h:g} h in {soak.segments} segments, load {soak.load:.1f}")
    counts = f"{soak.wrenches:,} for {soak.expected:,} states, {soak.unanswered:,} unanswered, {soak.missed:,} missed"
    out.add_row("wrenches", f"{counts}; {soak.touches:,} touches of the wall")
    out.add_row("guardian", f"took over {soak.guarded:,} times; {soak.left_out:,} states rejected")
    out.add_row("lines printed", f"{soak.lines:,}, {soak.lines_per_hour:.0f} an hour")
    slopes = soak.growth_MB_per_h or {}
    memory = [f"{part} {soak.memory_MB[part]:.0f} MB" + (f" ({slopes[part]:+.2f} MB/h)" if slopes else "")
              for part in PARTS]  # fmt: skip
    out.add_row("memory", ", ".join(memory))
    out.add_row("wrong", "; ".join(soak.wrong) or "nothing")
    return out


def _last_of_segments(rows: list[Row]) -> list[Row]:
    return list({row.segment: row for row in rows}.values())


def _wrong(soak: Soak, ends: list[Row]) -> list[str]:
    wrong = [f"a process ended by itself in segment {row.segment}, after {row.t_s:.0f} s" for row in ends if row.ended]
    if soak.touches == 0:
        wrong.append("the hand never felt the wall")
    if soak.unanswered > MOST_UNANSWERED * soak.expected:
        wrong.append(f"{soak.unanswered} states without a wrench, of {soak.expected}")
    if soak.lines > 20 + MOST_LINES * soak.hours:
        wrong.append(f"{soak.lines} lines printed in {soak.hours:.2f} h")
    # A slope over minutes is that of caches and of the allocator; it counts once it is a growth of some megabytes.
    longest = max(row.t_s for row in ends) / 3600.0
    for part, slope in (soak.growth_MB_per_h or {}).items():
        if slope > MOST_GROWTH and slope * longest > 5.0:
            wrong.append(f"the memory of {part} grows by {slope:.1f} MB/h")
    return wrong
