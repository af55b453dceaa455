"""``palpate study geometry``."""

from __future__ import annotations

from dataclasses import dataclass

from rich.console import Console

from palpate_lab.studies._command import Findings, Study


@dataclass
class Command(Study):
    """The paper's geometry: normals at point contact, face angles from contact points, and where they fail.

    examples:
      palpate study geometry
      palpate study geometry --json geometry.json --figures docs/images
    """

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from palpate_lab.studies.geometry.figures import draw
        from palpate_lab.studies.geometry.work import run, tables

        result = run()
        return Findings(result, draw, [part for pair in tables(result) for part in pair])
