"""The figure of an identified hand: measured and fitted impedance over frequency."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from palpate.arm.identify.hand import HandFit
from palpate.base.plotting.style import DEPTH, FORCE, Canvas, png


def save(found: HandFit, path: Path) -> None:
    """Write the picture (PNG)."""
    png(lambda canvas: _impedance(found, canvas), path)


def _impedance(found: HandFit, canvas: Canvas) -> Figure:
    f = np.geomspace(0.8 * found.f.min(), 1.2 * found.f.max(), 300)
    Z = found.impedance(f)
    m, b, k = found.value
    figure = Figure(figsize=(0.7 * canvas.width, 5.4), layout="constrained")
    size, phase = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    size.loglog(found.f, np.abs(found.Z), "o", ms=4, color=DEPTH, label="measured")
    size.loglog(f, np.abs(Z), color=FORCE, label=f"fitted: {m:.3g} kg, {b:.3g} N s/m, {k:.4g} N/m")
    size.set_ylabel("force per motion [N/m]")
    size.set_title("Impedance of the hand along the push", loc="left")
    size.legend()
    phase.semilogx(found.f, np.degrees(np.unwrap(np.angle(found.Z))), "o", ms=4, color=DEPTH)
    phase.semilogx(f, np.degrees(np.angle(Z)), color=FORCE)
    phase.set(xlabel="frequency [Hz]", ylabel="phase [deg]")
    for axes in (size, phase):
        axes.grid(True, which="both")
    return figure
