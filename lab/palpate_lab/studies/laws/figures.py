"""The picture of ``palpate study laws``: validity range of the paper's simplification and of the other laws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate import _core
from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.plotting.style import CAP, CELL, FORCE, INK, JOINTS, Canvas, png
from palpate_lab.studies.laws.work import (
    _AXIS,
    FREQUENCIES,
    HANDS,
    LAWS,
    MIDDLE,
    NOTICED,
    STIFFNESSES,
    Outcome,
    bandwidth,
)

Trace = tuple[str, Array, Array, Array]

COLOURS = dict(zip(LAWS, JOINTS, strict=False))
STYLES = {"slow": (0, (4, 2)), "fast": "-"}


def draw(found: list[Outcome], traces: list[Trace], folder: Path) -> Path:
    """Draw the picture into ``folder``; returns the file."""
    path = folder / "laws.png"
    png(lambda canvas: picture(found, traces, canvas), path)
    return path


def picture(found: list[Outcome], traces: list[Trace], canvas: Canvas) -> Figure:
    """Error over frequency, bandwidth over stiffness, and force of two laws in a slow and a fast motion."""
    figure = Figure(figsize=(canvas.width, 6.4), layout="constrained")
    grid = figure.add_gridspec(2, 4, height_ratios=[1.6, 1.0])
    _errors(figure.add_subplot(grid[0, :2]), found)
    _bandwidths(figure.add_subplot(grid[0, 2:]), found)
    for k, trace in enumerate(traces):
        _trace(figure.add_subplot(grid[1, k]), trace, first=k == 0)
    return figure


def handle_mass() -> float:
    """The arm's mass at the handle along the axis of the study, at home [kg]."""
    arm = Arm.mtm("right")
    rotor = arm.leader_options().rotor_inertia
    Lambda = _core.cartesian_place(arm, arm.home, np.zeros(arm.n), rotor)[0]
    return float(Lambda[_AXIS, _AXIS])


def _errors(axes: Axes, found: list[Outcome]) -> None:
    """Error of the stiffness at the hand over frequency, fast hand; the band shows the effect of wrong masses."""
    for law in LAWS:
        rows = [o for o in found if (o.law, o.K_N_per_m, o.hand) == (law, MIDDLE, "fast")]
        by = {(o.f_Hz, o.model_scale): 100 * o.stiffness_error for o in rows}
        right = [by[f, 1.0] for f in FREQUENCIES]
        all_of = [[e for (f, _), e in by.items() if f == g] for g in FREQUENCIES]
        axes.fill_between(
            FREQUENCIES, [min(e) for e in all_of], [max(e) for e in all_of], color=COLOURS[law], alpha=0.15
        )
        dashes = (0, (3, 2)) if law == "impedance" else "-"  # this curve lies on the curve of stiffness
        axes.plot(FREQUENCIES, right, color=COLOURS[law], marker="o", ms=3, ls=dashes, label=law)
        total = [100 * o.impedance_error for o in sorted(rows, key=lambda o: o.f_Hz) if o.model_scale == 1.0]
        axes.plot(FREQUENCIES, total, color=COLOURS[law], lw=0.7, alpha=0.6)
    m, f = handle_mass(), np.geomspace(FREQUENCIES[0], FREQUENCIES[-1], 100)
    axes.plot(f, 100 * m * (2 * np.pi * f) ** 2 / MIDDLE, color=INK, lw=0.8, ls=":", label=f"{m:.2f} kg on the spring")
    axes.axhline(100 * NOTICED, color=CAP, lw=0.9, ls=(0, (5, 3)))
    axes.text(FREQUENCIES[-1], 105 * NOTICED, "a hand notices", color=CAP, fontsize=7, va="bottom", ha="right")
    axes.set(xscale="log", yscale="log", xlabel="frequency of the motion [Hz]", ylabel="error of the felt spring [%]")
    axes.set_ylim(0.3, 3000.0)
    axes.set_title(f"{MIDDLE:g} N/m; thin: with friction; bands: masses wrong by ±30 %", fontsize=8.5, loc="left")
    axes.legend(loc="upper left")


def _bandwidths(axes: Axes, found: list[Outcome]) -> None:
    """Bandwidth of each law over the rendered stiffness."""
    for law in LAWS:
        for hand in HANDS:
            f = [bandwidth(found, law, K, hand) for K in STIFFNESSES]
            width = 2.4 if law == "stiffness" else 1.1  # the curve of impedance lies on this curve
            axes.plot(STIFFNESSES, np.maximum(f, 0.1), color=COLOURS[law], ls=STYLES[hand], lw=width, marker="o", ms=3,
                      label=law if hand == "fast" else None)  # fmt: skip
    K = np.geomspace(STIFFNESSES[0], STIFFNESSES[-1], 50)
    axes.plot(K, np.sqrt(NOTICED * K / handle_mass()) / (2 * np.pi), color=INK, lw=0.8, ls=":")
    axes.plot([], [], color=CELL, ls=STYLES["slow"], label="slow hand (0.05 m/s)")
    axes.set(xscale="log", yscale="log", xlabel="rendered stiffness K [N/m]", ylabel="felt within 10 % up to [Hz]")
    axes.set_ylim(0.1, 30.0)
    axes.set_title("Slow enough? Above its line a law feels wrong", fontsize=8.5, loc="left")
    axes.legend(loc="upper left", ncol=2)


def _trace(axes: Axes, trace: Trace, first: bool) -> None:
    title, t, wanted, cell = trace
    axes.plot(t, cell - cell.mean(), color=CELL, lw=1.0, label="load cell")
    axes.plot(t, wanted, color=FORCE, lw=1.1, label="desired")
    axes.set_title(title, fontsize=8.5, loc="left")
    axes.set_xlabel("time [s]")
    if first:
        axes.set_ylabel("force [N]")
        low, high = axes.get_ylim()
        axes.set_ylim(low - 0.35 * (high - low), high)  # room for the legend
        axes.legend(loc="lower left", bbox_to_anchor=(0, -0.02))
