"""The picture of ``palpate study zwidth``: the K-B plane for each rate and delay."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from palpate.base.plotting.style import DEPTH, FORCE, INK, MUTED, Canvas, png
from palpate_lab.studies.zwidth.result import Panel, StudyResult

STABLE, UNSTABLE = "#d5e6ec", "#f8e3df"


def draw(found: StudyResult, folder: Path) -> Path:
    """Draw the picture into ``folder``; returns the file."""
    file = folder / "zwidth.png"
    png(lambda canvas: _figure(found, canvas), file)
    return file


def _figure(found: StudyResult, canvas: Canvas) -> Figure:
    panels = found["panels"]
    rates, delays = (list(dict.fromkeys(p[key] for p in panels)) for key in ("rate_Hz", "delay_s"))
    size = (canvas.width, 0.9 + 2.1 * len(rates))
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(rates), len(delays), sharex=True, sharey=True, squeeze=False)
    for panel in panels:
        i, j = rates.index(panel["rate_Hz"]), delays.index(panel["delay_s"])
        _plane(axes[i, j], panel)
        axes[i, j].set_title(f"{panel['rate_Hz']:g} Hz, {1e3 * panel['delay_s']:g} ms", loc="left", fontsize=8.5)
    for a in axes[-1]:
        a.set_xlabel("damping of the wall B [N s/m]")
    for a in axes[:, 0]:
        a.set_ylabel("stiffness K [N/m]")
    lines, names = axes[0, 0].get_legend_handles_labels()
    areas = {"stable, simulated": Patch(color=STABLE), "oscillates, simulated": Patch(color=UNSTABLE)}
    figure.legend([*areas.values(), *lines], [*areas, *names], loc="outside lower center", ncols=4)
    mass, damping, friction = (found["device"][f"{name}_SI"] for name in ("mass", "damping", "friction"))
    device = f"{mass:.2g} kg, {damping:.2g} N s/m, {friction:.2g} N of dry friction"
    figure.suptitle(f"Z-width of {device}, {found['hand']} hand (simulated)", fontsize=9.5, x=0.01, ha="left")
    return figure


def _plane(axes: Axes, panel: Panel) -> None:
    B, K = np.array(panel["B_N_s_per_m"]), np.array(panel["K_N_per_m"])
    colors = ListedColormap([UNSTABLE, STABLE])
    axes.pcolormesh(_edges(B), _edges(K), np.array(panel["stable"]).T, cmap=colors, vmin=0, vmax=1, rasterized=True)
    fine = panel["line_B_N_s_per_m"]
    boundary = [1e9 if k is None else max(k, 1e-9) for k in panel["boundary_N_per_m"]]  # outside the visible range
    axes.plot(fine, boundary, color=DEPTH, lw=1.6, label="certified boundary (linear loop)")
    passive = [max(k, 1e-9) for k in panel["colgate_brown_N_per_m"]]
    axes.plot(fine, passive, color=FORCE, lw=1.2, ls=(0, (4, 2)), label="passive (Colgate and Brown)")
    axes.set(xscale="log", yscale="log", xlim=_edges(B)[[0, -1]], ylim=_edges(K)[[0, -1]])
    axes.grid(False)
    axes.tick_params(colors=MUTED)
    axes.title.set_color(INK)


def _edges(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges (n + 1,) of cells around n logarithmically spaced centres."""
    x = np.log(centres)
    half = 0.5 * (x[1] - x[0])
    return np.asarray(np.exp(np.concatenate([x - half, x[-1:] + half])))
