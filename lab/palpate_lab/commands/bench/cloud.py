"""`palpate bench cloud`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Measure the time from a depth camera's frame to the force, while the loop runs at 1 kHz in the same process.

    examples:
      palpate bench cloud
      palpate bench cloud --json cloud.json
      palpate bench cloud --figure cloud.png
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    seconds: float = 10.0
    """Duration of the run with frames, and of the control without [s]."""
    points: int = 300_000
    """Points of a frame [-]."""
    figure: Annotated[Path | None, arg(metavar="FILE.png")] = None
    """Draw the forces on moving surfaces, with and without the velocity between frames."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate_lab.verify.bench import cloud

        console = console_for(self.json)
        for file in (self.json, self.figure):
            require_writable(file)
        figures = cloud.run(self.seconds, self.points)
        console.print(cloud.table(figures))
        if self.figure is not None:
            from palpate_lab.verify.bench import cloud_plot

            cloud_plot.draw(self.figure)
            say(console, str(self.figure), "figure:")
        write_json(self.json, figures)
        return 0
