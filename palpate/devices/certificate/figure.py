"""The stability boundary in the plane of damping and stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.base.plotting.style import CAP, DEPTH, FORCE, INK, MUTED, Canvas, png
from palpate.devices.certificate.certificate import Certificate
from palpate.devices.certificate.words import number

_COLOURS = {"stable": "#4f8f4f", "marginal": CAP, "unstable": FORCE}


@dataclass(frozen=True)
class Point:
    """A rendered wall in the plane of damping and stiffness."""

    name: str
    B: float
    """Damping [N s/m]."""
    K: float
    """Stiffness [N/m]."""
    verdict: str


def draw(certificate: Certificate, points: Sequence[Point], title: str, path: Path) -> Path:
    """Draw the stability boundary and the points into the PNG file ``path``."""
    png(lambda canvas: _picture(certificate, points, title, canvas), path)
    return path


def _picture(certificate: Certificate, points: Sequence[Point], title: str, canvas: Canvas) -> Figure:
    figure = Figure(figsize=(0.62 * canvas.width, 4.2), layout="constrained")
    axes = figure.add_subplot()
    B, K = certificate.boundary(96)
    plane(axes, B, K)
    for name, k in certificate.bounds.items():
        if name == "colgate_brown_with_hand" and 0.0 < k < np.inf:
            axes.plot(certificate.B, k, marker="_", ms=14, mew=1.5, color=MUTED, ls="", label="passive with this hand")
    if np.isfinite(certificate.k_max):
        limit = f"limit, {number(certificate.k_max)} N/m"
        axes.plot(certificate.B, certificate.k_max, marker="^", color=INK, ls="", label=limit)
    for point in points:
        axes.plot(point.B, point.K, marker="o", ms=6, color=_COLOURS[point.verdict], ls="",
                  label=f"{point.name}: {point.verdict}")  # fmt: skip
    top = max([1.15 * float(K[np.isfinite(K)].max(initial=0.0)), *(1.3 * p.K for p in points), 1.0])
    axes.set(xlim=(0.0, B[-1]), ylim=(0.0, top), title=title)
    axes.legend(loc="upper right")
    return figure


def plane(axes: Axes, B: np.ndarray, K: np.ndarray, label: str = "stability boundary", color: str = DEPTH) -> None:
    """Draw one boundary and shade its stable side."""
    shown = np.where(np.isfinite(K), K, np.nan)
    axes.fill_between(B, 0.0, shown, color=color, alpha=0.10, lw=0)
    axes.plot(B, shown, color=color, lw=1.6, label=label)
    axes.set(xlabel="damping of the wall B [N s/m]", ylabel="stiffness of the wall K [N/m]")
