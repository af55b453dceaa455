"""`palpate record repair`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, say


@dataclass
class Command:
    """Write what is whole of a record without end (run killed, disk full, power lost) as a complete record.

    examples:
      palpate record repair runs/palpation-20260101-120000/record.mcap --out whole.mcap
    """

    record: Positional[Path]
    """Record (MCAP), or its folder."""
    out: Annotated[Path, arg(metavar="FILE.mcap")]
    """The record to write; the damaged one stays."""

    def __call__(self) -> int:
        """Copy the sound chunks and write the index."""
        from palpate.record.edit import copy
        from palpate.record.reader import Record

        source = self.record / "record.mcap" if self.record.is_dir() else self.record
        damaged = Record.open(source)
        copy([source], self.out)
        whole = Record.open(self.out)
        ended = "had its end already" if damaged.complete else "had no end"
        say(
            console_for(None), f"{source} {ended}; {self.out} has its {len(whole):,} ticks, up to {whole.span[1]:.3f} s"
        )
        return 0
