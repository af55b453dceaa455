"""``palpate study certificate``."""

from __future__ import annotations

from dataclasses import dataclass

from rich.console import Console

from palpate_lab.studies._command import Findings, SweepStudy


@dataclass
class Command(SweepStudy):
    """Predicted and simulated largest stiffness of random devices, and of the scenes' arms (minutes).

    examples:
      palpate study certificate
      palpate study certificate --devices 50 --json certificate.json --figures docs/images
      palpate study certificate --swings 500
    """

    devices: int = 1000
    """Number of random devices [-]."""
    seed: int = 1
    """Seed of the random devices; the same seed gives the same devices [-]."""
    swings: int = 0
    """Judge this number of random linear loops instead, whose eigenvalues are known, as oscillating or not [-]."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        if self.swings:
            return self._swings(console)
        from palpate_lab.studies.certificate import arms, work
        from palpate_lab.studies.certificate.figures import draw

        sweep = self.sweeper(console)
        rows = sweep(work.judged, {"device": range(self.devices)}, self.seed, title="devices").rows()
        walls = arms.run(sweep)
        summary = work.summary(rows)
        values = {"simulated": True, "seed": self.seed, **summary, "devices": rows, "arms": walls}
        return Findings(values, lambda folder: [draw(rows, folder)], [work.table(summary), arms.table(walls)])

    def _swings(self, console: Console) -> Findings:
        from palpate_lab.studies.certificate.swings import swings, table

        found = swings(self.swings, self.seed, self.sweeper(console))
        return Findings(found, lambda _: [], table(found))
