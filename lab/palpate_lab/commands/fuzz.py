"""`palpate fuzz`."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from palpate_lab.verify.fuzz import Outcome

_SHOWN = 40  # faults that are printed


@dataclass
class Command:
    """Test contact, energy, scenes, readers of files or network ports with random input; report what violates a rule.

    examples:
      palpate fuzz contact --runs 100000
      palpate fuzz loops --runs 10000 --faults 10000 --out runs/loops
      palpate fuzz ports --cases 1000000
      palpate fuzz datagrams --cases 1000000
      palpate fuzz files --seed 4711 --runs 1
    """

    target: Positional[
        Literal[
            "contact", "datagrams", "files", "grids", "haply", "loops", "models", "packets", "ports", "records",
            "scenes", "tables",
        ]
    ]  # fmt: skip
    """contact: random triangles and tool paths for every contact method; loops: closed loops of the hand in random
    scenes, which may hand out no energy; scenes: moving objects, fixtures and live edits; files: meshes; grids: .npz
    and .nrrd; models: arms, URDFs and gravity models; records: .mcap; tables: CSV of paths and of recordings; packets:
    OpenIGTLink; all damaged; datagrams: forged, replayed and truncated packets at both ends of a link, 1,000 a run
    (docs/network.md); ports: forged messages at the haptic node, the simulated robot, OpenIGTLink and the
    viewer, 100 a run (docs/security.md); haply: messages of Haply's service, 100 a run."""
    kind: str = ""
    """loops: the only kind to draw, for example hard or stick (docs/verification.md); all when left out."""
    runs: int = 2000
    """Number of cases; each case takes the next seed [-]."""
    cases: Annotated[int | None, arg(metavar="MESSAGES")] = None
    """ports, datagrams: number of messages, instead of --runs [-]."""
    seed: int = 0
    """Seed of the first case; `--seed N --runs 1` repeats a fault [-]."""
    faults: int = 20
    """Number of faults after which no further case runs [-]."""
    workers: int | None = None
    """Number of processes; by default one per core. The outcome does not depend on it [-]."""
    resume: Annotated[Path | None, arg(metavar="FILE")] = None
    """Journal of finished cases: continued if the file exists, otherwise begun."""
    out: Annotated[Path | None, arg(metavar="DIR")] = None
    """loops: folder for the worst loop of each kind, reduced to the parts that it needs to fail, as scene files."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the outcome as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Run the cases and print every fault with its seed. Returns 1 after a fault."""
        from palpate_lab.verify.fuzz.campaign import run_on_cores

        console = console_for(self.json)
        require_writable(self.json)
        target = f"{self.target}:{self._checked_kind()}" if self.kind else self.target
        self._take_cases()

        def progress(outcome: Outcome) -> None:
            say(console, f"{outcome.runs:,} of {self.runs:,} cases, {len(outcome.faults)} faults")

        outcome = run_on_cores(target, self.runs, self.seed, progress, self.faults, self.workers, self.resume)
        for fault in outcome.faults[:_SHOWN]:
            say(console, f"seed {fault['seed']}: {fault['what']}", "fault:", "red")
        if len(outcome.faults) > _SHOWN:
            say(console, f"and {len(outcome.faults) - _SHOWN} more; --json writes them all")
        made = ", ".join(f"{name} {n:,}" for name, n in sorted(outcome.counts.items()))
        say(console, f"{outcome.runs:,} cases in {outcome.seconds:.0f} s: {len(outcome.faults)} faults ({made})")
        write_json(self.json, outcome)
        if self.out is not None and self.target == "loops":
            from palpate_lab.verify.fuzz.loops.reduce import write_worst

            for path in write_worst(outcome.faults, self.out):
                say(console, f"wrote {path}")
        return 1 if outcome.faults else 0

    def _checked_kind(self) -> str:
        from palpate_lab.verify.fuzz.loops.kinds import KINDS

        names = [one.__name__ for one in KINDS]
        if self.target != "loops" or self.kind not in names:
            what = f"--kind {self.kind}: not a kind of loop"
            raise PalpateError(what, mend=f"palpate fuzz loops --kind {' or '.join(names)}")
        return self.kind

    def _take_cases(self) -> None:
        """Set the number of runs by the number of messages."""
        if self.cases is None:
            return
        if self.target not in ("ports", "datagrams") or self.cases < 1:
            what = f"--cases {self.cases} of target {self.target}"
            why = "it is a number of messages, from 1, of the targets ports and datagrams"
            raise PalpateError(what, why=why, mend="give --runs")
        messages = import_module(f"palpate_lab.verify.fuzz.{self.target}").MESSAGES
        self.runs = -(-self.cases // messages)
