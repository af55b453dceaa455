"""``palpate study registration``."""

from __future__ import annotations

from dataclasses import dataclass

from rich.console import Console

from palpate_lab.studies._command import Findings, SweepStudy


@dataclass
class Command(SweepStudy):
    """Registrations with known answers: predicted and simulated errors, wrong markers, partial livers (minutes).

    examples:
      palpate study registration --json registration.json --figures docs/images
      palpate study registration --layouts 4 --trials 20 --clouds 5
    """

    layouts: int = 20
    """Number of layouts of eight markers, each with isotropic and anisotropic errors [-]."""
    trials: int = 300
    """Number of trials with unknown correspondence, wrong markers and hand-eye views, each [-]."""
    clouds: int = 60
    """Number of partial views of each kind [-]."""
    touched: int = 10
    """Number of runs in which the simulated hand touches eight landmarks [-]."""
    chains: int = 20
    """Number of set-ups of tracker, two arms, camera and organ, each with twenty touched places [-]."""
    sessions: int = 100
    """Number of unattended sessions; a fifth as many of each wrong kind [-]."""
    seed: int = 1
    """Seed of all trials [-]."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from palpate_lab.studies.registration import words, work
        from palpate_lab.studies.registration.figures import draw

        found = work.run(
            self.sweeper(console), self.layouts, self.trials, self.clouds, self.touched, self.chains, self.sessions,
            self.seed,
        )  # fmt: skip
        return Findings(
            found, lambda folder: [draw(found, folder)], [words.table(found), words.line_of_real(found["real"])]
        )
