"""``palpate study pairs``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from tyro.conf import Positional

from palpate_lab.studies._command import Findings, Study


@dataclass
class Command(Study):
    """What each hand of a scene with pairs feels alone, and what the other pairs add (simulated).

    examples:
      palpate study pairs
      palpate study pairs my_two_hands.yaml --pair left --duration 5
    """

    scene: Positional[Path] = Path("two_hands")
    """Scene file (YAML) with the section pairs, or the name of a shipped scene."""
    pair: str = ""
    """The only pair to study; all when left out. The others run beside it."""
    duration: float | None = None
    """Simulated time; the scene's when left out [s]."""

    def study(self, console: Console) -> Findings:
        """Run each pair alone and all together."""
        from palpate_lab.studies.pairs.figures import draw
        from palpate_lab.studies.pairs.work import run, table

        found = run(self.scene, self.pair, self.duration)
        rows = [one.row for one in found]
        return Findings(rows, lambda folder: [draw(found, folder)], [table(rows)])
