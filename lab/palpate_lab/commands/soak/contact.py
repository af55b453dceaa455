"""`palpate soak contact`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, write_json
from palpate_lab.commands.soak._lines import lines

if TYPE_CHECKING:
    from palpate_lab.verify.soak.contact import Soak

LINES = 50  # progress lines over the whole run


@dataclass
class Command:
    """Poke random meshes millions of times, and count how often a tool pops through a surface.

    examples:
      palpate soak contact
      palpate soak contact --passes 100000 --seed 7
      palpate soak contact --passes 2000 --method penalty

    The path of the proxy is checked against every triangle.
    """

    passes: int = 10_000_000
    """Number of pokes, each of about 60 ticks [-]."""
    method: str = "proxy"
    """Contact method; `penalty`, which has no memory, shows how a tool pops through."""
    seed: int = 1
    """Seed; the same seed gives the same meshes and pokes [-]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the count as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Poke, print the count, write the JSON contract. Returns 1 if a tool popped through."""
        from palpate_lab.verify.soak.contact import run, table

        console = console_for(self.json)
        require_writable(self.json)

        def words(so_far: Soak) -> str:
            return f"{so_far.passes:,} passes, {so_far.popped:,} popped through, {so_far.seconds:.0f} s"

        progress = lines(console, LINES, self.passes, lambda so_far: so_far.passes, words)
        try:
            done = run(self.passes, self.method, self.seed, progress)
        except ValueError as error:
            raise PalpateError(str(error)) from error
        console.print(table(done))
        write_json(self.json, done)
        return 1 if done.popped else 0
