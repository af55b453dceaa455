"""``palpate study zwidth``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Literal

from rich.console import Console
from tyro.conf import arg

from palpate.studies._command import Findings, SweepStudy
from palpate.studies.zwidth.work import DELAYS, RATES


@dataclass
class Command(SweepStudy):
    """Z-width: the stable walls of a device over stiffness, damping, rate and delay (minutes).

    examples:
      palpate study zwidth
      palpate study zwidth --mass 0.1 --damping 0.2 --friction 0.05 --quantum 2e-5 --hand normal
      palpate study zwidth --rates 500 2000 --delays 0 0.005 --json zwidth.json
    """

    mass: Annotated[float | None, arg(metavar="KG")] = None
    """Moving mass of the device; this and the next three: the simulated MTM's when left out."""
    damping: Annotated[float | None, arg(metavar="N*S/M")] = None
    """Its viscous friction."""
    friction: Annotated[float | None, arg(metavar="N")] = None
    """Its dry friction."""
    quantum: Annotated[float | None, arg(metavar="M")] = None
    """Its resolution."""
    filter: Annotated[float, arg(metavar="HZ")] = 0.0
    """Cut-off of the velocity's low pass; 0: none."""
    hand: Literal["relaxed", "light", "normal", "firm", "rigid"] = "relaxed"
    """That holds it."""
    rates: Annotated[tuple[float, ...], arg(metavar="HZ")] = RATES
    """Of the haptic cycle."""
    delays: Annotated[tuple[float, ...], arg(metavar="S")] = DELAYS
    """From the measurement to the force."""

    def study(self, console: Console) -> Findings:
        """Do the work."""
        from palpate.hands import PRESETS
        from palpate.studies.zwidth.figures import draw
        from palpate.studies.zwidth.words import table, words
        from palpate.studies.zwidth.work import mtm, run

        names = ("mass", "damping", "friction", "quantum")
        given = {name: x for name in names if (x := getattr(self, name)) is not None}
        device = replace(mtm(), **given, filter=self.filter, hand=PRESETS[self.hand])
        found = run(device, self.rates, self.delays, self.sweeper(console))
        return Findings(found, lambda folder: [draw(found, folder)], [table(found), f"simulated: {words(device)}"])
