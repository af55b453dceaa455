"""The picture of ``palpate study force``: estimated and true force, and the torque of a weight."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.arm.identify.payload import Load
from palpate.base.plotting.style import CAP, CELL, FORCE, INK, Canvas, png
from palpate_lab.studies.force.work import WEIGHT, StudyResult, Trace


def draw(load: Load | None, trace: Trace, found: StudyResult, folder: Path) -> Path:
    """Draw the picture into ``folder``; returns the file."""
    path = folder / "force.png"
    png(lambda canvas: picture(load, trace, found, canvas), path)
    return path


def picture(load: Load | None, trace: Trace, found: StudyResult, canvas: Canvas) -> Figure:
    """Simulated force by axis on the left, the real weight on the right."""
    figure = Figure(figsize=(canvas.width, 5.2), layout="constrained")
    if load is None:
        _forces([figure.add_subplot(3, 1, k + 1) for k in range(3)], trace, found)
        return figure
    left, right = figure.subfigures(1, 2, squeeze=False)[0]
    _forces(left.subplots(3, 1, sharex=True, squeeze=False)[:, 0].tolist(), trace, found)
    _weight(right.subplots(2, 1, sharex=True, squeeze=False)[:, 0].tolist(), load)
    return figure


def _forces(panels: list[Axes], trace: Trace, found: StudyResult) -> None:
    for k, axes in enumerate(panels):
        axes.plot(trace.t, trace.truth[:, k], color=CELL, lw=2.4, label="what pushes")
        axes.plot(trace.t, trace.estimate[:, k], color=FORCE, lw=0.9, label="estimated from drive torques")
        axes.set_ylabel(f"$F_{'xyz'[k]}$ [N]")
        axes.set_title(f"NRMSE {100 * found['nrmse_axis'][k]:.1f} % of its range", loc="right", color=INK)
    panels[0].legend(loc="lower left", bbox_to_anchor=(0, 1.0), ncols=2, borderaxespad=0.2)
    panels[-1].set_xlabel("t [s]   simulated PSM on a floor, pushed from the side")


def _weight(panels: list[Axes], load: Load) -> None:
    low, high = load.interval
    for k, axes in enumerate(panels):
        axes.plot(load.t, load.tared[:, k], color=CELL, lw=1.2, label="loaded less unloaded")
        axes.plot(load.t, load.fitted[:, k], color=CAP, lw=1.2, label=f"a body of {1e3 * load.mass:.0f} g")
        axes.set_ylabel(f"{('yaw', 'pitch')[k]} [N m]")
    title = f"{1e3 * load.mass:.0f} g, 95 % {1e3 * low:.0f} to {1e3 * high:.0f} g; on the scale {1e3 * WEIGHT:.0f} g"
    panels[0].set_title(title, loc="right", color=INK)
    panels[1].legend(loc="lower left", bbox_to_anchor=(0, 1.0), ncols=2, borderaxespad=0.2)
    panels[-1].set_xlabel("t [s]   real PSM, recorded")
