"""`palpate report`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.record.bags import Bag
    from palpate.record.reader import Record


@dataclass
class Command:
    """Summarise a record, or the ROS 2 bag of a CRTK session, and write its HTML report with figures.

    examples:
      palpate report runs/palpation-20260101-120000/record.mcap
      palpate report run.mcap --out liver.html
      palpate report rosbag2_2026_01_01-12_00_00
    """

    record: Positional[Path]
    """Record (MCAP), or its folder; the folder of a run of several pairs; or a rosbag2 (folder, .mcap, .db3)."""
    out: Annotated[Path | None, arg(metavar="FILE")] = None
    """The HTML file to write; report.html next to the record when left out."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the summary as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print the summary of the record and write its report."""
        from palpate.record.bags.open import open_any
        from palpate.record.reader import Record
        from palpate.report.pairs import pair_records

        console = console_for(self.json)
        require_writable(self.json)
        if pair_records(self.record):
            self._report_pairs(console)
            return 0
        found = open_any(self.record)
        if isinstance(found, Record):
            self._report_record(found, console)
        else:
            self._report_bag(found, console)
        return 0

    def _report_record(self, record: Record, console: Console) -> None:
        from palpate.report.html import report_of
        from palpate.report.run import Run
        from palpate.report.summary import summary_of, summary_table

        if record.note:
            say(console, record.note)
        run = Run(record)
        page = report_of(run, self.out)
        summary = replace(summary_of(record, run.digest.totals), report=str(page))
        console.print(summary_table(summary))
        _say_faults(record, console)
        say(console, f"report: {page}")
        write_json(self.json, summary)

    def _report_pairs(self, console: Console) -> None:
        from palpate.record.reader import Record
        from palpate.report.pairs import pair_records, write_pairs_report
        from palpate.report.summary import summary_of, summary_table

        page = write_pairs_report(self.record, self.out)
        summaries = {}
        for name, path in pair_records(self.record).items():
            record = Record.open(path)
            summaries[name] = replace(summary_of(record), report=str(path.with_name("report.html")))
            say(console, name, "pair", "bold")
            console.print(summary_table(summaries[name]))
            _say_faults(record, console)
        say(console, f"report: {page}")
        write_json(self.json, {"pairs": summaries, "record": str(self.record), "report": str(page)})

    def _report_bag(self, bag: Bag, console: Console) -> None:
        from palpate.record.bags.summary import summary_of, table
        from palpate.report.bag import write_page

        page = write_page(bag, self.out)
        console.print(table(bag))
        for note in bag.notes:
            say(console, note)
        say(console, f"report: {page}")
        write_json(self.json, replace(summary_of(bag), report=str(page)))


def _say_faults(record: Record, console: Console) -> None:
    for fault in record.faults:
        say(console, fault, "fault:", "red")
