"""The picture of ``palpate study network``: energies and forces of all random runs over the round trip."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from palpate.base.plotting.style import CAP, DEPTH, FORCE, INK, MUTED, Canvas, png
from palpate_lab.studies.network.result import Ran, StudyResult

_COLOURS = {"model": FORCE, "unknown": INK, "passivity": DEPTH, "direct": CAP}


def draw(found: StudyResult, ran: Sequence[Ran], folder: Path) -> Path:
    """Draw the picture into ``folder``; returns the file."""
    path = folder / "network.png"
    png(lambda canvas: _picture(found, ran, canvas), path)
    return path


def _picture(found: StudyResult, ran: Sequence[Ran], canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 3.6), layout="constrained")
    energy, felt = figure.subplots(1, 2)
    rows: Sequence[Ran] = ran or found["conditions"]  # type: ignore[assignment]
    for mode, colour in _COLOURS.items():
        mine = [r for r in rows if r["mode"] == mode]
        if not mine:
            continue
        delay = np.array([r["round_trip_ms"] for r in mine])
        for axes, key in ((energy, "energy_mJ"), (felt, "felt_over_true")):
            values = np.array([r[key] for r in mine], np.float64)  # type: ignore[literal-required]
            axes.scatter(delay, values, s=4, lw=0, color=colour, alpha=0.6, label=mode, rasterized=True)
    energy.axhline(-0.5, color=MUTED, lw=0.9, ls=(0, (5, 3)))
    energy.set(xlabel="round trip [ms]", ylabel="lowest energy of a port [mJ]")
    energy.set_yscale("symlog", linthresh=1.0)
    felt.axhline(1.0, color=INK, lw=0.8, ls=(0, (5, 3)))
    felt.set(xlabel="round trip [ms]", ylabel="felt / true force [-]", ylim=(-0.1, 1.3))
    energy.legend(loc="lower left", markerscale=3)
    return figure
