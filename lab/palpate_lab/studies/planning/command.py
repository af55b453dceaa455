"""``palpate study planning``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from rich.console import Console
from tyro.conf import arg

from palpate_lab.studies._command import Findings, Study


@dataclass
class Command(Study):
    """Simulated operators on the routes of plans: entry into the margin with and without the plan as guidance.

    examples:
      palpate study planning --json planning.json --figures docs/images
      palpate study planning --routes 2 --operators 4
      palpate study planning --stiffness --routes 4 --operators 6
    """

    routes: Annotated[int, arg(metavar="N")] = 8
    """Number of routes in the scene `planning`."""
    operators: Annotated[int, arg(metavar="N")] = 16
    """Number of simulated operators, the first of the cohort of the other studies."""

    stiffness: bool = False
    """Compare springs of 200, 400, 700 and 1000 N/m to the path instead of kinds of assistance."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from rich.table import Table

        from palpate.cli.terminal.output import say
        from palpate.planning.geometry import require
        from palpate_lab.studies.planning.figures import draw
        from palpate_lab.studies.planning.work import CONDITIONS, SEED, SWEEP, run, summary

        require()
        if self.routes < 1 or self.operators < 1:
            raise ValueError(f"routes and operators must be 1 or more. Got: {self.routes}, {self.operators}")
        conditions = tuple(SWEEP if self.stiffness else CONDITIONS)
        rows = run(self.routes, self.operators, on_progress=lambda text: say(console, text), conditions=conditions)
        found = summary(rows)
        table = Table(
            "assistance",
            "entry [mm s]",
            "less",
            "95 %",
            "p (Holm)",
            "deepest [mm]",
            "path error [mm]",
            "time [s]",
            "done",
        )
        for row in found.values():
            low, high = row["entry_reduction_95"]
            share, span = f"{100 * row['entry_reduction']:.0f} %", f"{100 * low:.0f} to {100 * high:.0f} %"
            values = (row["deepest_mm"], row["path_error_mm"], row["time_s"])
            table.add_row(row["words"], f"{row['entry_mm_s']:.3f}", share, span, f"{row.get('p_holm', 1.0):.2g}",
                          *(f"{v:.2f}" for v in values), f"{100 * row['done']:.0f} %")  # fmt: skip
        result = {"seed": SEED, "conditions": found, "trials": rows}
        return Findings(result, lambda folder: draw(folder, rows, found), [table])
