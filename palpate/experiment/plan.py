"""The plan of an experiment: every trial of every participant, made before the first one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.experiment.model import ExperimentFile
from palpate.experiment.order import orders


@dataclass(frozen=True)
class PlannedTrial:
    """One trial of one participant."""

    number: int
    """Place in the participant's order, from 1."""
    task: str
    condition: str
    repetition: int
    """From 1; 0 for familiarisation, which counts in no analysis."""
    block: int
    """Place of the condition in the participant's order, from 1."""
    seed: int
    """Of all random numbers in the trial."""
    rest: bool = False
    """True if a break precedes the trial."""
    last: bool = False
    """True for the last trial of its condition, after which the questions of a condition are asked."""


Plan = dict[str, tuple[PlannedTrial, ...]]
"""Trials in order, by participant."""


def plan_of(experiment: ExperimentFile, people: tuple[str, ...]) -> Plan:
    """The plan: the same file and people give the same plan; a participant's does not depend on later ones."""
    names = tuple(experiment.conditions)
    rows = orders(names, len(people), experiment.order == "latin-square", experiment.seed)
    return {who: _trials(experiment, i, order) for i, (who, order) in enumerate(zip(people, rows, strict=True))}


def _trials(experiment: ExperimentFile, index: int, order: tuple[str, ...]) -> tuple[PlannedTrial, ...]:
    rng = np.random.default_rng([experiment.seed, 2, index])
    found: list[PlannedTrial] = []

    def add(task: str, condition: str, repetition: int, block: int, last: bool = False) -> None:
        counted, every = len(found), experiment.breaks.every
        rest = every > 0 and counted > 0 and counted % every == 0
        seed = int(rng.integers(2**31))
        found.append(PlannedTrial(counted + 1, task, condition, repetition, block, seed, rest, last))

    for task in experiment.tasks:
        for _ in range(experiment.familiarisation):
            add(task, order[0], 0, 0)
    for block, condition in enumerate(order, 1):
        pairs = [(task, k) for k in range(1, experiment.repetitions + 1) for task in experiment.tasks]
        drawn = [pairs[k] for k in rng.permutation(len(pairs))]
        for k, (task, repetition) in enumerate(drawn):
            add(task, condition, repetition, block, k == len(drawn) - 1)
    return tuple(found)
