"""What a grip told, as a picture: measured impedance and the fitted hand over frequency."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from palpate.calibrate.hand import HandFit


def save(found: HandFit, path: Path) -> None:
    """Write the picture (PNG)."""
    f = np.geomspace(0.8 * found.f.min(), 1.2 * found.f.max(), 300)
    Z = found.impedance(f)
    figure, (size, phase) = plt.subplots(2, 1, figsize=(7, 6), sharex=True, height_ratios=(3, 2))
    size.loglog(found.f, np.abs(found.Z), "o", ms=4, label="measured")
    m, b, k = found.value
    size.loglog(f, np.abs(Z), "-", label=f"fitted: {m:.3g} kg, {b:.3g} N s/m, {k:.4g} N/m")
    size.set_ylabel("force per motion [N/m]")
    size.legend(frameon=False)
    size.set_title("Impedance of the hand along the push", loc="left")
    phase.semilogx(found.f, np.degrees(np.unwrap(np.angle(found.Z))), "o", ms=4)
    phase.semilogx(f, np.degrees(np.angle(Z)), "-")
    phase.set_ylabel("phase [deg]")
    phase.set_xlabel("frequency [Hz]")
    for ax in (size, phase):
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(True, alpha=0.25, which="both")
    figure.tight_layout()
    figure.savefig(path, dpi=150)
    plt.close(figure)
