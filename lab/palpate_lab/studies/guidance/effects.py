"""Statistics of the trials of `palpate study guidance`: means, effects with confidence, break-even, ablation."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import cast

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.intervals import holm, interval, paired
from palpate.base.sweep import Axis
from palpate.base.sweep.grid import Point
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.guidance.result import Ablated, Against, BreakEven, Effect, Mean, Registered, Summary, Trials
from palpate_lab.studies.guidance.tasks import TASKS
from palpate_lab.studies.guidance.work import ABLATION, ALL, CONDITIONS, FEW, MEASURES, REGISTRATION, task_of


def of_the_first(
    each: Callable[[Point, int], dict[str, float]],
    tasks: Iterable[str],
    operators: int,
    seed: int,
    sweep: Sweeper,
    title: str,
) -> dict[str, Trials]:
    """Sweep `each` over the first operators, at most FEW: rows by task."""
    few = min(operators, FEW)
    grid = {"operator": Axis(range(few)), "task": Axis(tasks), "cohort": Axis([seed])}
    rows = sweep(each, grid, seed, title=title).rows()
    return {task: [row for row in rows if row["task"] == task] for task in tasks}


def relative_change(before: Array, after: Array) -> tuple[float, float, float]:
    """Relative change of the mean from (n,) to (n,) of the same operators, and its 95 % bounds [-]."""
    return _change(before, after), *interval(_change, before, after)


def _change(before: Array, after: Array) -> float:
    return float(after.mean() / before.mean() - 1.0) if before.any() else float("nan")


@dataclass(frozen=True)
class Expected:
    """Effect on people that the literature reports, relative to the condition none."""

    hedges_g: float
    """Negative: the measure decreases [-]."""
    source: str
    change: tuple[float, float] | None = None
    """Range of the relative change of the mean [-]."""


_META = "Bergholz, Ferle and Weber 2023, meta-analysis of 56 papers on haptic feedback in robot assisted surgery"
_PATH = Expected(-1.28, f"g: {_META}, accuracy with virtual fixtures (0.78 to 1.78); range: they raise "
                 "performance by 20 to 70 % (Rosenberg 1993, as told in Du and Zhang 2014)", (-0.7, -0.2))  # fmt: skip
_PEAK = Expected(-0.69, f"g: {_META}, peak force; range: about -40 %; without force feedback twice as large in "
                 "Wagner, Stylopoulos, Jackson and Howe 2007", (-0.50, -0.30))  # fmt: skip
_MEAN = Expected(-0.83, f"{_META}, average force (0.66 to 1.01)")
_TIME = Expected(
    -0.83, f"{_META}, completion time; no difference was found between contact forces and virtual fixtures"
)

#: By condition and measure.
EXPECTED: dict[tuple[str, str], Expected] = {
    ("guidance", "path_error_mm"): _PATH,
    ("haptics+guidance", "path_error_mm"): _PATH,
    ("haptics+hard", "path_error_mm"): _PATH,
    ("haptics", "peak_force_N"): _PEAK,
    ("haptics+guidance", "peak_force_N"): _PEAK,
    ("haptics", "mean_force_N"): _MEAN,
    ("haptics+guidance", "mean_force_N"): _MEAN,
    ("haptics", "time_s"): _TIME,
    ("guidance", "time_s"): _TIME,
    ("haptics+guidance", "time_s"): _TIME,
}


def summary(rows: Trials, seed: int) -> Summary:
    """All statistics; the keys are those of docs/json.md."""
    means: list[Mean] = []
    effects: list[Effect] = []
    for task in TASKS:
        none = _columns(rows, task, "none")
        for condition in CONDITIONS:
            mine = _columns(rows, task, condition)
            mean = {
                key: float(mine[key].mean()) for key in (*MEASURES, "deepest_mm", "hand_peak_force_N", "peak_50ms_N")
            }
            unfinished = int(np.sum(mine["done"] == 0.0))
            means.append(cast(Mean, {"task": task, "condition": condition, **mean, "unfinished": unfinished}))
            if condition != "none":
                effects += [_effect(task, condition, key, none[key], mine[key]) for key in MEASURES]
    for effect, p in zip(effects, holm(np.array([e["p"] for e in effects])), strict=True):
        effect["p_holm"] = float(p)
    control = [_against(rows, task) for task in TASKS]
    return {
        "simulated": True,
        "operators": len(none["time_s"]),
        "seed": seed,
        "rows": means,
        "effects": effects,
        "registration": [row for task in TASKS for row in _registered(rows, task)],
        "break_even": [_break_even(rows, task) for task in TASKS],
        "ablation": [row for task in TASKS for row in _ablated(rows, task)],
        "control": control,
        "control_works": all(one["than_right_low_mm"] > 0.0 for one in control),
    }


def _columns(rows: Trials, task: str, condition: str, most: int | None = None) -> dict[str, Array]:
    """Measures (n,) by name, in the order of the operators; of the first `most` operators if given."""
    mine = sorted((r for r in rows if r["task"] == task and r["condition"] == condition), key=lambda r: r["operator"])
    kept = mine[:most]
    return {key: np.array([row[key] for row in kept]) for key in kept[0] if key not in ("task", "condition")}


def hedges_g(a: Array, b: Array) -> Array:
    """Hedges' g along the last axis: difference of means b - a over the pooled spread, for few samples [-]."""
    n = a.shape[-1] + b.shape[-1]
    spread = np.sqrt(0.5 * (a.var(axis=-1, ddof=1) + b.var(axis=-1, ddof=1)))
    difference = b.mean(axis=-1) - a.mean(axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        g = np.where(spread > 0.0, difference / spread, 0.0)
    return np.asarray((1.0 - 3.0 / (4.0 * n - 9.0)) * g)


def _g(a: Array, b: Array) -> float:
    return float(hedges_g(a, b))


def _effect(task: str, condition: str, key: str, none: Array, mine: Array) -> Effect:
    known = none.mean() > 0.0
    change, low, high = relative_change(none, mine) if known else (None, None, None)
    g_low, g_high = interval(_g, none, mine)
    expected = EXPECTED.get((condition, key))
    if key == "path_error_mm" and task_of(task).purpose != key:
        expected = None  # no fixture of this task guides along the path
    return {
        "task": task,
        "condition": condition,
        "measure": key,
        "change": change,
        "change_low": low,
        "change_high": high,
        "p": paired(none, mine),
        "p_holm": float("nan"),  # of the whole family, which is known at the end
        "hedges_g": _g(none, mine),
        "hedges_g_low": g_low,
        "hedges_g_high": g_high,
        "expected_change": list(expected.change) if expected and expected.change else None,
        "expected_hedges_g": expected.hedges_g if expected else None,
        "source": expected.source if expected else None,
    }


def _registered(rows: Trials, task: str) -> list[Registered]:
    """Means of the first FEW operators: a row without guidance, then a row per registration error."""
    found: list[Registered] = []
    for name in ("haptics", "haptics+guidance", *REGISTRATION, "control_wrong"):
        mine = _columns(rows, task, name, FEW)
        found.append({
            "task": task,
            "error_mm": ALL[name].offset_mm if ALL[name].guidance else None,
            "path_error_mm": float(mine["path_error_mm"].mean()),
            "peak_force_N": float(mine["peak_force_N"].mean()),
            "entries": float(mine["entries"].mean()),
        })  # fmt: skip
    return found


def _break_even(rows: Trials, task: str) -> BreakEven:
    """Registration error above which guidance is worse at its purpose than the same console without guidance [mm].

    The error is interpolated linearly. It is None if guidance helps at the largest error, and 0 if it never helps.
    """
    without, *tried = _registered(rows, task)
    purpose = task_of(task).purpose
    errors = np.array([row["error_mm"] for row in tried])
    more = np.array([row[purpose] for row in tried]) - without[purpose]
    k = int(np.argmax(more > 0.0))
    at: float | None = None if not (more > 0.0).any() else 0.0
    if k > 0:
        at = float(errors[k - 1] + (errors[k] - errors[k - 1]) * -more[k - 1] / (more[k] - more[k - 1]))
    return {"task": task, "measure": purpose, "break_even_mm": at, "largest_tried_mm": float(errors[-1])}


def _ablated(rows: Trials, task: str) -> list[Ablated]:
    """Relative change of the forces by haptic feedback, with the operators' haste and without; empty without trials."""
    (name,) = ABLATION
    if not any(r["task"] == task and r["condition"] == name for r in rows):
        return []
    felt, none, same = (_columns(rows, task, c) for c in ("haptics", "none", name))
    return [
        {
            "task": task,
            "measure": key,
            "change": float(felt[key].mean() / none[key].mean() - 1.0),
            "change_without_haste": float(felt[key].mean() / same[key].mean() - 1.0),
        }
        for key in ("mean_force_N", "peak_force_N")
    ]


def _against(rows: Trials, task: str) -> Against:
    """Additional path error of displaced guidance, relative to correct guidance and to none [mm]."""
    wrong = _columns(rows, task, "control_wrong")["path_error_mm"]
    found: dict[str, str | float] = {"task": task}
    for name, condition in (("right", "haptics+guidance"), ("none", "none")):
        more = wrong - _columns(rows, task, condition)["path_error_mm"]
        low, high = interval(np.mean, more)
        found |= {f"than_{name}_mm": float(more.mean())}
        found |= {f"than_{name}_low_mm": float(low), f"than_{name}_high_mm": float(high)}
    return cast(Against, found)
