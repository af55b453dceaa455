"""The picture of ``palpate study certificate``: predicted against simulated, and the boundary in the K-B plane."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.arm.hands import PRESETS
from palpate.base.plotting.style import CAP, DEPTH, FORCE, INK, JOINTS, MUTED, Canvas, png
from palpate.devices.certificate import DeviceModel
from palpate.devices.certificate.classical import colgate_brown
from palpate.devices.certificate.figure import plane
from palpate_lab.studies.certificate.result import Row
from palpate_lab.studies.certificate.work import WITHIN, simulated_limit

Rows = list[Row]

DEVICE = {"mass": 0.3, "damping": 0.6, "rate": 1000.0, "filter": 100.0, "quantum": 1e-5, "friction": 0.05}
DELAYS = (0.003, 0.006, 0.009, 0.015)  # [s]
_TRIED = 0.003  # the delay whose boundary is also simulated [s]
_DAMPINGS = (0.0, 4.0, 8.0, 14.0, 20.0, 26.0)  # [N s/m]


def draw(rows: Rows, folder: Path) -> Path:
    """Draw the picture into ``folder``; returns the file."""
    path = folder / "certificate.png"
    png(lambda canvas: picture(rows, canvas), path)
    return path


def picture(rows: Rows, canvas: Canvas) -> Figure:
    """Predicted over simulated limits, their relative error, and the boundary of one device with several delays."""
    figure = Figure(figsize=(canvas.width, 4.0), layout="constrained")
    grid = figure.add_gridspec(2, 3, width_ratios=[1.0, 0.8, 1.25])
    _scatter(figure.add_subplot(grid[:, 0]), rows)
    _errors(figure.add_subplot(grid[0, 1]), rows)
    _classical(figure.add_subplot(grid[1, 1]), rows)
    _plane(figure.add_subplot(grid[:, 2]))
    return figure


def _scatter(axes: Axes, rows: Rows) -> None:
    simulated = np.array([row["simulated_N_per_m"] for row in rows])
    span = np.array([simulated.min() / 1.5, simulated.max() * 1.5])
    axes.fill_between(span, (1 - WITHIN) * span, (1 + WITHIN) * span, color=MUTED, alpha=0.25, lw=0,
                      label=f"within {100 * WITHIN:.0f} %")  # fmt: skip
    axes.plot(simulated, [row["linear_N_per_m"] for row in rows], ls="", marker=".", ms=3, color=CAP,
              label="linear part alone")  # fmt: skip
    axes.plot(simulated, [row["predicted_N_per_m"] for row in rows], ls="", marker=".", ms=3, color=DEPTH,
              label="certificate")  # fmt: skip
    axes.set(xscale="log", yscale="log", xlim=span, ylim=span, xlabel="simulated largest stiffness [N/m]",
             ylabel="predicted [N/m]")  # fmt: skip
    axes.set_title(f"{len(rows)} random devices (simulated)", fontsize=8.5, loc="left")
    axes.legend(loc="upper left")


def _errors(axes: Axes, rows: Rows) -> None:
    error = 100 * np.array([row["error"] for row in rows])
    axes.hist(np.clip(error, -8, 8), bins=np.linspace(-8, 8, 65).tolist(), color=DEPTH)
    for x in (-100 * WITHIN, 100 * WITHIN):
        axes.axvline(x, color=FORCE, lw=0.9, ls=(0, (4, 3)))
    axes.set(yscale="log", xlabel="predicted / simulated - 1 [%]", ylabel="devices")


def _classical(axes: Axes, rows: Rows) -> None:
    """Ratio of the classical bounds to the simulated limit."""
    names = {"colgate_brown_with_hand": "passive, hand's damping counted", "abbott_okamura": "Abbott and Okamura"}
    for (name, label), color in zip(names.items(), (INK, JOINTS[2]), strict=True):
        share = np.array([row[f"{name}_N_per_m"] / row["simulated_N_per_m"] for row in rows])
        axes.plot(np.sort(share), np.linspace(0, 100, len(share)), color=color, label=label)
    axes.set(xscale="symlog", xlabel="classical bound / simulated limit [-]", ylabel="devices below [%]")
    axes.set_xscale("symlog", linthresh=0.1)
    axes.set_xlim(0.0, 1e3)
    axes.axvline(1.0, color=FORCE, lw=0.9, ls=(0, (4, 3)))
    axes.legend(loc="lower right", fontsize=6.5)


def _plane(axes: Axes) -> None:
    hand = PRESETS["normal"]
    for delay, color in zip(DELAYS, (JOINTS[2], DEPTH, CAP, FORCE), strict=True):
        device = DeviceModel(delay=delay, hand=hand, **DEVICE)
        loop = device.loop(hand)
        B = np.linspace(0.0, min(loop.B_max, 60.0) * (1 - 1e-6), 60)
        plane(axes, B, np.array([loop.K_max(float(b))[0] for b in B]), f"{1e3 * delay:g} ms of delay", color)
        if delay == _TRIED:
            rng = np.random.default_rng(0)
            tried = [b for b in _DAMPINGS if b < loop.B_max]
            K = [simulated_limit(device, b, loop.K_max(b)[0], rng) for b in tried]
            axes.plot(tried, K, ls="", marker="o", ms=4, mfc="none", color=color, label="the same, simulated")
    passive = np.array([0.0, DEVICE["damping"] + hand.damping])
    axes.plot(passive, [colgate_brown(passive[1], b, 1e-3, _TRIED) for b in passive], color=INK, lw=0.9,
              ls=(0, (4, 2)), label=f"passive, {1e3 * _TRIED:g} ms (Colgate and Brown)")  # fmt: skip
    axes.set_ylim(0, 14000)
    axes.set_title("one device, hand 'normal', 1 kHz: stable below its line", fontsize=8.5, loc="left")
    axes.legend(loc="upper left", fontsize=6.5)
