"""`palpate replay` and `palpate report`."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from rich.console import Console

from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.cli.view import require_viewer, serve
from palpate.errors import MissingExtraError, RecordError
from palpate.record.bags import Bag
from palpate.record.reader import Record


def find(path: Path) -> Path:
    """The record itself when its folder is given; a folder without one may be a bag of other software."""
    inside = path / "record.mcap"
    return inside if path.is_dir() and (inside.exists() or not _is_bag(path)) else path


def open_any(path: Path) -> Record | Bag:
    """A record of ours, or the ROS 2 bag of any CRTK session.

    Raises:
        RecordError: neither.
    """
    found = find(path)
    if found.is_dir() or found.suffix == ".db3":
        return Bag.open(found)
    try:
        return Record.open(found)
    except RecordError as ours:
        if found.suffix != ".mcap" or not found.is_file():
            raise
        try:
            return Bag.open(found)
        except (RecordError, MissingExtraError):
            raise ours from None


def _is_bag(folder: Path) -> bool:
    return (folder / "metadata.yaml").exists() or any(folder.glob("*.mcap")) or any(folder.glob("*.db3"))


def replay(path: Path, port: int, scene: Path | None = None) -> int:
    """Sum a record up and show it until Ctrl-C."""
    from palpate.report.summary import summary_of, summary_table

    require_viewer()
    console = console_for(None)
    record = open_any(path)
    if isinstance(record, Bag):
        return _replay_bag(record, scene, port, console)
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
    record = open_any(path)
    if isinstance(record, Bag):
        return _report_bag(record, out, json, console)
    if record.note:
        say(console, record.note)
    page = write_report(record.path, out)
    summary = replace(summary_of(record), report=str(page))
    console.print(summary_table(summary))
    say(console, f"report: {page}")
    write_json(json, summary.to_json())
    return 0


def _replay_bag(bag: Bag, scene: Path | None, port: int, console: Console) -> int:
    from palpate.record.bags.summary import table
    from palpate.viewer.bag import stage_and_ticks

    shown = stage_and_ticks(bag, scene)
    console.print(table(bag))
    for note in bag.notes:
        say(console, note)
    serve(shown, port, console)
    return 0


def _report_bag(bag: Bag, out: Path | None, json: Path | None, console: Console) -> int:
    from palpate.record.bags.summary import summary_of, table
    from palpate.report.bag import write_page

    page = write_page(bag, out)
    console.print(table(bag))
    for note in bag.notes:
        say(console, note)
    say(console, f"report: {page}")
    write_json(json, summary_of(bag) | {"report": str(page)})
    return 0
