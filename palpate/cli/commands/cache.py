"""`palpate cache`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """List the user's cache of Palpate, or clear it. Palpate rebuilds deleted entries when it needs them.

    examples:
      palpate cache
      palpate cache --clear
    """

    clear: bool = False
    """Delete all entries."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the list as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Clear the cache if requested, print its entries, write the JSON contract."""
        from datetime import datetime

        from rich.table import Table

        from palpate.base import cache

        console = console_for(self.json)
        require_writable(self.json)
        freed = cache.clear() if self.clear else 0
        entries, folder = cache.entries(), cache.folder()
        table = Table(box=None, pad_edge=False)
        for heading, side in (("entry", "left"), ("MB", "right"), ("last used", "left")):
            table.add_column(heading, justify="right" if side == "right" else "left")
        for one in entries:
            used = datetime.fromtimestamp(one.used).strftime("%Y-%m-%d %H:%M")
            table.add_row(one.path.stem, f"{one.bytes / 2**20:.2f}", used)
        if entries:
            console.print(table)
        total = sum(one.bytes for one in entries)
        if self.clear:
            say(console, f"{freed / 2**20:.1f} MB deleted")
        say(console, f"{folder}: {total / 2**20:.1f} of at most {cache.LIMIT_BYTES / 2**20:.0f} MB")
        rows = [{"entry": one.path.stem, "kind": one.kind, "bytes": one.bytes, "used": one.used} for one in entries]
        write_json(self.json, {"folder": str(folder) if folder else None, "bytes": total,
                               "limit_bytes": cache.LIMIT_BYTES, "freed_bytes": freed, "entries": rows})  # fmt: skip
        return 0
