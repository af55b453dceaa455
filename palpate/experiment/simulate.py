"""A whole experiment by simulated participants, on all cores."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from rich.console import Console

from palpate.base.sweep import Axis, sweep
from palpate.base.sweep.grid import Point
from palpate.experiment.model import ExperimentFile
from palpate.experiment.run import run_participant
from palpate.experiment.simulated import SimulatedParticipant
from palpate.experiment.study import Study


def simulated_people(n: int) -> tuple[str, ...]:
    """Pseudonyms of n simulated participants."""
    return tuple(f"S{i:0{max(2, len(str(n)))}d}" for i in range(1, n + 1))


def simulate(
    experiment: ExperimentFile, n: int, folder: Path, workers: int | None = None, console: Console | None = None
) -> Study:
    """Run an experiment with n simulated participants, or continue it; returns it.

    Raises:
        PalpateError: as `Study` and `run_participant`.
    """
    study = Study(experiment, folder, simulated_people(n), simulated=True)
    todo = [i for i in range(n) if len(study.progress(study.people[i]).ended) < len(study.plan[study.people[i]])]
    if workers == 1 or len(todo) < 2:
        for i in todo:
            _run(study, i)
    else:
        work = partial(_participant, experiment=experiment, folder=folder, n=n)
        sweep(
            work, {"participant": Axis(todo)}, experiment.seed, workers=workers, console=console, title="participants"
        )
    return study


def _participant(point: Point, seed: int, *, experiment: ExperimentFile, folder: Path, n: int) -> dict[str, int]:
    """One participant, in a worker. The seed of the sweep is unused, because the plan has its own."""
    study = Study(experiment, folder, simulated_people(n), simulated=True)
    _run(study, int(point["participant"]))
    return {"trials": len(study.plan[study.people[0]])}


def _run(study: Study, index: int) -> None:
    run_participant(study, study.people[index], SimulatedParticipant(index, study.experiment.seed, study.settings))
