"""The tool sphere as three springs and dampers (Fig 7), and the condition of the leader's Jacobian."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm
from palpate.record.ticks import Ticks

_SAMPLES = 400
_LENGTH, _COILS = 110.0, 8  # length of a drawn spring at rest [px], and its number of coils


def table(ticks: Ticks) -> str:
    """HTML table of the springs and dampers at the deepest contact of ticks (n,), with their deflections and forces."""
    row = ticks[int(np.argmax(ticks["depth"]))]
    if not row["depth"] > 0:
        return "<p>Nothing was touched, so no spring was compressed.</p>"
    longest = 1.6 * float(np.abs(row["delta_x"]).max())  # rest length at which the drawn compression is 60 % at most
    lines = []
    for axis, name in enumerate("xyz"):
        dx, spring, damper = (float(row[key][axis]) for key in ("delta_x", "F_spring_W", "F_damping_W"))
        lines.append(
            f"<tr><td>{name}</td><td>{_spring(1.0)}</td><td>{_spring(1.0 - abs(dx) / longest)}</td>"
            f'<td class="value">{1e3 * dx:+.2f} mm</td><td class="value">{spring:+.3f} N</td>'
            f'<td class="value">{damper:+.3f} N</td><td class="value">{spring + damper:+.3f} N</td></tr>'
        )
    head = (
        f"<tr><th>axis of W</th><th>at rest</th><th>at t = {float(row['t']):.2f} s</th><th>deflection</th>"
        "<th>spring K δx</th><th>damper −B ẋ</th><th>sum</th></tr>"
    )
    return f'<div class="scroll"><table class="signals">{head}{"".join(lines)}</table></div>'


def _spring(share: float) -> str:
    """SVG of a coil spring whose length is `share` of its rest length; its fixed end is on the left."""
    x = 4.0 + np.linspace(0.0, share * _LENGTH, 2 * _COILS + 1)
    y = 9.0 + 6.0 * np.array([0.0, *([1.0, -1.0] * _COILS)[:-1], 0.0])
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    end = x[-1]
    return (
        f'<svg width="{_LENGTH + 8:g}" height="18" role="img" aria-label="spring at {100 * share:.0f} % of its length">'
        f'<path d="M4 1V17M{end:.1f} 1V17" stroke="currentColor" stroke-width="2"/>'
        f'<polyline points="{points}" fill="none" stroke="#c8102e" stroke-width="1.3"/></svg>'
    )


def conditioning(ticks: Ticks, arm: Arm) -> NDArray[np.float64]:
    """Condition numbers (k,) of the 3x3 Jacobian of the wrist centre (section 2.3), for ticks sampled from a run.

    1 is isotropic: a torque makes the same force in every direction. Large values are near a singular pose. `arm` is
    the leader.
    """
    rows = np.unique(np.linspace(0, len(ticks) - 1, min(_SAMPLES, len(ticks))).astype(np.int64))
    return np.array([np.linalg.cond(arm.jacobian(q[: arm.n])[:3, :3]) for q in ticks["q"][rows]])
