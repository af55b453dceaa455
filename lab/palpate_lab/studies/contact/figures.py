"""The pictures of ``palpate study contact``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import cycle
from pathlib import Path
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from palpate.base.plotting.style import INK, JOINTS, MUTED, Canvas, png
from palpate.scene.contact.judging import ARTEFACT, RADIUS
from palpate.scene.contact_method import METHODS
from palpate_lab.studies.contact.result import Row, StudyResult

PALETTE = ("#1f6f8b", "#b58900", "#4f8f4f", "#c8453b", "#8767a8", "#8b98a3", "#d98cb3", "#8a6a4f")
COLORS = dict(zip(METHODS, cycle(PALETTE), strict=False))
MARKERS = "os^Dv*Xp"  # one marker per shape
LEAST = 0.003  # smallest direction error drawn [deg]
Shown = Literal["step_deg", "artefacts", "energy_mJ"]


def draw(result: StudyResult, folder: Path) -> list[Path]:
    """Write every picture; returns the files."""
    figures: dict[str, Callable[[StudyResult, Canvas], Figure]] = {
        "penetration": penetration,
        "approach": approach,
        "slide": slide,
        "planes": planes,
    }
    files = []
    for name, figure in figures.items():
        file = folder / f"contact-{name}.png"
        png(lambda canvas, figure=figure: figure(result, canvas), file)  # type: ignore[misc]
        files.append(file)
    return files


def penetration(result: StudyResult, canvas: Canvas) -> Figure:
    """Direction error over the penetration; a cross marks where a method permanently loses or flips the force."""
    rows = [r for r in result["rows"] if r["path"] == "penetration"]
    shapes = list(dict.fromkeys(r["shape"] for r in rows))
    figure = Figure(figsize=(canvas.width, 5.6), layout="constrained")
    panels = np.atleast_1d(figure.subplots(2, -(-len(shapes) // 2), sharex=True, sharey=True)).ravel()
    for axes, shape in zip(panels, shapes, strict=False):
        mine = [r for r in rows if r["shape"] == shape]
        for method in _methods(mine):
            _depth_curve(axes, method, [r for r in mine if r["method"] == method])
        axes.set_title(_title(mine), loc="left", fontsize=8.5, color=INK)
        axes.axvline(RADIUS * 1e3, color=MUTED, lw=0.8, ls=(0, (2, 2)))
        axes.axvline(2e3 * RADIUS, color=MUTED, lw=0.8, ls=(0, (2, 2)))
        _degrees(axes)
    for x, words in ((RADIUS * 1e3, "centre on the surface"), (2e3 * RADIUS, "sphere wholly inside")):
        style = {"fontsize": 6.5, "color": MUTED, "rotation": 90, "ha": "right", "va": "center"}
        panels[0].annotate(words, (x, 0.06), xytext=(-1, 0), textcoords="offset points", **style)
    for axes in panels[len(panels) // 2 :]:
        axes.set_xlabel("penetration of the sphere, r − φ [mm]")
    for axes in panels[:: len(panels) // 2]:
        axes.set_ylabel("direction error, p95 [deg]")
    _legend(figure, panels[0])
    return figure


def _depth_curve(axes: Axes, method: str, rows: list[Row]) -> None:
    """Plot a method's error where it mostly gives a force; a cross marks the end of this range."""
    rows = sorted(rows, key=lambda r: r["penetration_mm"])
    held = [r for r in rows if r["direction_median_deg"] < 180.0]
    x = [r["penetration_mm"] for r in held]
    y = [max(r["direction_p95_deg"], LEAST) for r in held]
    front = 3 if method == "proxy" else 2
    axes.plot(x, y, "-o", ms=2.5, color=COLORS[method], label=method, zorder=front, lw=_width(method))
    if len(held) < len(rows) and held:
        axes.plot(x[-1:], y[-1:], "x", ms=7, mew=1.6, color=COLORS[method], zorder=4)


