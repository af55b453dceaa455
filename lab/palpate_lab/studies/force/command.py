"""``palpate study force``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from rich.console import Console
from tyro.conf import arg

from palpate_lab import places
from palpate_lab.studies._command import Findings, Study


@dataclass
class Command(Study):
    """Force without a sensor: a weight on a real arm, and a floor under a simulated arm (a minute).

    examples:
      palpate study force
      palpate study force --json force.json --figures pictures
    """

    data: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder of the recordings, PALPATE_DATA when left out; without recordings, the study of the weight is skipped."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from palpate_lab.studies.force.figures import draw
        from palpate_lab.studies.force.work import OTHER_CUTOFFS, in_words, simulated, weight, weight_json, words

        recordings = (self.data or places.data()) / "psm_moving"
        load = weight(recordings) if recordings.is_dir() else None
        filtered = {cutoff: weight(recordings, cutoff) for cutoff in OTHER_CUTOFFS} if load else {}
        found, trace = simulated()
        return Findings(
            {"weight": weight_json(load, filtered) if load else None, "simulated": found},
            lambda folder: [draw(load, trace, found, folder)],
            [*words(load, recordings), in_words(found)],
        )
