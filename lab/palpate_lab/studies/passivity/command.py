"""``palpate study passivity``."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import cast

from rich.console import Console

from palpate.base.sweep import Axis
from palpate_lab.studies._command import Findings, SweepStudy


@dataclass
class Command(SweepStudy):
    """Passivity layer on random devices, hands and walls: true energy at the port and changes of the force.

    examples:
      palpate study passivity --runs 1000
      palpate study passivity --json passivity.json --figures docs/images
      palpate study passivity --extract
    """

    runs: int = 10_000
    """Number of random cases; each runs without the layer and with the layer in three modes."""
    seed: int = 0
    """Seed of the random cases."""

    extract: bool = False
    """Move the handle to take energy out of the layer instead: 100 motions in each of eight cases (a minute)."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        if self.extract:
            return self._extracted(console)
        from palpate_lab.studies.passivity.figures import draw
        from palpate_lab.studies.passivity.result import Ran, Timed
        from palpate_lab.studies.passivity.words import tables
        from palpate_lab.studies.passivity.work import experiment, summed_up

        begin = time.monotonic()
        found = cast(list[Ran], self.sweeper(console)(experiment, {"run": Axis(range(self.runs))}, self.seed).rows())
        seconds = round(time.monotonic() - begin, 1)
        result: Timed = {**summed_up(found), "seed": self.seed, "seconds": seconds}
        report = [*tables(result), "simulated devices, simulated hands, one axis"]
        return Findings(result, lambda folder: [draw(found, folder)], report)

    def _extracted(self, console: Console) -> Findings:
        from palpate_lab.studies.passivity.extract import MOTIONS, extract, table

        found = extract(MOTIONS, self.seed, self.sweeper(console))
        return Findings(found, lambda _: [], table(found))
