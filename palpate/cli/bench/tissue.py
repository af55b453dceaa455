"""`palpate bench tissue`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.console.output import console_for, require_writable, write_json


@dataclass
class Command:
    """Measure the time of soft bodies in a tick, and the force on a layer against its closed form and MuJoCo.

    examples:
      palpate bench tissue
      palpate bench tissue --json tissue.json
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate.verify.bench import tissue

        console = console_for(self.json)
        require_writable(self.json)
        figures = tissue.run()
        console.print(tissue.table(figures))
        write_json(self.json, figures)
        return 0
