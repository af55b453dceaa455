"""`palpate calibrate export`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.console.output import console_for, say


@dataclass
class Command:
    """A model file as the dVRK's own gravity compensation.

    examples:
      palpate calibrate export mtmr.yaml --out gc-MTMR-28247.json --serial 28247

    A model of the dVRK's form goes over exactly; another is fitted by it over the poses it was trained on, and what
    that loses is told.
    """

    file: Positional[Path]
    """Model file (MODEL.yaml)."""
    out: Annotated[Path, arg(metavar="GC.json")]
    """The dVRK's JSON to write."""
    serial: str = ""
    """Of the arm; the dVRK compares it."""
    force: bool = False
    """Overwrite what is there."""

    def __call__(self) -> int:
        """MODEL.yaml to JSON of the dVRK."""
        from palpate.arm import dvrk_gravity
        from palpate.arm.gravity_model import GravityModel

        lost = dvrk_gravity.save(GravityModel.load(self.file), self.out, self.serial, self.force)
        words = ", ".join(f"{x:.4f}" for x in lost)
        say(console_for(None), f"written: {self.out}   its form loses {words} N m (rms)")
        return 0
