"""`palpate soak tissue`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, write_json
from palpate_lab.commands.soak._lines import lines

if TYPE_CHECKING:
    from palpate_lab.verify.soak.tissue import TissueSoak

LINES = 20  # progress lines over the whole run


@dataclass
class Command:
    """Poke, slide on and grasp soft bodies thousands of times, and count what must not happen.

    examples:
      palpate soak tissue
      palpate soak tissue --pokes 500 --seed 7

    The tool turns back at up to 3 N, slides and grasps at up to 1 m/s; 2 % of the actions go on up to 20 N.
    """

    pokes: int = 10_000
    """Number of pokes, slides and grasps [-]."""
    seed: int = 1
    """Seed; the same seed gives the same actions [-]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the counts as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Run, print the counts, write the JSON contract. Returns 1 if anything failed."""
        from palpate_lab.verify.soak.tissue import run, table

        console = console_for(self.json)
        require_writable(self.json)

        def words(so_far: TissueSoak) -> str:
            return f"{so_far.actions:,} actions, {so_far.failures:,} failures, {so_far.seconds:.0f} s"

        progress = lines(console, LINES, self.pokes, lambda so_far: so_far.actions, words)
        try:
            done = run(self.pokes, self.seed, progress)
        except ValueError as error:
            raise PalpateError(str(error)) from error
        console.print(table(done))
        write_json(self.json, done)
        return 1 if done.failures else 0
