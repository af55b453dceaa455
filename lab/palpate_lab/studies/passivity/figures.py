"""The picture of `palpate study passivity`: one wall with 10 ms of delay, and all random runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate import _verify
from palpate.arm.hands import PRESETS
from palpate.base.plotting.style import CAP, DEPTH, FORCE, INK, MUTED, Canvas, png
from palpate_lab.studies.passivity.result import Ran
from palpate_lab.studies.passivity.work import BOUND, SECONDS, Case, port

WALL = (1000.0, 0.010)  # stiffness [N/m] and delay [s] of the picture's wall
_PRESSES = 4


def wall() -> Case:
    """The case of the picture: a device like an MTM along one axis; a light hand presses 6 mm deep four times."""
    o = _verify.AxisOptions()
    o.mass, o.damping, o.coulomb, o.rate, o.quantum = 0.5, 0.3, 0.1, 1000.0, 1e-5
    o.K, o.delay = WALL
    hand = PRESETS["light"]
    o.hand_mass, o.hand_damping, o.hand_stiffness = hand.mass, hand.damping, hand.stiffness
    t = np.arange(round(SECONDS * o.rate)) / o.rate
    return Case(o, list(0.004 - 0.010 * np.cos(2 * np.pi * _PRESSES * t / SECONDS)))


def draw(found: list[Ran], folder: Path) -> Path:
    """Draw the picture into ``folder``; returns the file."""
    path = folder / "passivity.png"
    png(lambda canvas: _picture(found, canvas), path)
    return path


def _picture(found: list[Ran], canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 7.0), layout="constrained")
    panels = figure.subplots(2, 2)
    _wall(panels[0, 0], panels[1, 0])
    _energies(panels[0, 1], found)
    _changes(panels[1, 1], found)
    return figure


def _wall(energy: Axes, force: Axes) -> None:
    case = wall()
    for mode, color, label in (("off", CAP, "layer off"), ("observer", FORCE, "layer on")):
        _, rows = case.run(mode, SECONDS)
        energy.plot(rows[:, 0], 1e3 * port(case.axis, rows)[1], color=color, lw=1.3, label=label)
        force.plot(rows[:, 0], -rows[:, 3], color=color, lw=1.0, label=label)
    energy.axhline(-1e3 * BOUND, color=MUTED, lw=0.9, ls=(0, (5, 3)))
    energy.annotate(
        "-1 mJ",
        (SECONDS, -1e3 * BOUND),
        ha="right",
        xytext=(0, -11),
        textcoords="offset points",
        fontsize=8,
        color=MUTED,
    )
    title = f"{WALL[0]:g} N/m, {1e3 * WALL[1]:g} ms of delay, light hand: energy the hand has put in"
    energy.set_title(title, loc="left")
    energy.set_ylabel("port, device counted [mJ]")
    energy.legend()
    force.set(xlabel="time [s]", ylabel="force commanded [N]")
    force.set_ylim(0, 3.7)
    force.legend(ncols=2, loc="upper right")


def _energies(axes: Axes, found: list[Ran]) -> None:
    lag = np.array([f["K_N_per_m"] * (f["delay_s"] + 0.5 / f["rate_Hz"]) for f in found])
    runs = ([f["off"] for f in found], CAP, "layer off"), ([f["observer"] for f in found], FORCE, "layer on")
    for outcomes, color, label in runs:
        lowest = 1e3 * np.array([o["port_J"] for o in outcomes])
        axes.scatter(lag, lowest, s=3, color=color, alpha=0.5, lw=0, label=label, rasterized=True)
    axes.axhline(-1e3 * BOUND, color=MUTED, lw=0.9, ls=(0, (5, 3)))
    axes.set(xscale="log", xlabel="K (delay + T / 2) [N s/m]", ylabel="lowest port energy [mJ]")
    axes.set_yscale("symlog", linthresh=0.1)
    axes.set_ylim(top=0.1)
    axes.set_title(f"{len(found)} random runs, device counted", loc="left")
    axes.legend(markerscale=4, loc="lower left")


def _changes(axes: Axes, found: list[Ran]) -> None:
    for some, color, label in (
        (found, MUTED, "all"),
        ([f for f in found if f["certified"]], INK, "certified with their hand"),
        ([f for f in found if f["passive"]], DEPTH, "passive for every hand"),
        ([f for f in found if f["silent"]], FORCE, "and the spring pays for taking it back"),
    ):
        change = np.sort([100 * f["observer"]["change"] for f in some])
        share = 100 * np.arange(1, len(change) + 1) / max(len(change), 1)
        axes.step(np.maximum(change, 1e-2), share, color=color, lw=1.4, label=f"{label} ({len(change)})")
    axes.axvline(1.0, color=INK, lw=0.8, ls=(0, (5, 3)))
    axes.set(xscale="log", xlabel="largest change of the force by the layer [%]", ylabel="share of the runs [%]")
    axes.set_ylim(0, 102)
    axes.legend(loc="lower right")
