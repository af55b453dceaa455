"""`palpate bench growth`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import UseAppendAction, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Measure how time and memory grow with duration, triangles, tetrahedra, points, objects, fixtures, pairs, studies.

    examples:
      palpate bench growth --json growth.json
      palpate bench growth --only objects --only fixtures
      palpate bench growth --small --figure growth.png
      palpate bench growth --resume growth.journal

    The whole takes many minutes, and up to 5 GB of memory for 10 million triangles.
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    only: Annotated[UseAppendAction[tuple[str, ...]], arg(metavar="AXIS")] = ()
    """What is to grow; everything when left out."""
    small: bool = False
    """Measure small sizes only."""
    resume: Annotated[Path | None, arg(metavar="FILE")] = None
    """Keep the figures of each size in FILE as soon as they are measured; the same command continues after a stop."""
    figure: Annotated[Path | None, arg(metavar="FILE.png")] = None
    """Draw the growth of all figures, both axes logarithmic."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate_lab.verify.bench import growth

        console = console_for(self.json)
        for file in (self.json, self.figure):
            require_writable(file)
        result = growth.run(
            self.only or tuple(growth.AXES), self.small, self.resume, on_progress=lambda text: say(console, text)
        )
        console.print(growth.table(result))
        if self.figure is not None:
            growth.draw(result, self.figure)
            say(console, str(self.figure), "figure:")
        write_json(self.json, result)
        return 0
