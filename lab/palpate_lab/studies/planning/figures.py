"""The picture of ``palpate study planning``: entries of all trials, beside the traits that were put in."""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.base.plotting.style import FORCE, INK, JOINTS, MUTED, Canvas, png
from palpate.simulators.operators import person
from palpate_lab.studies.planning.work import CONDITIONS, EVERY, SEED, Rows


def draw(folder: Path, rows: Rows, found: dict[str, Any]) -> list[Path]:
    """Write the picture; returns its file."""
    file = folder / ("study_planning.png" if set(found) == set(CONDITIONS) else "study_planning_stiffness.png")
    png(lambda canvas: _figure(canvas, rows, found), file)
    return [file]


def _figure(canvas: Canvas, rows: Rows, found: dict[str, Any]) -> Figure:
    figure = Figure(figsize=(canvas.width, 0.42 * canvas.width), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
    _entries(left, rows, found)
    _put_in(right, rows, list(found)[-1])
    return figure


def _entries(axes: Axes, rows: Rows, found: dict[str, Any]) -> None:
    """Mean entry of every route, and the mean of all."""
    names = list(found)
    routes = 1 + max(row["route"] for row in rows)
    for i in range(routes):
        means = [np.mean([r["entry_mm_s"] for r in rows if (r["route"], r["condition"]) == (i, c)]) for c in names]
        axes.plot(range(len(names)), means, "o-", ms=3, lw=0.6, color=MUTED, label="" if i else "one route, mean")
    axes.plot(range(len(names)), [found[c]["entry_mm_s"] for c in names], "D", ms=6, color=FORCE, label="all trials")
    for k, c in enumerate(names[1:], start=1):
        less = f"{-100 * found[c]['entry_reduction']:+.0f} %"
        axes.annotate(less, (k, found[c]["entry_mm_s"]), (8, 10), textcoords="offset points", color=INK)
    labels = ["\n".join(wrap(found[c]["words"], 14)) for c in names]
    axes.set_xticks(range(len(names)), labels)
    axes.set(
        ylabel="entry into the 3 mm margin [mm s]", title="result", xlim=(-0.3, len(names) - 0.4), ylim=(0.0, None)
    )
    axes.legend(loc="upper right")


def _put_in(axes: Axes, rows: Rows, last: str) -> None:
    """Path error of every operator over the error of sight that the operator was given."""
    operators = sorted({row["operator"] for row in rows})
    given = [1e3 * person(who, SEED).visual_error for who in operators]
    for name, colour in zip(("none", last), (JOINTS[0], JOINTS[1]), strict=True):
        own = [[r["path_error_mm"] for r in rows if (r["operator"], r["condition"]) == (k, name)] for k in operators]
        axes.plot(given, [np.mean(one) for one in own], "o", ms=4, color=colour, label=EVERY[name].words)
    axes.set(xlabel="put in: operator's error of sight, rms [mm]", ylabel="path error of the tip, rms [mm]",
             title="operators")  # fmt: skip
    axes.set_ylim(0.0, 1.25 * axes.get_ylim()[1])  # room for the legend
    axes.legend(loc="upper left")
