"""`palpate bench contact`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from rich.console import Console
from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Measure the time of a contact query for each shape, mesh size and contact method.

    examples:
      palpate bench contact --json contact.json
      palpate bench contact --quick
      palpate bench contact --huge
      palpate bench contact --organs
      palpate bench contact --organs liver.stl stomach.stl
    """

    files: Annotated[Positional[tuple[Path, ...]], arg(metavar="FILE")] = ()
    """Meshes for --organs; the organs of the test data when left out."""

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    huge: bool = False
    """Measure meshes of ten thousand and of ten million triangles only (2.5 GB of memory, several minutes)."""
    quick: bool = False
    """Measure meshes of ten thousand triangles only (half a minute)."""

    organs: bool = False
    """Measure steps of the force on slides over organ meshes, and over ridges of known radius (a minute)."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate_lab.verify.bench import contact

        console = console_for(self.json)
        require_writable(self.json)
        if self.organs or self.files:
            return self._organs(console)

        def show_row(row: contact.Row) -> None:
            case = f"{row['shape']} {row['triangles']:,} {row['path']} {row['method']}"
            say(console, f"{case}: p50 {row['p50_us']:.2f} us")

        sizes = (contact.SIZES[0], contact.HUGE) if self.huge else contact.SIZES[:1] if self.quick else contact.SIZES
        rows = contact.run(sizes=sizes, on_row=show_row)
        if not (self.huge or self.quick):
            rows += contact.run(("sphere", "torus", "box"), sizes=(100_000,), paths=("tool",), on_row=show_row)
        console.print(contact.table(rows))
        write_json(self.json, rows)
        return 0

    def _organs(self, console: Console) -> int:
        from palpate_lab.verify.bench import organs

        def show_row(row: organs.Slides) -> None:
            say(console, f"{row['mesh']}, {row['depth_mm']:g} mm deep: {row['step_deg']:.1f} deg in one tick")

        rows = organs.run(self.files, show_row)
        if len(rows) == sum(1 for row in rows if row["true_step_deg"] is not None):
            say(console, "no organ meshes: name files, or set PALPATE_DATA")
        console.print(organs.table(rows))
        write_json(self.json, rows)
        return 0
