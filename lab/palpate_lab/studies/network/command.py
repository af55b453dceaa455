"""``palpate study network``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from rich.console import Console
from tyro.conf import arg

from palpate.base.errors import PalpateError
from palpate_lab.studies._command import Findings, SweepStudy


@dataclass
class Command(SweepStudy):
    """Feel a remote surface through emulated networks: energies of both ports, felt against true force.

    examples:
      palpate study network --json network.json
      palpate study network --conditions none --modes model --worlds known --runs 10000
      palpate study network --conditions satellite my_link.csv --runs 1
    """

    conditions: Annotated[tuple[str, ...], arg(metavar="NAME")] = ()
    """Networks by name, or measured traces (FILE.csv, FILE.pcap); default: all by name (docs/network.md)."""
    modes: tuple[str, ...] = ("model", "passivity", "direct")
    """What crosses the network: model, passivity or direct."""
    worlds: tuple[str, ...] = ("known", "unknown")
    """Worlds of the random runs: known has objects whose place, stiffness and friction are wrong; unknown, with the
    mode model, has none of them in the scene."""
    runs: int = 200
    """Number of random networks, worlds and hands for each mode."""
    hours: float = 1.0
    """Virtual time in which false alarms of outages are counted on each network [h]."""
    seed: int = 0
    """First seed of the random runs."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from palpate.session.network import NAMES, network
        from palpate_lab.studies.network.figures import draw
        from palpate_lab.studies.network.result import StudyResult
        from palpate_lab.studies.network.words import tables
        from palpate_lab.studies.network.work import MODES, UNKNOWN, WORLDS, alarms, conditions, moving, random_runs

        for mode in self.modes:
            if mode not in MODES:
                mend = "give one or more of: " + ", ".join(MODES)
                raise PalpateError(f"--modes {mode}: there is no such mode", mend=mend)
        for world in self.worlds:
            if world not in WORLDS:
                mend = "give one or both of: " + ", ".join(WORLDS)
                raise PalpateError(f"--worlds {world}: there are no such worlds", mend=mend)
        if not 1 <= self.runs <= 1_000_000:
            raise PalpateError(f"--runs {self.runs}: must be from 1 to 1000000", mend="give e.g. --runs 200")
        if not 0.0 < self.hours <= 1000.0:
            raise PalpateError(f"--hours {self.hours:g}: must be above 0, up to 1000 h", mend="give e.g. --hours 1")
        names = self.conditions or NAMES
        for name in names:
            network(name)  # a wrong name is told before the computation starts
        sweep = self.sweeper(console)
        rows = conditions(names, self.modes, sweep, self.seed)
        felt = (*(self.modes if "known" in self.worlds else ()),
                *((UNKNOWN,) if "unknown" in self.worlds and "model" in self.modes else ()))  # fmt: skip
        random, ran = random_runs(self.runs, felt, sweep, self.seed)
        worlds = moving(sweep, self.seed) if "model" in self.modes else []
        told = alarms([name for name in names if "outage" not in name], self.hours, sweep, self.seed)
        found: StudyResult = {"simulated": True, "seed": self.seed, "conditions": rows, "random": random,
                              "moving": worlds, "alarms": told}  # fmt: skip
        report = [*tables(found), "simulated hands, links and instruments, in virtual time (docs/network-figures.md)"]
        return Findings(found, lambda folder: [draw(found, ran, folder)], report)
