"""The picture of `palpate bench cloud`: forces on moving surfaces, with and without the velocity between frames."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from palpate.base.plotting.style import CAP, FORCE, INK, Canvas, png
from palpate_lab.verify.bench.cloud_cases import CASES, felt, true_force

_SHOWN = {
    "rising at 0.1 m/s": (0.40, 0.70),
    "retreating at 0.1 m/s": (0.95, 1.25),
    "breathing": (1.5, 2.5),
    "jumps of 5 mm": (0.40, 0.70),
}
"""Times of each case that are drawn [s]."""


def draw(path: Path) -> None:
    """Run the cases and draw them into a file.

    Raises:
        OSError: it cannot be written.
    """
    png(_picture, path)


def _picture(canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 5.2), layout="constrained")
    for axes, (name, (begin, end)) in zip(figure.subplots(2, 2).flat, _SHOWN.items(), strict=True):
        case = CASES[name]
        for extrapolate, color, label in ((False, CAP, "at rest between frames"), (True, FORCE, "with velocity")):
            rows = felt(case.height, end, extrapolate)
            rows = rows[rows["t"] > begin]
            axes.plot(rows["t"] - begin, rows["F_spring_W"][:, 2], color=color, lw=1.2, label=label)
        exact = true_force(rows, case.height)
        axes.plot(rows["t"] - begin, exact, color=INK, lw=1.0, ls=(0, (3, 2)), label="true surface")
        axes.set(title=name, xlabel="time [s]", ylabel="spring force [N]")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False)
    return figure
