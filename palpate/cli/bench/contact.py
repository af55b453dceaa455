"""`palpate bench contact`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.console.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Contact queries: the table of shapes and methods.

    examples:
      palpate bench contact --json contact.json
      palpate bench contact --quick
      palpate bench contact --huge
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    huge: bool = False
    """Ten million triangles instead (2.5 GB of memory, minutes)."""
    quick: bool = False
    """Ten thousand triangles alone (half a minute)."""

    def __call__(self) -> int:
        """Measure, print the table, write the JSON contract."""
        from palpate.verify.bench import contact

        console = console_for(self.json)
        require_writable(self.json)

        def told(row: contact.Row) -> None:
            case = f"{row['shape']} {row['triangles']:,} {row['path']} {row['method']}"
            say(console, f"{case}: p50 {row['p50_us']:.2f} us")

        sizes = (contact.HUGE,) if self.huge else contact.SIZES[:1] if self.quick else contact.SIZES
        rows = contact.run(sizes=sizes, on_row=told)
        if not (self.huge or self.quick):
            rows += contact.run(("sphere", "torus", "box"), sizes=(100_000,), paths=("tool",), on_row=told)
        console.print(contact.table(rows))
        write_json(self.json, rows)
        return 0
