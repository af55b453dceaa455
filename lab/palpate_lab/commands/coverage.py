"""`palpate coverage`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import UseAppendAction, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Count how often printed intervals hold the truth, and how often data of a wrong form are told.

    examples:
      palpate coverage
      palpate coverage --estimate points --estimate hand --trials 2000
      palpate coverage --trials 2000 --resume runs/coverage

    Each estimate is judged on data with known truth: in the form that it assumes, and in three others
    (docs/verification.md).
    """

    estimate: Annotated[UseAppendAction[tuple[str, ...]], arg(metavar="NAME")] = ()
    """Estimate to judge; may be repeated. Default: all."""
    trials: int = 200
    """Trials of each form [-]."""
    seed: int = 0
    """Seed of the trials [-]."""
    workers: int | None = None
    """Number of processes; by default one per core [-]."""
    resume: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder of finished trials, from which a stopped run continues."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the rows as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Run the trials and print the table. Returns 1 if an asked figure is not met."""
        from palpate.base.errors import PalpateError
        from palpate_lab.verify.coverage.run import names, run, table

        console = console_for(self.json)
        require_writable(self.json)
        if self.trials < 1:
            raise PalpateError(f"--trials {self.trials} is no number of trials", mend="give 1 or more")
        if self.resume is not None:
            self.resume.mkdir(parents=True, exist_ok=True)
        rows = run(self.estimate or names(), self.trials, self.seed, self.workers, self.resume, console)
        console.print(table(rows))
        failed = sum(not row.met for row in rows)
        say(console, f"{len(rows)} forms, {failed} do not meet what is asked (docs/verification.md)", "coverage:")
        write_json(self.json, {"seed": self.seed, "trials": self.trials, "rows": [vars(row) for row in rows]})
        return int(failed > 0)
