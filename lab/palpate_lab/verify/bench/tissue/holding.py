"""Smoothness of the force: noise at hold and jumps from tick to tick, up to 60 kPa.

A jump is the change of the force in a tick beyond what the motion of the tool explains: the second difference, because
the motion and the tissue are smooth. The press ends at a force that palpation uses, and the sphere then slides with
friction over several elements.
"""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate_lab.verify.bench.tissue.bodies import POISSON, PRONY, TICK, Lab, pressed
from palpate_lab.verify.bench.tissue.rows import Found, at_most

YOUNGS = (5e3, 20e3, 60e3)  # [Pa]
LAYER = (30e-3, 10e-3, 40e-3)  # thickness, cell, half width [m]
RADIUS, DEPTH = 5e-3, 3e-3  # [m]
SLIDE, PERIOD = 0.01, 2.0  # amplitude [m] and period [s] of the slide
FRICTION = 0.2


def path(short: bool = False) -> tuple[Array, int]:
    """Positions (n, 3) of a press, a hold and a slide [m], and the number of ticks before the slide."""
    down = pressed(RADIUS, DEPTH, (0.002, 0.001), 0.3, 0.5)
    slide = np.repeat(down[-1:], 200 if short else 2000, axis=0)
    slide[:, 0] += SLIDE * np.sin(2.0 * np.pi / PERIOD * TICK * np.arange(len(slide))) ** 3
    return np.concatenate([down, slide]), len(down)


def measure(lab: Lab, short: bool = False) -> Found:
    """Noise and jumps for each modulus; the short version has the stiffest tissue only."""
    tips, start = path(short)
    table = []
    for young in YOUNGS[-1:] if short else YOUNGS:
        soft = lab.layer(*LAYER, young=young, poisson=POISSON, prony=PRONY)
        force = lab.touch(soft, tips, radius=RADIUS, friction=FRICTION).force
        hold = force[start - 200 : start, 2]
        t = np.arange(len(hold))
        drift = np.polyval(np.polyfit(t, hold, 3), t)  # relaxation is no noise
        jumps = np.linalg.norm(np.diff(force, n=2, axis=0), axis=1)
        table.append(
            {
                "young": young,
                "force": float(force[:, 2].max()),
                "noise": float(np.ptp(hold - drift)),
                "change": float(np.linalg.norm(np.diff(force, axis=0), axis=1).max()),
                "jump": float(jumps.max()),
            }
        )
    rows = (
        at_most("noise at hold, peak to peak", max(row["noise"] for row in table), 0.01, "N"),
        at_most("jump in a tick, press and slide", max(row["jump"] for row in table), 0.03, "N"),
        at_most("change in a tick, press and slide", max(row["change"] for row in table), 0.03, "N"),
    )
    return Found(rows, {"smoothness": table})
