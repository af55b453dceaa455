"""Result of a run: writes its report and prints the lines below its summary table."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from palpate.base import stop_signals
from palpate.base.errors import MissingExtraError, PalpateError
from palpate.cli.terminal import CUT, INTERRUPTED
from palpate.cli.terminal.output import say
from palpate.scene import Scene
from palpate.session.summary import Summary


def wants_report(scene: Scene, viewer: bool) -> bool:
    """True if a report follows the run: as the scene says, or else in the viewer, whose stop button opens it."""
    return viewer if scene.record.report is None else scene.record.report


def with_report(summary: Summary, wanted: bool) -> Summary:
    """Write the report next to the record; a failure is added to the faults, or printed on the standard error."""
    if not wanted or summary.record is None:
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


def print_details(console: Console, summary: Summary) -> None:
    """Print the details below the table: scheduling, faults and the files written."""
    if summary.interrupted:
        say(console, "stopped by Ctrl-C; the record is complete up to this moment")
    if summary.scheduler:
        say(console, f"scheduling: {summary.scheduler}")
    for fault in summary.faults:
        say(console, fault, "fault:", "red")
    if summary.record is not None:
        say(console, f"record: {summary.record}")
        say(console, f"report: {summary.report or f'palpate report {summary.record}'}")
