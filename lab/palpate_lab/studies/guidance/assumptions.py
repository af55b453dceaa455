"""``palpate study guidance --assumptions``: how the results follow from two choices of this project.

The choices are the stiffness of the fixtures that guide along a path, and the `care` of the operators, who slow down in
proportion to the error that they see. The same operators with the same noise are simulated with other choices.
"""

from __future__ import annotations

import numpy as np
from rich.console import RenderableType
from rich.table import Table

from palpate.base.sweep import sweep
from palpate.base.sweep.grid import Point
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.guidance.effects import hedges_g, of_the_first, relative_change
from palpate_lab.studies.guidance.result import Assumptions, Cared, Stiffened
from palpate_lab.studies.guidance.tasks import TASKS
from palpate_lab.studies.guidance.work import SEED, Assumed, attempt, judged, task_of
from palpate_lab.studies.guidance.yields import PATHS

STIFFNESSES = (100.0, 300.0, 600.0, 1000.0, 1500.0)
"""Tried stiffnesses of the fixtures [N/m]; 600 N/m is that of the study."""
FIRST = 20
"""Number of operators, the first of the cohort."""


def assumptions(operators: int, seed: int = SEED, sweep: Sweeper = sweep) -> Assumptions:
    """Both comparisons, for the first operators of the cohort; docs/json.md has the keys."""
    few = min(operators, FIRST)
    return {
        "simulated": True,
        "operators": few,
        "seed": seed,
        "stiffness": _stiffened(few, seed, sweep),
        "care": _cared(few, seed, sweep),
    }


def _stiffened(operators: int, seed: int, sweep: Sweeper) -> list[Stiffened]:
    rows = of_the_first(stiffened, PATHS, operators, seed, sweep, "stiffness")
    out: list[Stiffened] = []
    for task, mine in rows.items():
        none = np.array([row["none_mm"] for row in mine])
        for K in STIFFNESSES:
            guided = np.array([row[f"{K:g}_mm"] for row in mine])
            less, low, high = relative_change(none, guided)
            out.append({"task": task, "stiffness_N_per_m": K, "path_error_mm": float(guided.mean()), "change": less,
                        "change_low": low, "change_high": high})  # fmt: skip
    return out


def stiffened(point: Point, seed: int) -> dict[str, float]:
    """Path errors of one operator in one task with the same noise: without guidance, and by stiffness."""
    task = task_of(point["task"])

    def error(condition: str, assumed: Assumed) -> float:
        trial = attempt(point["operator"], point["task"], condition, seed, point["cohort"], assumed)
        return judged(task, trial)["path_error_mm"]

    guided = {f"{K:g}_mm": error("guidance", Assumed(stiffness=K)) for K in STIFFNESSES}
    return {"none_mm": error("none", Assumed())} | guided


def _cared(operators: int, seed: int, sweep: Sweeper) -> list[Cared]:
    rows = of_the_first(cared, TASKS, operators, seed, sweep, "care")
    out: list[Cared] = []
    for task, mine in rows.items():
        times = {key: np.array([row[key] for row in mine]) for key in mine[0] if key.endswith("_s")}
        g, without = (float(hedges_g(times[f"none {c:g}_s"], times[f"guidance {c:g}_s"])) for c in (1.0, 0.0))
        out.append({"task": task, "hedges_g": g, "hedges_g_without_care": without})
    return out


def cared(point: Point, seed: int) -> dict[str, float]:
    """Times of one operator in one task with the same noise: with and without guidance, with and without care."""
    task, found = task_of(point["task"]), {}
    for condition in ("none", "guidance"):
        for care in (1.0, 0.0):
            trial = attempt(point["operator"], point["task"], condition, seed, point["cohort"], Assumed(care=care))
            found[f"{condition} {care:g}_s"] = judged(task, trial)["time_s"]
    return found


def tables(found: Assumptions) -> list[RenderableType]:
    """The two comparisons as tables for a terminal."""
    stiffness = Table(box=None, pad_edge=False, title_justify="left",
                      title=f"path error, guidance against none, {found['operators']} operators")  # fmt: skip
    care = Table(box=None, pad_edge=False, title_justify="left", title="Hedges' g of time, guidance against none")
    for table, columns in ((stiffness, [f"{K:g} N/m" for K in STIFFNESSES]), (care, ["with care", "without"])):
        table.add_column("task")
        for column in columns:
            table.add_column(column, justify="right")
    for task in PATHS:
        mine = [row["change"] for row in found["stiffness"] if row["task"] == task]
        stiffness.add_row(task, *(f"{100 * less:+.0f} %" for less in mine))
    for row in found["care"]:
        care.add_row(row["task"], f"{row['hedges_g']:.1f}", f"{row['hedges_g_without_care']:.1f}")
    return [stiffness, care, "simulated operators: models, not people (palpate/simulators/operators); simulated arms"]
