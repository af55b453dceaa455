"""`palpate bench loop`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Measure the haptic loop: compute time of a cycle, real-time factor, and lateness in real time.

    examples:
      palpate bench loop
      palpate bench loop --json loop.json
      palpate bench loop --arms 8
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""

    arms: int = 0
    """Pairs that run at once in real time at 1 kHz, in turns with bare loops; then one at 10 kHz. 0: neither. At most
    8, which share the scene and read each other's instruments."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate.scene.pairs import MOST
        from palpate_lab.verify.bench import loop

        if not 0 <= self.arms <= MOST:
            raise PalpateError(f"--arms {self.arms}: must be 0 to {MOST}", mend="e.g. --arms 4")
        console = console_for(self.json)
        require_writable(self.json)
        figures = loop.run(arms=self.arms, on_progress=lambda text: say(console, text))
        say(console, loop.table(figures))
        write_json(self.json, figures)
        return 0
