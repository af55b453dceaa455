"""``palpate study radius``."""

from __future__ import annotations

from dataclasses import dataclass

from rich.console import Console

from palpate_lab.studies._command import Findings, SweepStudy


@dataclass
class Command(SweepStudy):
    """Effect of the sphere's radius on features and on sensor noise, compared with a force filter.

    examples:
      palpate study radius
      palpate study radius --json radius.json --figures docs/images
      palpate study radius --spheres
    """

    spheres: bool = False
    """Press into noisy meshes and point clouds of a sphere instead: what removing the noise gains (seconds)."""

    def study(self, console: Console) -> Findings:
        """Measure all radii."""
        if self.spheres:
            return self._spheres()
        from palpate_lab.studies.radius.figures import draw
        from palpate_lab.studies.radius.work import run, table

        rows = run(sweep=self.sweeper(console))
        return Findings(rows, lambda folder: [draw(rows, folder)], [table(rows)])

    def _spheres(self) -> Findings:
        from palpate_lab.studies.radius.spheres import spheres, table

        found = spheres()
        return Findings(found, lambda _: [], table(found))
