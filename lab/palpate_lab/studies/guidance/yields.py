"""Sensitivity of the guidance effect to the operators' compliance, `TRAITS["yields"]`.

The value of this trait is an assumption of this project. The same operators with the same noise are simulated with the
full trait, with half of it, and without it.
"""

from __future__ import annotations

import numpy as np

from palpate.base.sweep import sweep
from palpate.base.sweep.grid import Point
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.guidance.effects import of_the_first, relative_change
from palpate_lab.studies.guidance.result import Yielded
from palpate_lab.studies.guidance.tasks import TASKS
from palpate_lab.studies.guidance.work import SEED, Assumed, attempt, judged, task_of

SHARES = (1.0, 0.5, 0.0)
"""Scale factors of the trait [-]."""
PATHS = tuple(name for name in TASKS if task_of(name).purpose == "path_error_mm")
"""Tasks whose guidance aims at the path error."""


def yielding(operators: int, seed: int = SEED, sweep: Sweeper = sweep) -> list[Yielded]:
    """One row per task and scale factor for the first operators of the cohort; `yields` in docs/json.md."""
    rows = of_the_first(yielded, PATHS, operators, seed, sweep, "yields")
    out: list[Yielded] = []
    for task, mine in rows.items():
        none = np.array([row["none_mm"] for row in mine])
        for share in SHARES:
            guided = np.array([row[_key(share)] for row in mine])
            less, low, high = relative_change(none, guided)
            out.append({"task": task, "share": share, "path_error_mm": float(guided.mean()), "change": less,
                        "change_low": low, "change_high": high})  # fmt: skip
    return out


def yielded(point: Point, seed: int) -> dict[str, float]:
    """Path errors of one operator in one task with the same noise: without guidance, and per scale factor."""
    operator, task, cohort = point["operator"], point["task"], point["cohort"]

    def error(condition: str, share: float) -> float:
        trial = attempt(operator, task, condition, seed, cohort, Assumed(yields=share))
        return judged(task_of(task), trial)["path_error_mm"]

    return {"none_mm": error("none", 1.0)} | {_key(share): error("guidance", share) for share in SHARES}


def _key(share: float) -> str:
    return f"{100 * share:.0f}_percent_mm"
