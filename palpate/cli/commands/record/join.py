"""`palpate record join`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, say


@dataclass
class Command:
    """Write several records of one session, one after the other, as one record.

    examples:
      palpate record join first.mcap second.mcap --out both.mcap
    """

    records: Positional[tuple[Path, ...]]
    """Records (MCAP), the earliest first; each begins after the end of the one before."""
    out: Annotated[Path, arg(metavar="FILE.mcap")]
    """The record to write. The scene is that of the first."""

    def __call__(self) -> int:
        """Copy the chunks of all records."""
        from palpate.record.edit import copy
        from palpate.record.reader import Record

        copy(self.records, self.out)
        whole = Record.open(self.out)
        say(console_for(None), f"{self.out}: {len(whole):,} ticks from {whole.span[0]:.3f} to {whole.span[1]:.3f} s")
        return 0
