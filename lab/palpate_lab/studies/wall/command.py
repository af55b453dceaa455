"""``palpate study wall``."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from rich.console import Console, RenderableType

from palpate.base.errors import PalpateError
from palpate_lab.studies._command import Findings, SweepStudy


@dataclass
class Command(SweepStudy):
    """The paper's virtual wall: Table 1 and Fig 13 with one hand, 100 other hands, and with passivity (a minute).

    examples:
      palpate study wall --json wall.json
      palpate study wall --hands 1000 --figures docs/images
      palpate study wall --fit
    """

    hands: int = 100
    """Number of other hands, for the confidence intervals and the curve."""
    fit: bool = False
    """Search for the hand and the delay again (minutes) and print them; the study itself uses those of the scene."""

    def study(self, console: Console) -> Findings:
        """Simulate the wall with all hands."""
        from palpate_lab.studies.wall.figures import draw
        from palpate_lab.studies.wall.fit import outcomes, search, words
        from palpate_lab.studies.wall.words import lines, table
        from palpate_lab.studies.wall.work import run

        if not 2 <= self.hands <= 100_000:
            raise PalpateError(f"--hands {self.hands}: must be from 2 to 100000", mend="give e.g. --hands 1000")
        found, traces = run(self.sweeper(console), self.hands)
        report: list[RenderableType] = [table(found), *lines(found, self.hands)]
        if self.fit:
            best, loss = search(on_progress=console.print)
            overshoots = [outcome["overshoot_percent"] for outcome in outcomes(best)]
            found["fit"] = asdict(best) | {"loss": loss, "overshoot_percent": overshoots}
            report.append(words(best, loss, overshoots))
        return Findings(found, lambda folder: draw(traces, found, folder), report)
