"""`palpate calibrate import`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, say


@dataclass
class Command:
    """Convert the dVRK's own gravity compensation (gc-MTMR-xxxxx.json) to a gravity model of Palpate.

    examples:
      palpate calibrate import gc-MTMR-28247.json --out mtmr.yaml
    """

    file: Positional[Path]
    """The dVRK's JSON file."""
    out: Annotated[Path, arg(metavar="MODEL.yaml")]
    """The model file to write."""
    force: bool = False
    """Overwrite an existing file."""

    def __call__(self) -> int:
        """Convert the JSON file and write the model."""
        from palpate.arm import dvrk_gravity

        model = dvrk_gravity.load(self.file)
        model.save(self.out, self.force)
        say(console_for(None), f"model: {self.out}   ({model.arm}, serial {model.notes['serial'] or 'unknown'})")
        return 0
