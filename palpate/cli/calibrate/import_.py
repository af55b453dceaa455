"""`palpate calibrate import`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.console.output import console_for, say


@dataclass
class Command:
    """A dVRK's own gravity compensation (gc-MTMR-xxxxx.json) as a model file of Palpate.

    examples:
      palpate calibrate import gc-MTMR-28247.json --out mtmr.yaml
    """

    file: Positional[Path]
    """The dVRK's JSON."""
    out: Annotated[Path, arg(metavar="MODEL.yaml")]
    """The model file to write."""
    force: bool = False
    """Overwrite what is there."""

    def __call__(self) -> int:
        """JSON of the dVRK to MODEL.yaml."""
        from palpate.arm import dvrk_gravity

        model = dvrk_gravity.load(self.file)
        model.save(self.out, self.force)
        say(console_for(None), f"model: {self.out}   ({model.arm}, serial {model.notes['serial'] or 'unknown'})")
        return 0