def approach(result: StudyResult, canvas: Canvas) -> Figure:
    """Direction error over the angle of approach, median over places and headings."""
    rows = [r for r in result["rows"] if r["path"] == "approach"]
    shapes = list(dict.fromkeys(r["shape"] for r in rows))[:3]
    figure = Figure(figsize=(canvas.width, 3.4), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(shapes), sharey=True))
    angles = sorted({r["approach_deg"] for r in rows})
    for axes, shape in zip(panels, shapes, strict=True):
        mine = [r for r in rows if r["shape"] == shape]
        for method in reversed(_methods(mine)):  # the default in front
            errors = {a: [r for r in mine if (r["method"], r["approach_deg"]) == (method, a)] for a in angles}
            middle = [np.median([r["direction_median_deg"] for r in errors[a]]) for a in angles]
            axes.plot(angles, middle, "-o", ms=3, color=COLORS[method], label=method, lw=_width(method))
        axes.set_title(_title(mine), loc="left", fontsize=8.5, color=INK)
        axes.set(xlabel="angle of approach to the normal [deg]", xticks=angles, yticks=angles, ylim=(-2, 80))
    panels[0].set_ylabel("direction error after the press [deg]")
    _legend(figure, panels[0], back=True)
    return figure


def slide(result: StudyResult, canvas: Canvas) -> Figure:
    """Shallow slide: largest direction step, artefacts and net work with one mark per shape; time by mesh size."""
    rows = [r for r in result["rows"] if r["path"] == "shallow"]
    figure = Figure(figsize=(canvas.width, 3.9), layout="constrained")
    step, count, work, time = figure.subplots(1, 4, width_ratios=[1, 1, 1, 1.1])
    methods, shapes = _methods(rows), list(dict.fromkeys(r["shape"] for r in rows))
    panels: tuple[tuple[Axes, Shown, float], ...]
    panels = (step, "step_deg", LEAST), (count, "artefacts", 0.25), (work, "energy_mJ", -np.inf)
    for axes, key, least in panels:
        for i, method in enumerate(methods):
            finest = _finest([r for r in rows if r["method"] == method])
            _marks(axes, i, method, finest, shapes, key, least)
            if key == "step_deg" and i == 0:
                _marks_of_exact_force(axes, i, finest, shapes, least)
        axes.set_yticks(range(len(methods)), methods if axes is step else [""] * len(methods))
        axes.set_ylim(len(methods) - 0.5, -0.5)
        axes.tick_params(axis="y", length=0)
    _label_slide(step, count, work)
    _plot_times(time, methods, rows)
    time.set(xlabel="triangles", ylabel="one update, p99 [µs]")
    time.set_yticks([0.3, 1, 3, 10, 30, 100, 300], ["0.3", "1", "3", "10", "30", "100", "300"])
    for axes in (step, count, work, time):
        axes.minorticks_off()
    marks = [Line2D([], [], marker=MARKERS[i], ls="", ms=4, color=MUTED, label=s) for i, s in enumerate(shapes)]
    figure.legend(handles=marks, loc="outside lower center", ncols=len(marks), handletextpad=0.1)
    return figure


def _height(line: int, k: int, count: int) -> float:
    """Height of mark k of `count` around the line of a method."""
    return line + 0.3 * (k - (count - 1) / 2) / max(1, count - 1) * 2


def _marks(axes: Axes, line: int, method: str, finest: list[Row], shapes: list[str], key: Shown, least: float) -> None:
    """One mark per shape on the line of a method."""
    for k, r in enumerate(finest):
        mark = MARKERS[shapes.index(r["shape"])]
        axes.plot(max(r[key], least), _height(line, k, len(finest)), mark, ms=4, color=COLORS[method])


def _marks_of_exact_force(axes: Axes, line: int, finest: list[Row], shapes: list[str], least: float) -> None:
    """Rings around the marks: steps of the exact force."""
    for k, r in enumerate(finest):
        mark, y = MARKERS[shapes.index(r["shape"])], _height(line, k, len(finest))
        axes.plot(max(r["true_step_deg"], least), y, mark, ms=7, mew=0.7, mfc="none", mec=INK)


