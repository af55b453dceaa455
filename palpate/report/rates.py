"""Section of a report: rate, lateness and age of every loop and source of the run."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from palpate.record.snapshots import CAMERA
from palpate.report.run import Run
from palpate.session.rates import Rate, cells, snapshot

WORDS = (
    "Each loop with its measured rate, how late its cycles started, how many periods it missed, and the largest age of "
    "its values. A lockstep run has a clock of its own: it is never late."
)


def rates_of(run: Run, name: str = "") -> list[Rate]:
    """The rates of a run; name: of its pair."""
    record = run.record
    rows = run.digest.rates.rows(name, record.rate, record.timing, run.tracked_frames)
    for topic in record.snapshot_topics:
        track = record.snapshots(topic)
        if track is not None:
            what = "endoscope" if topic == CAMERA else f"shape of {topic.rsplit('/', 1)[1]}"
            rows.append(snapshot(f"{name} {what}, recorded".strip(), track))
    return rows


def table(rates: Iterable[Rate]) -> str:
    """HTML table with one row per loop and source."""
    head = "<tr><th>loop or source</th><th>rate</th><th>late, p99</th><th>missed</th><th>largest age</th></tr>"
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in cells(rate))}</tr>" for rate in rates)
    return f'<div class="scroll"><table class="signals">{head}{body}</table></div>'
