"""A simulated operator does an errand in a simulation, in closed loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.operators.errand import Errand
from palpate.operators.operator import STEP, Operator
from palpate.record.ticks import as_ticks

EVERY = 4
"""Rows of the cycle per row of a trial."""
_THERE = 1e-3  # so near to its end a path is done [m]


@dataclass(frozen=True)
class Trial:
    """What a simulated operator did, every `EVERY` rows of the haptic cycle."""

    t: Array
    """(n,) [s]"""
    p_WT: Array
    """(n, 3) tool [m]."""
    F_T: Array
    """(n,) of the tool's spring contact with what it touches [N]."""
    F_hand: Array
    """(n,) of the device on the hand [N]."""
    done: bool
    """the end of the path was reached in time."""


def perform(sim: _core.Simulation, operator: Operator, errand: Errand, X_WL: Array, scale: float, most: float) -> Trial:
    """Let an operator do an errand in a simulation that stands at its beginning, at 1000 cycles a second.

    Args:
        sim: fresh; its hand has no path of its own.
        operator: fresh, too.
        errand: what to do.
        X_WL: (4, 4) base of the leader.
        scale: tool motion per hand motion.
        most: longest that it may take [s].
    """
    n = round(STEP * 1000)
    R_WL, hand, at = X_WL[:3, :3], np.zeros(3), 0
    kept: list[Array] = []
    ramp = (np.arange(1, n + 1) / n)[:, None]
    rows = as_ticks(sim.run(n))
    while True:
        now = rows[-1]
        seen = operator.x
        aim, at = errand.aim(now["p_WT"] if seen is None else seen, at, operator.preview)
        done = aim.ahead < _THERE
        if done or len(kept) * STEP > most:
            break
        F_T = errand.stiffness * float(now["depth"])
        step = STEP * operator.lead(now["p_WT"], F_T, R_WL @ now["F_H_L"], aim, scale)
        rows = as_ticks(sim.run(n, hand + ramp * step))
        hand = hand + step
        some = rows[::EVERY]
        kept.append(np.column_stack([some["t"], some["p_WT"], some["depth"], np.linalg.norm(some["F_H_L"], axis=1)]))
    all_ = np.concatenate(kept)
    return Trial(all_[:, 0], all_[:, 1:4], errand.stiffness * all_[:, 4], all_[:, 5], done)
