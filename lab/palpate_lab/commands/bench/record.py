"""`palpate bench record`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json
from palpate_lab.verify.bench.record import HOURS


@dataclass
class Command:
    """Measure what a record costs: bytes and computing time of the writer, memory and time of its report.

    examples:
      palpate bench record
      palpate bench record --hours 1 --json record.json
    """

    hours: float = HOURS
    """Length of the record [h]."""
    scene: Path | None = None
    """Scene file of one pair; the shipped palpation scene when left out."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate_lab.verify.bench import record

        console = console_for(self.json)
        require_writable(self.json)
        figures = record.run(self.hours, self.scene, on_progress=lambda text: say(console, text))
        console.print(record.table(figures))
        write_json(self.json, figures)
        return 0
