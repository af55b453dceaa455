"""The figure of identified tissue: measured and fitted force over time and over depth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from palpate.arm.identify.tissue import TissueFit
from palpate.base.plotting.style import DEPTH, FORCE, INK, Canvas, png
from palpate.world.tissue import indentation


def save(found: TissueFit, path: Path) -> None:
    """Write the picture (PNG)."""
    png(lambda canvas: _force(found, canvas), path)


def _force(found: TissueFit, canvas: Canvas) -> Figure:
    press = found.press
    depth = 1e3 * (press.depth - found.touch)
    figure = Figure(figsize=(canvas.width, 3.4), layout="constrained")
    over_time, over_depth = figure.subplots(1, 2)
    for axes, x in ((over_time, press.t - press.t[0]), (over_depth, depth)):
        axes.plot(x, press.force, ".", ms=3, color=DEPTH, label="measured")
        axes.plot(x, found.fitted, color=FORCE, lw=1.2, label="fitted")
        axes.grid(True)
        axes.set_ylabel("force [N]")
    reach = np.linspace(0.0, max(depth.max(), 1e-3), 100)
    rest = indentation.sneddon(found.radius, 1e-3 * reach, found.young, found.poisson)
    if np.isfinite(found.thickness):
        rest = indentation.layer(found.radius, 1e-3 * reach, found.young, found.poisson, found.thickness)
    over_depth.plot(reach, rest + found.offset, color=INK, lw=0.9, ls="--", label="relaxed, small strain")
    over_time.set(xlabel="time [s]")
    over_time.set_title("Force of the tissue on the sphere", loc="left")
    over_depth.set(xlabel="depth [mm]")
    over_depth.legend()
    return figure
