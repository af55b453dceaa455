"""`palpate replay` and `palpate report`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.cli.view import require_viewer, serve
from palpate.record.reader import Record


def find(path: Path) -> Path:
    """The record itself when its folder is given."""
    return path / "record.mcap" if path.is_dir() else path


def replay(path: Path, port: int) -> int:
    """Sum a record up and show it until Ctrl-C."""
    from palpate.report.summary import summary_of, summary_table

    require_viewer()
    console = console_for(None)
    record = Record.open(find(path))
    if record.note:
        say(console, record.note)
    console.print(summary_table(summary_of(record)))
    for fault in record.faults:
        say(console, fault, "fault:", "red")
    serve(record, port, console)
    return 0


def report(path: Path, out: Path | None, json: Path | None) -> int:
    """Sum a record up and write its report."""
    from palpate.report import write_report
    from palpate.report.summary import summary_of, summary_table

    console = console_for(json)
    require_writable(json)
    record = Record.open(find(path))
    if record.note:
        say(console, record.note)
    page = write_report(record.path, out)
    summary = replace(summary_of(record), report=str(page))
    console.print(summary_table(summary))
    say(console, f"report: {page}")
    write_json(json, summary.to_json())
    return 0
