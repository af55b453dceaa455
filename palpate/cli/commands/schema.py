"""`palpate schema`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg


@dataclass
class Command:
    """Print the JSON Schema of scene files, which lets an editor complete and check them.

    examples:
      palpate schema > scene.schema.json
    """

    out: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the schema to a file instead of the standard output."""

    def __call__(self) -> int:
        """Print the schema, or write it to a file."""
        from palpate.cli.terminal.output import write_text
        from palpate.scene.schema import schema_text

        if self.out is None:
            print(schema_text(), end="")
        else:
            write_text(self.out, schema_text())
        return 0