def _label_slide(step: Axes, count: Axes, work: Axes) -> None:
    """Scales and labels of the panels with marks."""
    step.set(xscale="log", xlabel="largest step [deg in 1 ms]")
    step.set_xticks([0.01, 0.1, 1, 10, 180], ["0.01", "0.1", "1", "10", "180"])
    count.set(xscale="log", xlabel=f"artefacts: samples > {ARTEFACT:.0f}° off")
    count.set_xticks([0.25, 1, 10, 100, 1000, 10_000], ["none", "1", "10", "100", "1k", "10k"])
    work.set_xscale("symlog", linthresh=1)
    work.set_xlabel("net work on the tool [mJ]")
    work.set_xticks([-100, -10, -1, 0, 1, 10], ["−100", "−10", "−1", "0", "1", "10"])
    work.axvline(0, color=MUTED, lw=0.8)


def _plot_times(axes: Axes, methods: list[str], rows: list[Row]) -> None:
    """Computation time of one update over the size of the mesh."""
    for method in methods:
        mine = [r for r in rows if r["method"] == method]
        sizes = sorted({round(np.log10(r["triangles"])) for r in mine})
        spent = [np.median([r["p99_us"] for r in mine if round(np.log10(r["triangles"])) == s]) for s in sizes]
        axes.loglog([10.0**s for s in sizes], spent, "-o", ms=3, color=COLORS[method], lw=_width(method))


def planes(result: StudyResult, canvas: Canvas) -> Figure:
    """Normal error of grown planes over the spread of their points, one panel per noise."""
    rows = result["planes"]
    noises = sorted({r["noise_um"] for r in rows})
    figure = Figure(figsize=(canvas.width, 3.2), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(noises), sharey=True))
    for axes, noise in zip(panels, noises, strict=True):
        for i, n in enumerate(sorted({r["points"] for r in rows})):
            mine = [r for r in rows if r["noise_um"] == noise and r["points"] == n]
            mine = [r for r in mine if r["direction_median_deg"] is not None]
            x, y = [r["spread_mm"] for r in mine], [r["direction_median_deg"] for r in mine]
            axes.loglog(x, y, "-o", ms=3, color=JOINTS[i], label=f"{n} points")
        spread = np.array(sorted({r["spread_mm"] for r in rows}))
        # Least squares: tilt sigma / (s sqrt n) about each axis, s = spread / 4 of a disc; median of a Rayleigh law.
        n = max(r["points"] for r in rows)
        law = np.degrees(np.arctan(np.sqrt(2 * np.log(2)) * noise * 1e-3 / (spread / 4) / np.sqrt(n)))
        axes.loglog(spread, law, color=INK, lw=0.8, ls=(0, (4, 3)), label=f"noise alone, {n} points")
        axes.set_title(f"noise of the points {noise:g} µm", loc="left", fontsize=8.5, color=INK)
        axes.set_xlabel("spread of the points [mm]")
        axes.set_xticks(spread, [f"{s:g}" for s in spread])
        axes.minorticks_off()
        _degrees(axes, log=False)
    panels[0].set_ylabel("error of the normal, median [deg]")
    _legend(figure, panels[0])
    return figure


def _methods(rows: Iterable[Row]) -> list[str]:
    there = {r["method"] for r in rows}
    return [m for m in COLORS if m in there]


def _finest(rows: list[Row]) -> list[Row]:
    """The rows of the finest mesh of each shape."""
    shapes = dict.fromkeys(r["shape"] for r in rows)
    return [max((r for r in rows if r["shape"] == s), key=lambda r: r["triangles"]) for s in shapes]


def _title(rows: list[Row]) -> str:
    return f"{rows[0]['shape']}, {rows[0]['triangles'] / 1e3:.0f}k triangles"


def _width(method: str) -> float:
    return 2.2 if method == "proxy" else 1.1


def _degrees(axes: Axes, log: bool = True) -> None:
    ticks, names = [0.01, 0.1, 1.0, 10.0, 90.0], ["0.01", "0.1", "1", "10", "90"]
    if log:
        axes.set_yscale("log")
        axes.set_ylim(LEAST * 0.8, 260)
        ticks, names = [LEAST, *ticks[1:], 180.0], [f"≤ {LEAST:g}", *names[1:], "180"]
    axes.set_yticks(ticks, names)
    axes.minorticks_off()


def _legend(figure: Figure, axes: Axes, back: bool = False) -> None:
    handles, labels = axes.get_legend_handles_labels()
    if back:
        handles, labels = handles[::-1], labels[::-1]
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), handlelength=1.6)
