"""Visual cues, contact forces, both, or neither: the same operators with the same noise under each condition."""

from __future__ import annotations

from typing import cast

import numpy as np

from palpate.base.arrays.intervals import interval
from palpate.base.sweep import sweep
from palpate.base.sweep.grid import Point
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.guidance.effects import of_the_first
from palpate_lab.studies.guidance.result import Cued
from palpate_lab.studies.guidance.tasks import TASKS
from palpate_lab.studies.guidance.work import SEED, attempt, judged, task_of

CONDITIONS = ("none", "visual", "haptics", "visual+haptics")
MEASURES = ("path_error_mm", "mean_force_N", "peak_force_N", "time_s")


def cued(operators: int, seed: int = SEED, sweep: Sweeper = sweep) -> list[Cued]:
    """One row per task and condition for the first operators of the cohort; `visual_cues` in docs/json.md."""
    trials = of_the_first(each, TASKS, operators, seed, sweep, "visual cues")
    rows: list[Cued] = []
    for task, mine in trials.items():
        for condition in CONDITIONS:
            out: dict[str, str | float] = {"task": task, "condition": condition}
            for key in MEASURES:
                none, felt = (np.array([row[f"{key} {c}"] for row in mine]) for c in ("none", condition))
                low, high = interval(np.mean, felt - none)
                out |= {key: float(felt.mean()), f"{key}_more_low": float(low), f"{key}_more_high": float(high)}
            rows.append(cast(Cued, out))
    return rows


def each(point: Point, seed: int) -> dict[str, float]:
    """Measures of one operator in one task under each condition, with the same noise."""
    task = task_of(point["task"])
    measured = {
        c: judged(task, attempt(point["operator"], point["task"], c, seed, point["cohort"])) for c in CONDITIONS
    }
    return {f"{key} {c}": measured[c][key] for c in CONDITIONS for key in MEASURES}
