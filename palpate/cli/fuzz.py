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
    """Test contact, scenes, readers of files or network ports with random input; report each violated invariant.

    examples:
      palpate fuzz contact --runs 100000
      palpate fuzz files --seed 4711 --runs 1
    """

    target: Positional[Literal["contact", "files", "grids", "models", "packets", "records", "scenes", "tables"]]
    """contact: random triangles and tool paths for every contact method; scenes: moving objects, fixtures and live
    edits; files: meshes; grids: .npz and .nrrd; models: arms, URDFs and gravity models; records: .mcap; tables: CSV of
    paths and of recordings; packets: OpenIGTLink; all damaged."""
    runs: int = 2000
    """Number of cases; each case takes the next seed [-]."""
    seed: int = 0
    """Seed of the first case; `--seed N --runs 1` repeats a fault [-]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the outcome as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Run the cases and print every fault with its seed. Returns 1 after a fault."""
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
        write_json(self.json, outcome)
        return 1 if outcome.faults else 0
