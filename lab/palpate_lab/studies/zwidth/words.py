"""Terminal output of ``palpate study zwidth``: the stiffest stable walls."""

from __future__ import annotations

import numpy as np
from rich.table import Table

from palpate.base.arrays import Array
from palpate.devices.certificate import DeviceModel
from palpate_lab.studies.zwidth.result import Panel, StudyResult


def largest(panel: Panel) -> Array:
    """Stiffness up to which every simulated wall is stable, per damping (n,) [N/m]; 0 if no wall is stable."""
    K, stable = np.array(panel["K_N_per_m"]), np.array(panel["stable"])
    count = np.where(stable.all(axis=1), len(K), stable.argmin(axis=1))
    return np.where(count > 0, K[count - 1], 0.0)


def words(device: DeviceModel) -> str:
    """The device's parameters in one line."""
    return (
        f"{device.mass:.3g} kg, {device.damping:.3g} N s/m, dry friction {device.friction:.3g} N, "
        f"resolution {1e6 * device.quantum:.3g} um, hand {device.hands[0].name}"
    )


def table(found: StudyResult) -> Table:
    """The stiffest wall per rate and delay, its damping, and the analytic bounds at this damping."""
    out = Table(title="The stiffest stable wall, simulated", box=None, padding=(0, 2, 0, 0), title_justify="left")
    heads = ("rate\nHz", "delay\nms", "least damping\nK N/m", "best damping\nK N/m", "\nB N s/m", "certified\nthere")
    for head in (*heads, "Colgate-\nBrown, least"):
        out.add_column(head, justify="right")
    for panel in found["panels"]:
        K = largest(panel)
        best = int(K.argmax())
        near = int(np.abs(np.log(panel["line_B_N_s_per_m"]) - np.log(panel["B_N_s_per_m"][best])).argmin())
        boundary = panel["boundary_N_per_m"][near]
        out.add_row(
            f"{panel['rate_Hz']:g}", f"{1e3 * panel['delay_s']:g}", f"{K[0]:.0f}", f"{K[best]:.0f}",
            f"{panel['B_N_s_per_m'][best]:.3g}", "none" if boundary is None else f"{boundary:.0f}",
            f"{panel['colgate_brown_N_per_m'][0]:.0f}",
        )  # fmt: skip
    return out
