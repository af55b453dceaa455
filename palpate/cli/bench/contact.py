"""`palpate bench contact`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.console.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Measure the time of a contact query for each shape, mesh size and contact method.

    examples:
      palpate bench contact --json contact.json
      palpate bench contact --quick
      palpate bench contact --huge
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    huge: bool = False
    """Measure meshes of ten million triangles only (2.5 GB of memory, several minutes)."""
    quick: bool = False
    """Measure meshes of ten thousand triangles only (half a minute)."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate.verify.bench import contact

        console = console_for(self.json)
        require_writable(self.json)

        def show_row(row: contact.Row) -> None:
            case = f"{row['shape']} {row['triangles']:,} {row['path']} {row['method']}"
            say(console, f"{case}: p50 {row['p50_us']:.2f} us")

        sizes = (contact.HUGE,) if self.huge else contact.SIZES[:1] if self.quick else contact.SIZES
        rows = contact.run(sizes=sizes, on_row=show_row)
        if not (self.huge or self.quick):
            rows += contact.run(("sphere", "torus", "box"), sizes=(100_000,), paths=("tool",), on_row=show_row)
        console.print(contact.table(rows))
        write_json(self.json, rows)
        return 0
