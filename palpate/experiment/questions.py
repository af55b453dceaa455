"""Questionnaires: raw NASA-TLX, own items, preference."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from palpate.experiment.model import ExperimentFile

TLX = {
    "mental": ("How mentally demanding was the task?", "very low", "very high"),
    "physical": ("How physically demanding was the task?", "very low", "very high"),
    "temporal": ("How hurried or rushed was the pace of the task?", "very low", "very high"),
    "performance": ("How successful were you in accomplishing the task?", "perfect", "failure"),
    "effort": ("How hard did you have to work to accomplish your level of performance?", "very low", "very high"),
    "frustration": ("How insecure, discouraged, irritated, stressed or annoyed were you?", "very low", "very high"),
}
"""The six scales of NASA-TLX: question, words at 0 and at 100. Low is good on each, on `performance` as well."""


@dataclass(frozen=True)
class Question:
    """A scale from `low` to `high` in equal steps, or a choice of one of `options`."""

    name: str
    words: str
    low: float = 0.0
    high: float = 100.0
    step: float = 5.0
    ends: tuple[str, str] = ("", "")
    options: tuple[str, ...] = ()


def about_condition(experiment: ExperimentFile) -> list[Question]:
    """What is asked after the last trial of each condition."""
    asked = experiment.questionnaires
    found = [Question(f"tlx_{k}", w, 0.0, 100.0, 5.0, (a, b)) for k, (w, a, b) in TLX.items()] if asked.tlx else []
    return found + [
        Question(one.name, one.words, 1.0, float(one.steps), 1.0, (one.low, one.high)) for one in asked.likert
    ]


def at_end(experiment: ExperimentFile, conditions: int) -> list[Question]:
    """What is asked after the last trial; conditions are named by their place, so that nobody learns their names."""
    if not experiment.questionnaires.preference:
        return []
    options = tuple(f"part {k}" for k in range(1, conditions + 1))
    return [Question("preference", "Which part of the experiment did you like best?", options=options)]


def scored(answers: Mapping[str, float | str]) -> dict[str, float]:
    """The numbers of the answers, with `tlx`, the mean of the six scales (raw TLX), where all were answered."""
    found = {name: float(value) for name, value in answers.items() if not isinstance(value, str)}
    scales = [found[f"tlx_{name}"] for name in TLX if f"tlx_{name}" in found]
    return found | ({"tlx": float(np.mean(scales))} if len(scales) == len(TLX) else {})
