"""The picture of ``palpate study pairs``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from palpate.base.plotting.style import FORCE, MUTED, Canvas, png
from palpate_lab.studies.pairs.work import Found


def draw(found: Sequence[Found], folder: Path) -> Path:
    """Draw the force on each hand, alone and together, into a folder; return the file."""
    file = folder / "study_pairs.png"
    png(lambda canvas: _figure(found, canvas), file)
    return file


def _figure(found: Sequence[Found], canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 1.5 * len(found) + 0.6), layout="constrained")
    for axes, one in zip(figure.subplots(len(found), 1, squeeze=False, sharex=True)[:, 0], found, strict=True):
        axes.plot(one.t, one.alone, color=MUTED, lw=2.2, label="alone")
        axes.plot(one.t, one.together, color=FORCE, lw=0.9, label="with the other instruments")
        axes.set(ylabel="force on the hand [N]")
        axes.set_title(f"pair {one.row.pair}", loc="left")
    figure.axes[0].legend(loc="upper right")
    figure.axes[-1].set_xlabel("time [s]")
    return figure
