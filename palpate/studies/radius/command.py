"""``palpate study radius``."""

from __future__ import annotations

from dataclasses import dataclass

from rich.console import Console

from palpate.studies._command import Findings, SweepStudy


@dataclass
class Command(SweepStudy):
    """Effect of the sphere's radius on features and on sensor noise, compared with a force filter.

    examples:
      palpate study radius
      palpate study radius --json radius.json --figures docs/images
    """

    def study(self, console: Console) -> Findings:
        """Measure all radii."""
        from palpate.studies.radius.figures import draw
        from palpate.studies.radius.work import run, table

        rows = run(sweep=self.sweeper(console))
        return Findings(rows, lambda folder: [draw(rows, folder)], [table(rows)])
