"""``palpate study contact``."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from rich.console import Console

from palpate_lab.studies._command import Findings, SweepStudy


@dataclass
class Command(SweepStudy):
    """Every contact method over every shape: direction, steps, energy, time (minutes).

    examples:
      palpate study contact
      palpate study contact --json contact.json --figures docs/images
      palpate study contact --large
    """

    large: bool = False
    """Also measure meshes of a million triangles."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from palpate_lab.studies.contact.figures import draw
        from palpate_lab.studies.contact.words import table
        from palpate_lab.studies.contact.work import LARGE, TRIANGLES, run

        result = run((*TRIANGLES, LARGE) if self.large else TRIANGLES, self.sweeper(console))
        return Findings(result, partial(draw, result), [table(result["rows"])])
