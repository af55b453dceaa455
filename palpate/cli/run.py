"""`palpate run`."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console

from palpate.certificate.scene import warn_outside
from palpate.cli import INTERRUPTED
from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.cli.progress import Progress
from palpate.cli.view import require_viewer, serve
from palpate.errors import MissingExtraError, PalpateError
from palpate.scene import Scene
from palpate.session import Session
from palpate.session.summary import Summary

if TYPE_CHECKING:
    from palpate.cli.commands import Run


def run(o: Run) -> int:
    """Run a scene, tell about it, serve the viewer if wanted; returns the exit code."""
    from palpate.report.summary import summary_table

    _refuse_contradictions(o)
    console = console_for(o.json)
    viewer = o.serve or (not o.headless and sys.stdout.isatty() and sys.stdin.isatty())
    if viewer:
        require_viewer()
    require_writable(o.json)
    scene = Scene.load(o.scene)
    session = Session(scene, out=o.out or Path(scene.record.folder), seed=o.seed)
    warn_outside(session.rig)
    duration = scene.duration if o.duration is None else o.duration
    realtime = o.realtime or (viewer and not o.fast)
    mode = "real time" if realtime else "lockstep, as fast as it goes"
    with Progress(console, duration, mode) as progress:
        summary = session.run(duration, realtime=realtime, on_progress=progress)
    summary = with_report(summary, scene)
    console.print(summary_table(summary))
    tell(console, summary, scene.record.report)
    write_json(o.json, summary.to_json())
    if summary.interrupted:
        return INTERRUPTED
    if viewer:
        session.recording = False
        serve(session, o.port, console)
    return 0


def _refuse_contradictions(o: Run) -> None:
    if o.realtime and o.fast:
        raise PalpateError("--realtime and --fast contradict each other", mend="give one of them, or none")
    if o.serve and o.headless:
        raise PalpateError("--serve and --headless contradict each other", mend="give one of them, or none")
    if o.duration is not None and not 0.0 < o.duration < 1e7:
        raise PalpateError(f"--duration {o.duration:g}: must be above 0 s", mend="give seconds, e.g. --duration 20")
    if o.seed is not None and not 0 <= o.seed < 2**64:
        raise PalpateError(f"--seed {o.seed}: must be a whole number from 0", mend="give e.g. --seed 1")


def with_report(summary: Summary, scene: Scene) -> Summary:
    """The report beside the record; a report that cannot be made is told and costs nothing else."""
    if not scene.record.report or summary.record is None:
        return summary
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


def tell(console: Console, summary: Summary, report_wanted: bool) -> None:
    """How it went, beside the table."""
    if summary.interrupted:
        say(console, "stopped by Ctrl-C; everything up to here is kept")
    if summary.scheduler:
        say(console, f"scheduling: {summary.scheduler}")
    for fault in summary.faults:
        say(console, fault, "fault:", "red")
    if summary.record is not None:
        say(console, f"record: {summary.record}")
    if summary.report is not None:
        say(console, f"report: {summary.report}")
    elif summary.interrupted and report_wanted and summary.record is not None:
        say(console, f"report: not written; palpate report {summary.record} does it")
