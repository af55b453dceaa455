"""`palpate bench sweep`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Measure how fast many wall runs are on one core and on all cores.

    examples:
      palpate bench sweep
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate_lab.verify.bench import sweep

        console = console_for(self.json)
        require_writable(self.json)
        figures = sweep.run(on_progress=lambda text: say(console, text))
        console.print(sweep.table(figures))
        write_json(self.json, figures)
        return 0
