"""`palpate bench tissue`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import UseAppendAction, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json

Figure = Literal[
    "ticks",
    "threads",
    "realtime",
    "layers",
    "large-strain",
    "stiffening",
    "lump",
    "finding",
    "viscosity",
    "smoothness",
    "stillness",
    "energy",
    "kernels",
    "theories",
    "mujoco",
]


@dataclass
class Command:
    """Measure soft bodies: time of a tick, force against closed forms and references, smoothness, energy, MuJoCo.

    examples:
      palpate bench tissue
      palpate bench tissue --only viscosity --only lump
      palpate bench tissue --json tissue.json
    """

    only: Annotated[UseAppendAction[tuple[Figure, ...]], arg(metavar="NAME")] = ()
    """Run only this figure; give the option several times for several figures."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate_lab.verify.bench import tissue

        console = console_for(self.json)
        require_writable(self.json)
        figures = tissue.run(self.only, on_progress=lambda name: say(console, f"{name} ..."))
        console.print(tissue.table(figures))
        write_json(self.json, figures)
        return 0
