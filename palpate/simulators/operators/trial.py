"""Trial of a simulated operator: a task performed in a simulation, in closed loop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.record.ticks import Ticks, as_ticks
from palpate.simulators.operators.errand import Errand
from palpate.simulators.operators.operator import STEP, Operator

EVERY = 4
"""Number of haptic cycles per row of a trial."""
_TOLERANCE = 1e-3  # a path is done when the remaining length is less [m]


@dataclass(frozen=True)
class Trial:
    """Motion and forces of a simulated operator, every `EVERY` haptic cycles."""

    t: Array
    """(n,) time [s]."""
    p_WT: Array
    """(n, 3) position of the tool in W [m]."""
    F_T: Array
    """(n,) contact force of the tool: stiffness times depth [N]."""
    F_hand: Array
    """(n,) size of the force of the device on the hand [N]."""
    done: bool
    """True if the end of the path was reached in time."""
    q: Array = field(default_factory=lambda: np.zeros((0, 0)))
    """(n, k) joint positions of the follower, with its jaw where it has one [rad, m]."""


def perform(
    sim: _core.Simulation,
    operator: Operator,
    errand: Errand,
    X_WL: Array,
    scale: float,
    most: float,
    keep: Callable[[Ticks], None] = lambda ticks: None,
) -> Trial:
    """Let an operator perform a task in a simulation at 1000 cycles per second.

    Args:
        sim: fresh simulation; its hand has no path of its own.
        operator: fresh operator.
        errand: the task.
        X_WL: (4, 4) pose of the leader's base.
        scale: tool motion per hand motion.
        most: time limit [s].
        keep: called with every tick of the trial, 20 at a time.
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
        done = aim.ahead < _TOLERANCE
        if done or len(kept) * STEP > most:
            break
        F_T = errand.force(now)
        step = STEP * operator.lead(now["p_WT"], F_T, R_WL @ now["F_H_L"], aim, scale)
        rows = as_ticks(sim.run(n, hand + ramp * step))
        hand = hand + step
        keep(rows)
        some = rows[::EVERY]
        F = np.linalg.norm(some["F_H_L"], axis=1)
        kept.append(np.column_stack([some["t"], some["p_WT"], some["depth"], F, some["q_follower"]]))
    all_ = np.concatenate(kept)
    return Trial(all_[:, 0], all_[:, 1:4], errand.stiffness * all_[:, 4], all_[:, 5], done, all_[:, 6:])
