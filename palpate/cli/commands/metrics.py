"""`palpate metrics`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, write_json


@dataclass
class Command:
    """Measure how a task was performed, from its record: time, paths, smoothness, clutches, forces, force sensitivity.

    examples:
      palpate metrics runs/palpation-1/record.mcap
      palpate metrics RECORD.mcap --need 0.8 --harm 2.5 --json -
    """

    record: Positional[Path]
    """Record of one pair."""
    need: Annotated[float, arg(metavar="N")] = 1.0
    """Force that the task needs [N]."""
    harm: Annotated[float, arg(metavar="N")] = 3.0
    """Force above which the tissue is harmed [N]."""
    threshold: Annotated[float, arg(metavar="N")] = 1.0
    """Force above which time is counted [N]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the measures as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print the measures; returns the exit code."""
        from rich.table import Table

        from palpate.metrics import summary

        console = console_for(self.json)
        require_writable(self.json)
        found = summary(self.record, need=self.need, harm=self.harm, threshold=self.threshold)
        table = Table(box=None, pad_edge=False, show_header=False)
        table.add_column(justify="left")
        table.add_column(justify="right")
        for name, value in found.items():
            table.add_row(name, "-" if value != value else f"{value:.4g}")
        console.print(table)
        write_json(self.json, {name: None if value != value else value for name, value in found.items()})
        return 0
