"""``palpate study drift``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from rich.console import Console
from tyro.conf import Positional

from palpate.base.errors import RecordingError
from palpate_lab.studies._command import Findings, SweepStudy
from palpate_lab.studies.drift.work import RELEASES, Recorded, real_arms, run


@dataclass
class Command(SweepStudy):
    """Tip drift of a released arm by form of gravity model, on plants made from real arms' recordings (minutes).

    examples:
      palpate study drift --json drift.json --figures docs/images
      palpate study drift my_poses.csv --arm mtml

    Without recordings, the study uses the three arms of PALPATE_DATA (docs/calibrate.md).
    """

    recordings: Positional[tuple[Path, ...]] = ()
    """Static recordings of one arm, from which its plant is identified."""
    arm: Literal["mtml", "mtmr"] | None = None
    """Recorded arm; without recordings, only the arms of this side are studied."""
    releases: int = RELEASES
    """Number of poses from which the arm is released."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from palpate_lab.studies.drift.figures import draw
        from palpate_lab.studies.drift.words import table

        if self.releases < 1:
            raise RecordingError(f"{self.releases} releases", mend="give at least one, e.g. --releases 400")
        found = run(self._arms(), self.releases, self.sweeper(console))
        return Findings(
            found,
            lambda folder: [draw(found, folder)],
            [table(found), "simulated arms, made from recordings of real ones"],
        )

    def _arms(self) -> list[Recorded]:
        if not self.recordings:
            return real_arms(self.arm)
        if self.arm is None:
            raise RecordingError("the recorded arm is not specified", mend="add --arm mtml or --arm mtmr")
        return [Recorded(self.recordings[0].stem, self.arm, self.recordings)]
