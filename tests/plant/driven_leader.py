"""A simulated leader whose handle a hand moves at a constant velocity."""

import numpy as np
from plant_constants import DT, Q0

from palpate import _core

ZERO = np.zeros(7)


def driven_leader(mtm, options, V, seconds, stiffness, damping, settled):
    """Yields the leader every millisecond after `settled` [ms]; V (6,) is the twist of the hand's path [m/s, rad/s]."""
    hand = _core.HandOptions()
    hand.stiffness, hand.damping = stiffness, damping
    leader = _core.Leader(mtm, options, hand)
    leader.reset(Q0)
    X = mtm.fk(Q0)
    for k in range(round(seconds * 1e3)):
        leader.command(ZERO, mtm.holding(leader.q), ZERO)
        for _ in range(10):
            X[:3, 3] += V[:3] * DT
            leader.step(DT, X, V)
        if k > settled:
            yield leader
