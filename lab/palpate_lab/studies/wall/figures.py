"""Pictures of ``palpate study wall``: Fig 13, overshoot against rigidity, and the sensitivity of the fit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.base.plotting.style import CAP, FORCE, INK, MUTED, TOOL, Canvas, png
from palpate_lab.studies.wall.bench import WALL
from palpate_lab.studies.wall.result import StudyResult, Traces
from palpate_lab.studies.wall.work import CURVE, KDS, NUDGE, TABLE_1

_NAMES = {
    "mass_kg": "hand's mass",
    "damping_N_s_per_m": "hand's damping",
    "stiffness_N_per_m": "hand's stiffness",
    "push_N": "push",
    "approach_s": "approach time",
    "delay_s": "loop delay",
    "coulomb_scale": "arm's dry friction",
}


def draw(traces: Traces, found: StudyResult, folder: Path) -> list[Path]:
    """Both pictures into ``folder``; the files."""
    files = [folder / "wall-figure13.png", folder / "wall-hands.png"]
    png(lambda canvas: figure13(traces, canvas), files[0])
    png(lambda canvas: hands(found, canvas), files[1])
    return files


def figure13(traces: Traces, canvas: Canvas) -> Figure:
    """The handle along y over time for the three gains, without and with passivity."""
    figure = Figure(figsize=(canvas.width, 3.2), layout="constrained")
    axes = figure.subplots(1, 3, sharey=True)
    for ax, letter, kd in zip(axes, "ABC", KDS, strict=True):
        plain, passive = traces[kd]
        ax.axhspan(WALL, 0.44, color="#f1e3da", lw=0)
        ax.axhline(WALL, color=MUTED, lw=0.8)
        inside = WALL * TABLE_1[kd].offshoot_percent / 100.0
        ax.axhline(WALL + inside, color=CAP, lw=0.8, ls=(0, (4, 3)), label="published peak")
        ax.annotate(f"{1e3 * inside:.1f} mm", (0.05, WALL + inside + 0.0006), color=CAP, fontsize=6.5)
        ax.plot(plain.t, plain.y, color=FORCE, label="simulated, as in the paper")
        ax.plot(passive.t, passive.y, color=TOOL, lw=0.9, label="simulated, with passivity")
        ax.set_title(f"{letter}   K_p 400, K_d {kd:g}", loc="left")
        ax.set_xlabel("time [s]")
    axes[0].set_ylabel("handle along y [m]")
    axes[0].set_ylim(0.355, 0.43)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def hands(found: StudyResult, canvas: Canvas) -> Figure:
    """Overshoot over felt rigidity by K_d, and what a fifth of each value does."""
    figure = Figure(figsize=(canvas.width, 3.5), layout="constrained")
    left, middle, right = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.15))
    _overshoot(left, found)
    _rigidity(middle, found)
    _sensitivity(right, found)
    return figure


def _overshoot(ax: Axes, found: StudyResult) -> None:
    low, mid, high = np.array([c["overshoot_percent"] for c in found["curve"]]).T
    people = found["curve"][0]["people"]
    ax.fill_between(CURVE, low, high, color=FORCE, alpha=0.15, lw=0, label=f"90 % of {people} hands")
    ax.plot(CURVE, mid, color=FORCE, marker=".", label="median")
    ax.plot(KDS, [TABLE_1[kd].offshoot_percent for kd in KDS], "x", color=CAP, label="published")
    share = ax.twinx()
    share.plot(CURVE, [100 * c["limit_cycle_share"] for c in found["curve"]], color=TOOL, ls=(0, (4, 2)))
    share.set_ylabel("hands that oscillate [%], dashed", color=TOOL)
    share.set_ylim(0, 100)
    share.grid(False)
    ax.set_xlabel("K_d [N s/m]")
    ax.set_ylabel("overshoot [% of 0.385 m]")
    ax.set_ylim(0, 11)
    ax.set_title("Damping against overshoot", loc="left")
    ax.legend(loc="upper right", fontsize=6.0)


def _rigidity(ax: Axes, found: StudyResult) -> None:
    curve = [c for c in found["curve"] if c["rigidity_N_per_m"] and c["limit_cycle_share"] < 0.5]
    ax.set_xlabel("rendered rigidity at rest [N/m]")
    ax.set_ylabel("overshoot [% of 0.385 m]")
    if not curve:
        return  # none of the few hands comes to rest
    over = [c["overshoot_percent"][1] for c in curve]
    low, mid, high = np.array([c["rigidity_N_per_m"] for c in curve]).T
    ax.errorbar(mid, over, xerr=[mid - low, high - mid], color=INK, ecolor="#c8d0d6", elinewidth=0.8, marker=".")
    for c, x, y in zip(curve, mid, over, strict=True):
        ax.annotate(f"{c['kd']:g}", (x, y), textcoords="offset points", xytext=(4, 4), fontsize=6.5)
    bounce = ax.twiny()
    bounce.plot([c["rebound"][1] for c in curve], over, color=TOOL, marker=".", ls=(0, (4, 2)))
    bounce.set_xlabel("rebound, speed out over speed in (dashed)", color=TOOL)
    bounce.grid(False)


def _sensitivity(ax: Axes, found: StudyResult) -> None:
    names = list(_NAMES)
    nominal = [r["overshoot_percent"] for r in found["rows"]]
    for k, (kd, colour) in enumerate(zip(KDS[1:], (FORCE, TOOL), strict=True), start=1):
        for i, name in enumerate(names):
            two = [s["overshoot_percent"][k] for s in found["sensitivity"] if s["name"] == name]
            ends, place = [100.0 * x / nominal[k] - 100.0 for x in two], i + (k - 1.5) * 0.3
            label = f"K_d {kd:g}" if i == 0 else None
            ax.plot(ends, [place, place], color=colour, lw=3, solid_capstyle="butt", label=label)
            ax.plot(ends[1], place, "o", ms=3, color=colour)
    ax.axvspan(-25, 25, color="#eef2f4", lw=0, zorder=0)
    ax.set_yticks(range(len(names)), [_NAMES[name] for name in names])
    ax.invert_yaxis()
    ax.set_xlabel(f"change of overshoot [%] for -{100 * NUDGE:.0f} to +{100 * NUDGE:.0f} % (dot)")
    ax.set_title("Sensitivity of the fit", loc="left")
    ax.legend(fontsize=6.0, loc="upper right")
