"""`palpate calibrate export`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, say


@dataclass
class Command:
    """Convert a gravity model to the JSON file of the dVRK's own gravity compensation.

    examples:
      palpate calibrate export mtmr.yaml --out gc-MTMR-28247.json --serial 28247

    A model of the dVRK's form is converted exactly. Any other model is approximated by that form over its training
    poses, and the command prints the torque error.
    """

    file: Positional[Path]
    """Gravity model (MODEL.yaml)."""
    out: Annotated[Path, arg(metavar="GC.json")]
    """The JSON file to write."""
    serial: str = ""
    """Serial number of the arm; the dVRK checks it."""
    force: bool = False
    """Overwrite an existing file."""

    def __call__(self) -> int:
        """Convert the model, print the error, write the JSON file."""
        from palpate.arm import dvrk_gravity
        from palpate.arm.gravity_model import GravityModel

        lost = dvrk_gravity.save(GravityModel.load(self.file), self.out, self.serial, self.force)
        words = ", ".join(f"{x:.4f}" for x in lost)
        say(console_for(None), f"written: {self.out}   rms torque error of the conversion per joint [N m]: {words}")
        return 0
