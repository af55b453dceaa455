"""Experiments with people or simulated participants: a plan frozen beforehand, trials that survive, one analysis.

experiment = ExperimentFile.load("examples/experiment_haptics.yaml")
study = simulate(experiment, 12, Path("runs/haptics-simulated"))
found = found_in(study)
print(found.effects[0])
"""

from palpate.experiment.course import Course, Outcome, Referee, judge
from palpate.experiment.model import MEASURES, ExperimentFile
from palpate.experiment.outcome import Found, found_in
from palpate.experiment.plan import PlannedTrial, plan_of
from palpate.experiment.run import Participant, run_participant
from palpate.experiment.simulate import simulate
from palpate.experiment.simulated import SimulatedParticipant
from palpate.experiment.study import Study

__all__ = [
    "MEASURES",
    "Course",
    "ExperimentFile",
    "Found",
    "Outcome",
    "Participant",
    "PlannedTrial",
    "Referee",
    "SimulatedParticipant",
    "Study",
    "found_in",
    "judge",
    "plan_of",
    "run_participant",
    "simulate",
]
