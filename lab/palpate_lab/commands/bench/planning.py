"""`palpate bench planning`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Measure motion planning: random queries between organs, through a cage's window, and past another instrument.

    Every plan is checked at steps of 0.25 mm of any point by other code than the planner's, and its times at 1 kHz.

    examples:
      palpate bench planning --json planning.json
      palpate bench planning --queries 10
      palpate bench planning --planner BITstar --queries 20
      palpate bench planning --hooks
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    queries: int = 100
    """Number of random queries in each scene [-]."""
    planner: str = "RRTConnect"
    """OMPL's planner."""
    hooks: bool = False
    """Compare all planners on queries that need a search: jaws in slots on both sides of a wall."""
    check: bool = True
    """Check every plan densely; it takes most of the time."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate.planning.geometry import require
        from palpate_lab.verify.bench import planning

        console = console_for(self.json)
        require_writable(self.json)
        require()
        progress = partial(say, console)
        if self.hooks:
            rows = planning.hooks(self.queries, self.check, progress)
        else:
            rows = planning.run(self.queries, self.planner, self.check, progress)
        console.print(planning.table(rows))
        write_json(self.json, rows)
        return 0
