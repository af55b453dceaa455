"""``palpate study guidance``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from rich.console import Console
from tyro.conf import arg

from palpate.studies._command import Findings, SweepStudy
from palpate.studies.guidance.work import SEED


@dataclass
class Command(SweepStudy):
    """Virtual fixtures, forces and visual cues in four tasks, done by simulated operators (some six minutes).

    examples:
      palpate study guidance
      palpate study guidance --json guidance.json --figures docs/images
      palpate study guidance --conformance
      palpate study guidance --entry
    """

    operators: Annotated[int, arg(metavar="N")] = 200
    """How many simulated operators."""
    seed: int = SEED
    """Of the cohort and of all that is random."""
    conformance: bool = False
    """Instead: every role x geometry x law x policy, judged by numbers of its own; and --entry."""
    entry: bool = False
    """Instead: how far the tool gets into hard regions and soft ones, in the whole simulation (some two minutes)."""

    def study(self, console: Console) -> Findings:
        """Do the work."""
        from palpate.studies.guidance.conformance import conform, conformance_words, entered, entry_words

        if self.conformance:
            judged = conform(self.sweeper(console))
            return Findings({"conformance": judged}, lambda _: [], conformance_words(judged))
        if self.entry:
            told = entered(self.sweeper(console))
            return Findings({"entry": told}, lambda _: [], entry_words(told))
        return self._study(console)

    def _study(self, console: Console) -> Findings:
        from palpate.studies.guidance.cues import cued
        from palpate.studies.guidance.effects import summary
        from palpate.studies.guidance.figures import draw
        from palpate.studies.guidance.result import Found
        from palpate.studies.guidance.words import tables
        from palpate.studies.guidance.work import run
        from palpate.studies.guidance.yields import yielding

        rows = run(self.operators, self.seed, self.sweeper(console))
        told: Found = {
            **summary(rows, self.seed),
            "visual_cues": cued(self.operators, self.seed, self.sweeper(console)),
            "yields": yielding(self.operators, self.seed, self.sweeper(console)),
        }
        return Findings(told, lambda folder: draw(rows, told, folder, self.seed), tables(told))
