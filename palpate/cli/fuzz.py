"""`palpate fuzz`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from palpate.console.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from palpate.verify.fuzz import Outcome


@dataclass
class Command:
    """Random meshes, tool paths or mesh files against what must hold whatever comes in.

    examples:
      palpate fuzz contact --runs 100000
      palpate fuzz files --seed 4711 --runs 1
    """

    target: Positional[Literal["contact", "files"]]
    """contact: triangle soups and tool paths through every method; files: spoilt mesh files through the readers."""
    runs: int = 2000
    """Cases; each has the next seed [-]."""
    seed: int = 0
    """Of the first case: a fault is repeated by its seed [-]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the outcome as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Run the cases and name every fault with its seed. Returns 1 when there was one."""
        from palpate.verify.fuzz import run

        console = console_for(self.json)
        require_writable(self.json)
        every = max(self.runs // 10, 1)

        def progress(outcome: Outcome) -> None:
            if outcome.runs % every == 0:
                say(console, f"{outcome.runs:,} of {self.runs:,} cases, {len(outcome.faults)} faults")

        outcome = run(self.target, self.runs, self.seed, progress)
        for fault in outcome.faults:
            say(console, f"seed {fault['seed']}: {fault['what']}", "fault:", "red")
        made = ", ".join(f"{name} {n:,}" for name, n in sorted(outcome.counts.items()))
        say(console, f"{outcome.runs:,} cases in {outcome.seconds:.0f} s: {len(outcome.faults)} faults ({made})")
        write_json(self.json, outcome.to_json())
        return 1 if outcome.faults else 0
