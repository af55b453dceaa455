"""Visual cues alone, with contact that is felt, or none: the same operators with the same noise under each."""

from __future__ import annotations

from typing import cast

import numpy as np

from palpate.studies._command import Sweeper
from palpate.studies.guidance.effects import of_the_first
from palpate.studies.guidance.result import Cued
from palpate.studies.guidance.tasks import TASKS
from palpate.studies.guidance.work import SEED, attempt, judged, task_of
from palpate.sweep import sweep
from palpate.sweep.grid import Point

CONDITIONS = ("none", "visual", "haptics", "visual+haptics")
MEASURES = ("path_error_mm", "mean_force_N", "peak_force_N", "time_s")


def cued(operators: int, seed: int = SEED, sweep: Sweeper = sweep) -> list[Cued]:
    """A row per task and condition, of the first operators of the cohort; as `visual_cues` in docs/json.md."""
    rows, draws = of_the_first(each, TASKS, operators, seed, sweep, "visual cues")
    told = []
    for task, mine in rows.items():
        for condition in CONDITIONS:
            out: dict[str, str | float] = {"task": task, "condition": condition}
            for key in MEASURES:
                none, here = (np.array([row[f"{key} {c}"] for row in mine]) for c in ("none", condition))
                low, high = np.percentile((here - none)[draws].mean(axis=1), [2.5, 97.5])
                out |= {key: float(here.mean()), f"{key}_more_low": float(low), f"{key}_more_high": float(high)}
            told.append(cast(Cued, out))
    return told


def each(point: Point, seed: int) -> dict[str, float]:
    """The measures of one operator in one task under each condition, the noise the same."""
    task = task_of(point["task"])
    told = {c: judged(task, attempt(point["operator"], point["task"], c, seed, point["cohort"])) for c in CONDITIONS}
    return {f"{key} {c}": told[c][key] for c in CONDITIONS for key in MEASURES}
