"""``palpate study laws``."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from rich.console import Console

from palpate_lab.studies._command import Findings, SweepStudy


@dataclass
class Command(SweepStudy):
    """Impedance at the hand of a rendered spring, by control law and speed, also with wrong masses (a minute).

    examples:
      palpate study laws
      palpate study laws --json laws.json --figures docs/images
    """

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from palpate_lab.studies.laws.figures import draw
        from palpate_lab.studies.laws.work import NOTICED, run, table, trace

        found = run(self.sweeper(console))
        traces = [trace(law, f) for f in (0.5, 4.0) for law in ("stiffness", "admittance")]
        result = {"simulated": True, "leader": "mtm_right", "noticed": NOTICED, "outcomes": [asdict(o) for o in found]}
        return Findings(
            result,
            lambda folder: [draw(found, traces, folder)],
            [table(found), "simulated leader (mtm_right), simulated hand"],
        )
