"""`palpate record cut`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, say


@dataclass
class Command:
    """Write a part of a record as a record of its own, bit for bit.

    examples:
      palpate record cut record.mcap --start 60 --end 90 --out touch.mcap
    """

    record: Positional[Path]
    """Record (MCAP), or its folder."""
    out: Annotated[Path, arg(metavar="FILE.mcap")]
    """The record to write."""
    start: Annotated[float, arg(metavar="SECONDS")] = 0.0
    """Time of the first tick."""
    end: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Time before which the part ends; the end of the record when left out."""

    def __call__(self) -> int:
        """Copy the chunks of the part."""
        from palpate.record.edit import copy
        from palpate.record.reader import Record

        copy([self.record / "record.mcap" if self.record.is_dir() else self.record], self.out, self.start, self.end)
        part = Record.open(self.out)
        say(console_for(None), f"{self.out}: {len(part):,} ticks from {part.span[0]:.3f} to {part.span[1]:.3f} s")
        return 0
