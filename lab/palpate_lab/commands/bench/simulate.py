"""`palpate bench simulate`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Compare palpate.simulate (many runs at once) with the same number of single sessions: time and memory.

    examples:
      palpate bench simulate
      palpate bench simulate --runs 1000 --sessions 50 --json simulate.json
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    runs: int = 40
    """Number of 5 s runs that each method does per turn [-]."""
    sessions: int = 0
    """Number of these runs that are also single sessions, whose time is scaled to all; 0: every run [-]."""
    turns: int = 2
    """Number of turns; the two methods alternate [-]."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate_lab.verify.bench import simulate

        console = console_for(self.json)
        require_writable(self.json)
        runs, turns = max(1, self.runs), max(1, self.turns)
        figures = simulate.run(
            runs, turns=turns, sessions=max(0, self.sessions), on_progress=lambda text: say(console, text)
        )
        console.print(simulate.table(figures))
        write_json(self.json, figures)
        return 0
