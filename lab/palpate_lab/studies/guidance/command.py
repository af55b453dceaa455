"""``palpate study guidance``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from rich.console import Console
from tyro.conf import arg

from palpate_lab.studies._command import Findings, SweepStudy
from palpate_lab.studies.guidance.work import SEED


@dataclass
class Command(SweepStudy):
    """Virtual fixtures, forces and visual cues in four tasks with simulated operators (about six minutes).

    examples:
      palpate study guidance
      palpate study guidance --json guidance.json --figures docs/images
      palpate study guidance --conformance
      palpate study guidance --conformance --seeds 10
      palpate study guidance --entry
      palpate study guidance --assumptions
    """

    operators: Annotated[int, arg(metavar="N")] = 200
    """Number of simulated operators."""
    seed: int = SEED
    """Seed of the cohort and of all noise."""
    conformance: bool = False
    """Run the conformance suite of all roles, geometries, laws and policies instead, including --entry."""
    seeds: Annotated[int, arg(metavar="N")] = 0
    """With --conformance: examine a sample of about a thousand checks at other places, for each of N seeds."""
    first_seed: Annotated[int, arg(metavar="SEED")] = 1
    """With --seeds: the first of the N seeds; the others follow it."""
    entry: bool = False
    """Measure the penetration of hard and soft fixtures in the full simulation instead (about two minutes)."""

    assumptions: bool = False
    """Vary the stiffness of the fixtures and the care of the first 20 operators instead (about two minutes)."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from palpate_lab.studies.guidance.assumptions import assumptions, tables
        from palpate_lab.studies.guidance.conformance import conform, conformance_words, entered, entry_words

        if self.conformance:
            judged = conform(self.sweeper(console), self.seeds, self.first_seed)
            return Findings({"conformance": judged}, lambda _: [], conformance_words(judged))
        if self.entry:
            penetration = entered(self.sweeper(console))
            return Findings({"entry": penetration}, lambda _: [], entry_words(penetration))
        if self.assumptions:
            varied = assumptions(self.operators, self.seed, self.sweeper(console))
            return Findings(varied, lambda _: [], tables(varied))
        return self._study(console)

    def _study(self, console: Console) -> Findings:
        from palpate_lab.studies.guidance.cues import cued
        from palpate_lab.studies.guidance.effects import summary
        from palpate_lab.studies.guidance.figures import draw
        from palpate_lab.studies.guidance.result import StudyResult
        from palpate_lab.studies.guidance.words import tables
        from palpate_lab.studies.guidance.work import run
        from palpate_lab.studies.guidance.yields import yielding

        rows = run(self.operators, self.seed, self.sweeper(console))
        found: StudyResult = {
            **summary(rows, self.seed),
            "visual_cues": cued(self.operators, self.seed, self.sweeper(console)),
            "yields": yielding(self.operators, self.seed, self.sweeper(console)),
        }
        return Findings(found, lambda folder: draw(rows, found, folder, self.seed), tables(found))
