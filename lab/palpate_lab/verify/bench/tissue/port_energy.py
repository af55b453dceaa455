"""Energy that a tool gets from tissue in the cycle: presses, retreats and slides with three Prony terms."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate_lab.verify.bench.tissue.bodies import PRONY, TICK, Lab
from palpate_lab.verify.bench.tissue.holding import YOUNGS
from palpate_lab.verify.bench.tissue.rows import Found, at_least

LAYER = (30e-3, 10e-3, 30e-3)  # thickness, cell, half width [m]
RADIUS = 5e-3  # [m]


def taken(force: Array, tips: Array) -> Array:
    """Energy (n,) that the tool has put into the surface [J]; the force of a tick acts until the next one."""
    steps = -(force[:-1] * np.diff(tips, axis=0)).sum(axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def measure(lab: Lab, short: bool = False) -> Found:
    """The least energy balance over all times, for each modulus."""
    t = TICK * np.arange(600 if short else 3000)
    x, y = 0.004 * np.sin(17.0 * t), 0.003 * np.sin(11.0 * t)
    tips = np.stack([x, y, RADIUS - 2e-3 * (1.0 - np.cos(23.0 * t))], axis=1)
    table = []
    for young in YOUNGS[-1:] if short else YOUNGS:
        soft = lab.layer(*LAYER, young=young, prony=PRONY)
        energy = taken(lab.touch(soft, tips, radius=RADIUS, friction=0.3).force, tips)
        table.append({"young": young, "least": float(energy.min()), "largest": float(energy.max())})
    rows = (at_least("energy from the tool, least balance", 1e3 * min(row["least"] for row in table), -0.5, "mJ"),)
    return Found(rows, {"port_energy": table})
