"""``palpate study laws``."""

from __future__ import annotations

from dataclasses import asdict, dataclass

from rich.console import Console

from palpate.studies._command import Findings, SweepStudy


@dataclass
class Command(SweepStudy):
    """What the hand feels of a spring by each control law, slow and fast, with wrong masses (a minute).

    examples:
      palpate study laws
      palpate study laws --json laws.json --figures docs/images
    """

    def study(self, console: Console) -> Findings:
        """Do the work."""
        from palpate.studies.laws.figures import draw
        from palpate.studies.laws.work import NOTICED, run, table, trace

        found = run(self.sweeper(console))
        traces = [trace(law, f) for f in (0.5, 4.0) for law in ("stiffness", "admittance")]
        result = {"simulated": True, "leader": "mtm_right", "noticed": NOTICED, "outcomes": [asdict(o) for o in found]}
        return Findings(
            result,
            lambda folder: [draw(found, traces, folder)],
            [table(found), "simulated leader (mtm_right), simulated hand"],
        )
