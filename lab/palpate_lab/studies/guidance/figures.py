"""Pictures of `palpate study guidance`: measures of the cohort, paths of one operator, registration errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.base.plotting.style import CAP, DEPTH, FORCE, INK, MUTED, Canvas, png
from palpate_lab.studies.guidance.result import StudyResult, Trials
from palpate_lab.studies.guidance.tasks import TASKS, Task
from palpate_lab.studies.guidance.work import CONDITIONS, attempt, task_of, trial_seed

COLORS = {
    "none": MUTED, "visual": CAP, "haptics": DEPTH, "guidance": "#2f8f4e", "haptics+guidance": "#1b5e34",
    "haptics+hard": "#8a5fb0", "control_wrong": FORCE,
}  # fmt: skip
SHOWN = (("path_error_mm", "path error [mm]"), ("peak_force_N", "peak force [N]"), ("entries", "entries"))
FORBIDDEN = "#c8453b"
DRAWN = ("none", "haptics+guidance", "control_wrong")


def draw(rows: Trials, found: StudyResult, folder: Path, seed: int) -> list[Path]:
    """Draw all pictures into a folder, and return their files."""
    files = [folder / f"{name}.png" for name in ("guidance", "guidance_paths", "guidance_registration")]
    png(lambda canvas: _cohort(rows, found, canvas), files[0])
    png(lambda canvas: _paths(canvas, middle(rows), seed), files[1])
    png(lambda canvas: _registration(canvas, found), files[2])
    return files


def _cohort(rows: Trials, found: StudyResult, canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 6.2), layout="constrained")
    panels = figure.subplots(len(SHOWN), len(TASKS), sharex=True, squeeze=False)
    for j, name in enumerate(TASKS):
        for i, (key, words) in enumerate(SHOWN):
            axes: Axes = panels[i, j]
            _violins(axes, rows, name, key)
            axes.set_ylim(bottom=0)
            if i == 0:
                axes.set_title(task_of(name).title, loc="left")
            if j == 0:
                axes.set_ylabel(words)
        panels[-1, j].set_xticks(range(len(CONDITIONS)), [_short(c) for c in CONDITIONS], rotation=35, ha="right")
    figure.suptitle(
        f"{found['operators']} simulated operators (models, not people); bar: middle half, dot: mean", fontsize=9
    )
    return figure


def _short(condition: str) -> str:
    names = {
        "control_wrong": "guidance 5 mm off",
        "haptics+guidance": "haptics, guidance",
        "haptics+hard": "haptics, hard",
    }
    return names.get(condition, condition)


def _violins(axes: Axes, rows: Trials, task: str, key: str) -> None:
    for k, (condition, color) in enumerate(COLORS.items()):
        values = np.array([r[key] for r in rows if r["task"] == task and r["condition"] == condition])
        low, high = np.percentile(values, [25, 75])
        ends = np.percentile(values, [5, 95])
        axes.plot([k, k], ends, color=color, lw=1.0)
        axes.plot([k, k], [low, high], color=color, lw=6.0, solid_capstyle="butt", alpha=0.8)
        axes.plot(k, values.mean(), "o", color="white", mec=INK, ms=4.0)


def middle(rows: Trials) -> int:
    """The operator with the cohort's median of the path error, averaged over the drawn tasks and conditions."""
    drawn = [r for r in rows if r["condition"] in DRAWN]
    numbers = sorted({int(r["operator"]) for r in drawn})
    errors = [float(np.mean([r["path_error_mm"] for r in drawn if r["operator"] == k])) for k in numbers]
    return numbers[int(np.argsort(errors)[len(errors) // 2])]


def _paths(canvas: Canvas, one: int, seed: int) -> Figure:
    figure = Figure(figsize=(canvas.width, 5.6), layout="constrained")
    panels = figure.subplots(2, 2)
    for axes, name in zip(panels.flat, TASKS, strict=True):
        task = task_of(name)
        across = (0, 1) if name != "insertion" else (0, 2)
        truth = 1e3 * task.errand.path[:, across]
        axes.plot(*truth.T, color=INK, lw=0.8, ls=(0, (4, 2)), label="path")
        for condition in DRAWN:
            trial = attempt(one, name, condition, trial_seed(one, name, condition, seed), seed)
            moved = 1e3 * trial.p_WT[:, across]
            axes.plot(*moved.T, color=COLORS[condition], lw=1.1, label=_short(condition))
            inside = task.outside(trial.p_WT) > 0.0
            axes.plot(*moved[inside].T, ".", color=FORBIDDEN, ms=3.0)
        if task.errand.press > 0.0:
            _forbidden(axes, task)
        axes.set(
            title=task.title, aspect="equal", xlabel="x [mm]", ylabel="z [mm]" if name == "insertion" else "y [mm]"
        )
    panels[0, 0].legend(loc="upper right", fontsize=6.5)
    figure.suptitle(
        f"operator {one} (a model) with the median error; red: forbidden region, and the path inside it",
        fontsize=9,
    )
    return figure


def _forbidden(axes: Axes, task: Task) -> None:
    """Tint the forbidden region at the height of the path."""
    axes.autoscale_view()
    axes.autoscale(False)
    x, y = (1e-3 * np.linspace(*limits, 240) for limits in (axes.get_xlim(), axes.get_ylim()))
    z = float(task.errand.path[:, 2].mean())
    places = np.stack([*np.meshgrid(x, y), np.full((240, 240), z)], axis=-1).reshape(-1, 3)
    inside = task.outside(places).reshape(240, 240)
    axes.contourf(1e3 * x, 1e3 * y, inside, levels=[0.0, np.inf], colors=[FORBIDDEN], alpha=0.12)


def _registration(canvas: Canvas, found: StudyResult) -> Figure:
    figure = Figure(figsize=(canvas.width, 2.4), layout="constrained")
    panels = figure.subplots(1, len(TASKS), squeeze=False)
    for axes, even in zip(panels.flat, found["break_even"], strict=True):
        mine = [row for row in found["registration"] if row["task"] == even["task"]]
        without, with_, key = mine[0], mine[1:], even["measure"]
        axes.axhline(without[key], color=COLORS["haptics"], lw=1.2, label="no guidance")
        axes.plot([r["error_mm"] for r in with_], [r[key] for r in with_], "o-",
                  color=COLORS["haptics+guidance"], ms=3.5, lw=1.2, label="guidance")  # fmt: skip
        if even["break_even_mm"]:
            axes.axvline(even["break_even_mm"], color=MUTED, lw=0.8, ls=(0, (4, 2)))
        axes.set_title(task_of(even["task"]).title, loc="left", fontsize=8)
        axes.set(
            xlabel="registration error [mm]", ylabel=key.replace("_mm", " [mm]").replace("_", " "), ylim=(0.0, None)
        )
    panels[0, 0].legend(loc="lower right", fontsize=6.5)
    return figure
