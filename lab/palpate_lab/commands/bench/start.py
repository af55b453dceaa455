"""`palpate bench start`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Measure the start-up time of help, a run and a check in a fresh process, next to a bare numpy import.

    examples:
      palpate bench start
      palpate bench start --json start.json
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    runs: int = 7
    """Number of fresh processes per command [-]."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate_lab.verify.bench import start

        console = console_for(self.json)
        require_writable(self.json)
        figures = start.run(max(1, self.runs), on_progress=lambda text: say(console, text))
        console.print(start.table(figures))
        write_json(self.json, figures)
        return 0
