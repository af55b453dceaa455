"""The picture of ``palpate study radius``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.base.plotting.style import DEPTH, FORCE, INK, JOINTS, MUTED, Canvas, png
from palpate.scene.contact.touchable import FEATURE_RADIUS, direction_noise_deg
from palpate_lab.studies.radius.work import Row

SHOWN = 0.2  # noise of the lower panels [mm]


def draw(rows: list[Row], folder: Path) -> Path:
    """Draw the picture into a folder, and return its file."""
    file = folder / "radius.png"
    png(lambda canvas: _figure(rows, canvas), file)
    return file


def _figure(rows: list[Row], canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, canvas.width * 0.68), layout="constrained")
    (kept, direction), (steps, remedies) = figure.subplots(2, 2)
    _kept(kept, rows)
    widest = [r for r in rows if r["feature_mm"] == max(r["feature_mm"] for r in rows)]
    _direction(direction, widest)
    _steps(steps, widest)
    _remedies(remedies, widest)
    for axes in (direction, steps, remedies):
        axes.set_xscale("log")
        radii = sorted({r["radius_mm"] for r in rows})
        axes.set_xticks(radii, [f"{r:g}" for r in radii])
        axes.minorticks_off()
        axes.set_xlabel("radius of the sphere [mm]")
    return figure


def _kept(axes: Axes, rows: list[Row]) -> None:
    for color, feature in zip(JOINTS, sorted({r["feature_mm"] for r in rows}), strict=False):
        of = sorted({(r["radius_mm"] / feature, r["kept"]) for r in rows if r["feature_mm"] == feature})
        axes.plot(*zip(*of, strict=True), "o-", ms=3, color=color, label=f"ridges {feature:g} mm wide")
    axes.axvline(FEATURE_RADIUS, color=INK, lw=0.8, ls=":")
    axes.annotate("rule: half the width", (FEATURE_RADIUS, 0.06), (4, 0), textcoords="offset points", color=INK)
    axes.set(xscale="log", ylim=(0, 1.05), xlabel="radius / width of the ridge", ylabel="rendered height of the relief")
    axes.set_yticks(np.linspace(0, 1, 5), [f"{x:.0%}" for x in np.linspace(0, 1, 5)])
    axes.set_xticks([0.1, 0.25, 0.5, 1, 2, 4, 8], ["0.1", "1/4", "1/2", "1", "2", "4", "8"])
    axes.minorticks_off()
    axes.set_title("Height of a feature that is rendered", loc="left")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 0.1))


def _direction(axes: Axes, rows: list[Row]) -> None:
    noises = sorted({r["noise_mm"] for r in rows} - {0.0})
    for color, noise in zip(JOINTS, noises, strict=False):
        of = [(r["radius_mm"], r["direction_deg"]) for r in rows if r["noise_mm"] == noise]
        x, y = zip(*of, strict=True)
        axes.plot(x, y, "o-", ms=3, color=color)
        axes.annotate(
            f"{noise:g} mm", (x[0], y[0]), (-4, 0), textcoords="offset points", ha="right", va="center", color=color
        )
        rule = [direction_noise_deg(1e-3 * noise, 1e-3 * r, 0.5e-3) for r in x]
        axes.plot(x, rule, color=MUTED, lw=0.8, ls=":")
    axes.set(yscale="log", ylabel="direction error [deg], 95 %", xlim=(0.3, 17))
    axes.set_yticks([1, 3, 10, 30, 90], ["1", "3", "10", "30", "90"])
    axes.minorticks_off()
    axes.set_title("Direction error by noise (dotted: the rule)", loc="left")


def _steps(axes: Axes, rows: list[Row]) -> None:
    of = [r for r in rows if r["noise_mm"] == SHOWN]
    x = [r["radius_mm"] for r in of]
    axes.plot(
        x,
        [r["bias_mN"] for r in of],
        "o-",
        ms=3,
        color=DEPTH,
        label="excess of the mean force: the sphere rests on peaks [mN]",
    )
    axes.plot(x, [10 * r["step_mN"] for r in of], "o-", ms=3, color=FORCE, label="change in a millisecond [mN]")
    axes.plot(x, [10 * r["step_deg"] for r in of], "o--", ms=3, color=FORCE, label="rotation in a millisecond [deg]")
    axes.set(ylim=(0, None), ylabel="[mN]; red curves times 10")
    axes.set_title(f"Changes and mean of the force (noise {SHOWN:g} mm)", loc="left")
    axes.legend()


def _remedies(axes: Axes, rows: list[Row]) -> None:
    of = [r for r in rows if r["noise_mm"] == SHOWN]
    x = [r["radius_mm"] for r in of]
    axes.plot(x, [r["error_mN"] for r in of], "o-", ms=3, color=INK, label="no filter")
    for color, cap in zip(JOINTS, reversed(of[0]["filtered_mN"]), strict=False):
        axes.plot(x, [r["filtered_mN"][cap] for r in of], "o-", ms=3, color=color, label=f"at most {cap} N/s")
    axes.set(ylim=(0, None), ylabel="force error [mN], 95 %")
    axes.set_title(f"Radius with a force filter (noise {SHOWN:g} mm)", loc="left")
    axes.legend()
