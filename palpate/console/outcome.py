"""Result of a run: writes its report and prints the lines below its summary table."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from palpate import stop_signals
from palpate.console import CUT, INTERRUPTED
from palpate.console.output import say
from palpate.errors import MissingExtraError, PalpateError
from palpate.scene import Scene
from palpate.session.summary import Summary


def with_report(summary: Summary, scene: Scene) -> Summary:
    """Write the report next to the record; a failure is added to the faults, or printed on the standard error."""
    if not scene.record.report or summary.record is None:
        return summary
    if stop_signals.ends_at_once():
        return replace(summary, interrupted=True)
    try:
        from palpate.report import write_report

        return replace(summary, report=str(write_report(Path(summary.record))))
    except MissingExtraError as error:
        print(f"no report: {error}", file=sys.stderr)
        return summary
    except (PalpateError, OSError) as error:
        return replace(summary, faults=(*summary.faults, f"no report: {error}"))
    except KeyboardInterrupt:
        return replace(summary, interrupted=True)


def exit_code(*summaries: Summary) -> int:
    """The exit code of a run: INTERRUPTED, CUT if the record of a pair ends before the run, or 0."""
    if any(one.interrupted for one in summaries):
        return INTERRUPTED
    return CUT if any(one.record is not None and one.record_sha256 is None for one in summaries) else 0


def print_details(console: Console, summary: Summary, report_wanted: bool) -> None:
    """Print the details below the table: scheduling, faults and the files written."""
    if summary.interrupted:
        say(console, "stopped by Ctrl-C; the record is complete up to this moment")
    if summary.scheduler:
        say(console, f"scheduling: {summary.scheduler}")
    for fault in summary.faults:
        say(console, fault, "fault:", "red")
    if summary.record is not None:
        say(console, f"record: {summary.record}")
    if summary.report is not None:
        say(console, f"report: {summary.report}")
    elif summary.interrupted and report_wanted and summary.record is not None:
        say(console, f"report: not written; run: palpate report {summary.record}")
