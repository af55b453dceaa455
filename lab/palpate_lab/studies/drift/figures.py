"""The picture of ``palpate study drift``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from palpate.base.plotting.style import INK, JOINTS, MUTED, Canvas, png
from palpate_lab.studies.drift.plant import PLANTS
from palpate_lab.studies.drift.result import Row, StudyResult
from palpate_lab.studies.drift.work import FORMS

COLOURS = dict(zip(FORMS, JOINTS, strict=False))
STYLES = dict(zip(PLANTS, ("-", (0, (4, 2))), strict=True))
_SMALLEST = 0.1  # smaller drifts are drawn at this value [mm]


def draw(found: StudyResult, folder: Path) -> Path:
    """Draw the picture into ``folder``; returns the file."""
    path = folder / "drift.png"
    png(lambda canvas: picture(found, canvas), path)
    return path


def picture(found: StudyResult, canvas: Canvas) -> Figure:
    """One panel per arm with the cumulative distribution of the drift."""
    arms = [arm["arm"] for arm in found["arms"]]
    figure = Figure(figsize=(canvas.width, 3.6), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(arms), sharey=True))
    for axes, arm in zip(panels, arms, strict=True):
        _shares(axes, [row for row in found["rows"] if row["arm"] == arm], found["published_mm"])
        axes.set_title(f"Simulated, made from {arm}", loc="left")
        axes.set_xlabel(f"tip drift within {found['released_s']:g} s [mm]")
    panels[0].set_ylabel("share of releases that drift less")
    marks = [Line2D([], [], color=COLOURS[form], label=form) for form in FORMS]
    marks += [Line2D([], [], color=INK, ls=STYLES[name], label=f"plant {name}") for name in PLANTS]
    marks += [Line2D([], [], color=MUTED, marker="x", ls="", label="published, real arm")]
    figure.legend(handles=marks, loc="outside lower center", ncols=len(marks), handlelength=1.6)
    return figure


def _shares(axes: Axes, rows: list[Row], published: dict[str, tuple[float, float, float]]) -> None:
    for row in rows:
        drift = np.maximum(row["drift_mm"], _SMALLEST)
        share = np.arange(1, len(drift) + 1) / len(drift)
        axes.step([_SMALLEST, *drift, 1e3], [0.0, *share, 1.0], where="post", color=COLOURS[row["model"]],
                  ls=STYLES[row["plant"]], lw=1.4, clip_on=False)  # fmt: skip
    for form, (_, median, p95) in published.items():
        axes.plot([median, p95], [0.5, 0.95], "x", color=COLOURS[form], ms=6, mew=1.6)
    axes.set(xscale="log", xlim=(_SMALLEST, 1e3), ylim=(0, 1.0))
    axes.set_xticks([0.1, 1, 10, 100, 1000], ["stays", "1", "10", "100", "1000"])
    axes.set_yticks([0, 0.25, 0.5, 0.75, 1.0], ["0", "25 %", "50 %", "75 %", "100 %"])
    axes.minorticks_off()
