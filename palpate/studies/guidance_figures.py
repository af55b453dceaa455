"""Pictures of `palpate study guidance`: what the cohort did, and one operator on the way."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from palpate.report.style import CAP, DEPTH, FORCE, INK, MUTED, Canvas, png
from palpate.studies.guidance import CONDITIONS, _task, attempt
from palpate.studies.guidance_tasks import TASKS
from palpate.sweep.work import seed_of

Array = NDArray[np.float64]

COLORS = {
    "none": MUTED, "visual": CAP, "haptics": DEPTH, "guidance": "#2f8f4e", "haptics+guidance": "#1b5e34",
    "control_wrong": FORCE,
}  # fmt: skip
SHOWN = (("path_error_mm", "path error [mm]"), ("peak_force_N", "peak force [N]"), ("entries", "entries"))
ALLOWED, FORBIDDEN = "#2f8f4e", "#c8453b"
ONE = 3
"""Operator whose way is drawn."""


def draw(rows: list[dict[str, Any]], told: dict[str, Any], folder: Path, seed: int) -> list[Path]:
    """Both pictures, into a folder."""
    files = [folder / "guidance.png", folder / "guidance_paths.png"]
    png(lambda canvas: _cohort(rows, told, canvas), files[0])
    png(lambda canvas: _ways(canvas, seed), files[1])
    return files


def _cohort(rows: list[dict[str, Any]], told: dict[str, Any], canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 6.2), layout="constrained")
    panels = figure.subplots(len(SHOWN), len(TASKS), sharex=True, squeeze=False)
    for j, name in enumerate(TASKS):
        for i, (key, words) in enumerate(SHOWN):
            axes: Axes = panels[i, j]
            _violins(axes, rows, name, key)
            axes.set_ylim(bottom=0)
            if i == 0:
                axes.set_title(_task(name).title, loc="left")
            if j == 0:
                axes.set_ylabel(words)
        panels[-1, j].set_xticks(range(len(CONDITIONS)), [_short(c) for c in CONDITIONS], rotation=35, ha="right")
    figure.suptitle(
        f"{told['operators']} simulated operators (models, not people); bar: middle half, dot: mean", fontsize=9
    )
    return figure


def _short(condition: str) -> str:
    return {"control_wrong": "guidance misplaced", "haptics+guidance": "haptics and guidance"}.get(condition, condition)


def _violins(axes: Axes, rows: list[dict[str, Any]], task: str, key: str) -> None:
    for k, (condition, color) in enumerate(COLORS.items()):
        values = np.array([r[key] for r in rows if r["task"] == task and r["condition"] == condition])
        low, high = np.percentile(values, [25, 75])
        ends = np.percentile(values, [5, 95])
        axes.plot([k, k], ends, color=color, lw=1.0)
        axes.plot([k, k], [low, high], color=color, lw=6.0, solid_capstyle="butt", alpha=0.8)
        axes.plot(k, values.mean(), "o", color="white", mec=INK, ms=4.0)


def _ways(canvas: Canvas, seed: int) -> Figure:
    figure = Figure(figsize=(canvas.width, 5.6), layout="constrained")
    panels = figure.subplots(2, 2)
    for axes, name in zip(panels.flat, TASKS, strict=True):
        task = _task(name)
        across = (0, 1) if name != "insertion" else (0, 2)
        truth = 1e3 * task.errand.path[:, across]
        axes.plot(*truth.T, color=INK, lw=0.8, ls=(0, (4, 2)), label="path")
        for condition in ("none", "haptics+guidance", "control_wrong"):
            trial = attempt(ONE, name, condition, seed_of(seed, ONE))
            way = 1e3 * trial.p_WT[:, across]
            axes.plot(*way.T, color=COLORS[condition], lw=1.1, label=_short(condition))
            inside = task.outside(trial.p_WT) > 0.0
            axes.plot(*way[inside].T, ".", color=FORBIDDEN, ms=3.0)
        if name == "palpation":
            axes.axvspan(-5.0, -3.8, color=FORBIDDEN, alpha=0.15, lw=0)
        axes.set(
            title=task.title, aspect="equal", xlabel="x [mm]", ylabel="z [mm]" if name == "insertion" else "y [mm]"
        )
    panels[0, 0].legend(loc="upper right", fontsize=6.5)
    figure.suptitle("one simulated operator; red dots: in the forbidden region", fontsize=9)
    return figure
