"""`palpate soak device`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Step random hands through palpate.Haptics at 500 to 4000 Hz, and count broken caps and forces on wrong input.

    examples:
      palpate soak device
      palpate soak device --seconds 3600 --seed 7
    """

    seconds: float = 60.0
    """Time of each of four loops, as fast as the machine allows [s]."""
    seed: int = 1
    """Seed of the hands [-]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the count as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Step, print the count, write the JSON contract. Returns 1 if anything went wrong."""
        from palpate_lab.verify.soak.device import run

        console = console_for(self.json)
        require_writable(self.json)
        if not 0.0 < self.seconds <= 86_400.0:
            raise PalpateError(f"--seconds {self.seconds:g}: must be above 0 and at most a day", mend="--seconds 60")
        done = run(self.seconds, self.seed, lambda rate: say(console, f"loop of {rate:g} Hz"))
        say(console, f"{done.steps:,} steps, {done.pressed:,} with a force, {done.wrong:,} with wrong input")
        caps = f"{done.above_cap} above the cap, {done.above_rate_cap} above the rate cap"
        say(console, f"{done.not_finite} wrenches not finite, {caps}, {done.force_on_wrong_input} on wrong input")
        write_json(self.json, done)
        return 1 if done.bad else 0
