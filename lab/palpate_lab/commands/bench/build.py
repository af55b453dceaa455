"""`palpate bench build`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Measure the compile time of the core: per file, the slowest headers, and the total next to a control.

    The command compiles the core in a new folder; it needs a clone of the repository with the developer packages.

    examples:
      palpate bench build
      palpate bench build --last --json build.json
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    most: int = 12
    """Number of files and headers to print [-]."""
    last: bool = False
    """Read the log of this environment's last build, with wall times, and compile nothing but the control."""

    def __call__(self) -> int:
        """Compile or read the log, print the table, write the JSON contract."""
        from palpate_lab.verify.bench import build

        console = console_for(self.json)
        require_writable(self.json)
        report = (lambda text: say(console, text)) if console else (lambda _: None)
        figures = build.read_last() if self.last else build.run(on_progress=report)
        for table in build.tables(figures, self.most):
            console.print(table)
        write_json(self.json, figures)
        return 0
