"""`palpate experiment`."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal import HOST, PORT
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.experiment import ExperimentFile, Found, Study


@dataclass
class Command:
    """Run an experiment with people or simulated participants: plan, trials, questionnaires, analysis, report.

    examples:
      palpate experiment examples/experiment_haptics.yaml --simulate 12
      palpate experiment examples/experiment_haptics.yaml --participant P01
      palpate experiment examples/experiment_haptics.yaml --power --json power.json

    Without --participant, --simulate and --power it checks the file, says what was done so far, and analyses it. Every
    trial is a record. The same command continues after any end: what ended counts once, the rest is repeated.
    """

    file: Positional[Path]
    """Experiment file (YAML; docs/experiments.md)."""
    participant: Annotated[str | None, arg(metavar="P")] = None
    """Run the trials of this person in the viewer, from where they ended."""
    simulate: Annotated[int | None, arg(metavar="N")] = None
    """Run the experiment with N simulated participants."""
    power: bool = False
    """Say how many participants find the differences that simulated ones show; simulates 12 without --simulate."""
    trust: bool = False
    """Let the drivers that the scenes name run, although they are not installed: code beside the scene files."""
    out: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder of the data; default: runs/NAME, and runs/NAME-simulated for simulated participants."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Processes of a simulation; one per core when left out."""
    port: int = PORT
    """Port of the viewer; the next free one when it is taken."""
    host: str = HOST
    """Address on which the viewer listens."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the results as JSON (docs/json/experiment.md); - for the standard output."""

    def __call__(self) -> int:
        """Run what is asked for, analyse, and write the report; returns the exit code."""
        from palpate.experiment import ExperimentFile, Study, found_in, simulate
        from palpate.experiment.analysis import require_model

        self._refuse_contradictions()
        console = console_for(self.json)
        require_writable(self.json)
        experiment = ExperimentFile.load(self.file)
        if self.participant is not None or self.simulate is not None or self.power:
            require_model()  # before hours of trials, not after them
        if self.participant is not None:
            return self._person(experiment, console)
        if self.power and len(experiment.conditions) < 2:
            mend = "add a condition, or leave --power out"
            raise PalpateError("--power compares conditions, and there is one", where=experiment.file, mend=mend)
        count = self.simulate or (12 if self.power else None)
        if count is not None:
            say(console, f"{count} simulated participants, which say nothing about people")
            study = simulate(experiment, count, self._folder(experiment, True), self.workers, console)
        else:
            study = Study(experiment, self._folder(experiment, False), frozen=False, trust=self.trust)
        self._present(found_in(study, self.power), console)
        return 0

    def _person(self, experiment: ExperimentFile, console: Console) -> int:
        from palpate.cli.terminal.view import free_port, require_viewer
        from palpate.experiment import Study, found_in
        from palpate.experiment.person import run_person

        require_viewer()
        study = Study(experiment, self._folder(experiment, False), frozen=False, trust=self.trust)
        study.require(str(self.participant))
        study.freeze()
        run_person(
            study, str(self.participant), self.host, free_port(self.port, self.host), lambda line: say(console, line)
        )
        self._present(found_in(study), console)
        return 0

    def _present(self, found: Found, console: Console) -> None:
        """Print the state and the effects; write the report, the shared table and the JSON."""
        from rich.table import Table

        from palpate.experiment.report import write_report
        from palpate.experiment.table import write_shared

        study = found.study
        _say_state(study, found, console)
        values = found.json()
        if found.effects:
            shown = Table(box=None, pad_edge=False)
            for name in ("measure", "condition", "difference", "95 %", "d_z", "p (Holm)"):
                shown.add_column(name)
            for one in found.effects:
                shown.add_row(
                    one.measure, one.condition, _number(one.difference), f"{_number(one.low)} to {_number(one.high)}",
                    _number(one.dz), _number(one.p_holm),
                )  # fmt: skip
            console.print(shown)
        if found.rows:
            values["report"] = str(write_report(found, study.folder / "report.html"))
            values["data"] = str(write_shared(study, found.rows, study.folder / "trials.csv"))
            say(console, values["report"], "report")
            say(console, values["data"], "data, without pseudonyms")
        for condition in study.experiment.conditions:
            enough = [one.participants for one in found.power if one.condition == condition and one.power >= 0.8]
            if enough:
                say(console, f"power of 80 % for {condition}: {min(enough)} participants (simulated)")
            elif drawn := [one for one in found.power if one.condition == condition]:
                most = max(drawn, key=lambda one: one.participants)
                words = f"{100 * most.power:.0f} % with {most.participants} participants (simulated)"
                say(console, f"no power of 80 % for {condition}: {words}")
        if self.power and not found.power:
            primary = study.experiment.measures[0]
            say(console, f"no power: fewer than two participants have {primary} in every condition")
        write_json(self.json, {"report": None, "data": None} | values)

    def _folder(self, experiment: ExperimentFile, simulated: bool) -> Path:
        return self.out or Path("runs") / (experiment.stem + ("-simulated" if simulated else ""))

    def _refuse_contradictions(self) -> None:
        if self.participant is not None and (self.simulate is not None or self.power):
            other = "--simulate" if self.simulate is not None else "--power"
            raise PalpateError(f"--participant and {other} contradict each other", mend="give one of them")
        for name, value in (("--simulate", self.simulate), ("--workers", self.workers)):
            if value is not None and not 1 <= value <= 1000:
                raise PalpateError(f"{name} {value}: must be from 1 to 1000", mend=f"give e.g. {name} 12")
        if self.power and self.simulate == 1:
            raise PalpateError("--power needs the spread between participants, and one has none", mend="--simulate 12")


def _say_state(study: Study, found: Found, console: Console) -> None:
    e, state = study.experiment, found.state
    planned, ended = sum(r["planned"] for r in state), sum(r["ended"] for r in state)
    say(console, f"{e.title}: {len(state)} participants, {len(e.conditions)} conditions, {len(e.tasks)} tasks")
    lost = sum(r["aborted"] + r["lost"] for r in state)
    repeated = f"; {lost} attempts were aborted or lost, and repeated" if lost else ""
    say(console, f"{ended} of {planned} trials ended{repeated}")


def _number(value: float) -> str:
    return f"{value:.3g}" if isfinite(value) else "-"
