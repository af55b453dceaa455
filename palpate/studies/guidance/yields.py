"""How much of what guidance does to the path error comes from how readily operators give way: `TRAITS["yields"]`.

The trait's number is ours. Here the same operators, with the same noise, have all of it, half of it, and none.
"""

from __future__ import annotations

import numpy as np

from palpate.studies._command import Sweeper
from palpate.studies.guidance.effects import of_the_first
from palpate.studies.guidance.result import Yielded
from palpate.studies.guidance.tasks import TASKS
from palpate.studies.guidance.work import SEED, attempt, judged, task_of
from palpate.sweep import sweep
from palpate.sweep.grid import Point

SHARES = (1.0, 0.5, 0.0)
"""Of their own trait."""
PATHS = tuple(name for name in TASKS if task_of(name).purpose == "path_error_mm")
"""Tasks in which guidance is for the path."""


def yielding(operators: int, seed: int = SEED, sweep: Sweeper = sweep) -> list[Yielded]:
    """A row per task and share, of the first operators of the cohort; as `yields` in docs/json.md."""
    rows, draws = of_the_first(yielded, PATHS, operators, seed, sweep, "yields")
    told: list[Yielded] = []
    for task, mine in rows.items():
        none = np.array([row["none_mm"] for row in mine])
        for share in SHARES:
            guided = np.array([row[_key(share)] for row in mine])
            low, high = np.percentile(guided[draws].mean(axis=1) / none[draws].mean(axis=1) - 1.0, [2.5, 97.5])
            told.append({
                "task": task,
                "share": share,
                "path_error_mm": float(guided.mean()),
                "change": float(guided.mean() / none.mean() - 1.0),
                "change_low": float(low),
                "change_high": float(high),
            })  # fmt: skip
    return told


def yielded(point: Point, seed: int) -> dict[str, float]:
    """Path errors of one operator in one task, the noise the same: the picture alone, and guided by each share."""
    operator, task, cohort = point["operator"], point["task"], point["cohort"]

    def error(condition: str, share: float) -> float:
        return judged(task_of(task), attempt(operator, task, condition, seed, cohort, share))["path_error_mm"]

    return {"none_mm": error("none", 1.0)} | {_key(share): error("guidance", share) for share in SHARES}


def _key(share: float) -> str:
    return f"{100 * share:.0f}_percent_mm"
