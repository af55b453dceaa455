"""``palpate study zwidth``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Literal

from rich.console import Console
from tyro.conf import arg

from palpate_lab.studies._command import Findings, SweepStudy
from palpate_lab.studies.zwidth.work import DELAYS, RATES


@dataclass
class Command(SweepStudy):
    """Z-width: the stable walls of a device over stiffness, damping, rate and delay (minutes).

    examples:
      palpate study zwidth
      palpate study zwidth --mass 0.1 --damping 0.2 --friction 0.05 --quantum 2e-5 --hand normal
      palpate study zwidth --rates 500 2000 --delays 0 0.005 --json zwidth.json
    """

    mass: Annotated[float | None, arg(metavar="KG")] = None
    """Moving mass of the device; default: the simulated MTM's."""
    damping: Annotated[float | None, arg(metavar="N*S/M")] = None
    """Viscous friction of the device; default: the simulated MTM's."""
    friction: Annotated[float | None, arg(metavar="N")] = None
    """Dry friction of the device; default: the simulated MTM's."""
    quantum: Annotated[float | None, arg(metavar="M")] = None
    """Position resolution of the device; default: the simulated MTM's."""
    filter: Annotated[float, arg(metavar="HZ")] = 0.0
    """Cut-off of the velocity's low pass; 0: no filter."""
    hand: Literal["relaxed", "light", "normal", "firm", "rigid"] = "relaxed"
    """Hand that holds the device."""
    rates: Annotated[tuple[float, ...], arg(metavar="HZ")] = RATES
    """Rates of the haptic cycle."""
    delays: Annotated[tuple[float, ...], arg(metavar="S")] = DELAYS
    """Delays from the measurement to the force."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from palpate.arm.hands import PRESETS
        from palpate_lab.studies.zwidth.figures import draw
        from palpate_lab.studies.zwidth.words import table, words
        from palpate_lab.studies.zwidth.work import mtm, run

        names = ("mass", "damping", "friction", "quantum")
        given = {name: x for name in names if (x := getattr(self, name)) is not None}
        device = replace(mtm(), **given, filter=self.filter, hand=PRESETS[self.hand])
        found = run(device, self.rates, self.delays, self.sweeper(console))
        return Findings(found, lambda folder: [draw(found, folder)], [table(found), f"simulated: {words(device)}"])
