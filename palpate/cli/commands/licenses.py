"""`palpate licenses`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """List Palpate's own licence and those of all packages that it needs here, or write a bill of materials.

    examples:
      palpate licenses
      palpate licenses --sbom palpate.cdx.json
    """

    sbom: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write a bill of materials (CycloneDX 1.5, JSON)."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the list as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print the list, write the files."""
        from rich.table import Table

        from palpate.cli.commands._licenses import bill_of_materials, components

        console = console_for(self.json)
        require_writable(self.json)
        require_writable(self.sbom)
        found = components()
        table = Table(box=None, pad_edge=False)
        for heading in ("package", "version", "licence", "needed by"):
            table.add_column(heading)
        for one in found:
            table.add_row(one.name, one.version or "?", one.licence or "states none", one.needed_by)
        console.print(table)
        silent = [one.name for one in found if not one.licence]
        if silent:
            say(console, f"without a licence in their metadata: {', '.join(silent)}")
        write_json(self.sbom, bill_of_materials(found))
        write_json(self.json, {"components": found})
        return 0
