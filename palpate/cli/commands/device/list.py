"""`palpate device list`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """List the drivers that ship with Palpate, and what each of them needs on this machine.

    examples:
      palpate device list
      palpate device list --json -
    """

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the list as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print the list; returns the exit code."""
        from rich.markup import escape
        from rich.table import Table

        from palpate.devices.libraries import libraries
        from palpate.devices.native import header_folder
        from palpate.devices.open import listed

        console = console_for(self.json)
        require_writable(self.json)
        found = listed()
        table = Table(box=None, pad_edge=False)
        for column in ("driver", "device", "force", "here"):
            table.add_column(column)
        for driver in found:
            here = "ready" if driver.ready else driver.needs
            table.add_row(driver.name, escape(driver.device), "yes" if driver.force else "no", escape(here))
        console.print(table)
        vendors = libraries()
        for one in vendors:
            where = one.found or f"not found in {', '.join(one.places)}"
            say(console, f"{one.file} of the {one.product}: {where}", f"{one.driver}:")
        say(console, "MODULE:CLASS or my_device.so (docs/device.md)", "your own:")
        say(console, str(header_folder() / "driver.h"), "header for C:")
        write_json(self.json, {"drivers": found, "libraries": vendors, "header": str(header_folder() / "driver.h")})
        return 0
