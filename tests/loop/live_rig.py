"""A simulation whose floor is a live object, with targets that a test sets every 10 ms, as a session does."""

from __future__ import annotations

import numpy as np
from loop_rig import floor, simulation

from palpate import _core
from palpate.record.ticks import as_ticks

PERIOD = 10  # ticks between two targets


def pose(p=(0.0, 0.0, 0.0)):
    X = np.eye(4)
    X[:3, 3] = p
    return X


def live_floor(K=400.0, B=0.0, mu=0.0, motion=None, **limits):
    """The floor of the rig: live, or with a prescribed motion."""
    fixed = floor((K,) * 3, (B,) * 3, mu).objects[0]
    if motion is not None:
        return _core.Snapshot([_core.Object("floor", fixed.surface, np.eye(4), fixed.material, motion=motion)])
    limits = {"speed": 0.2, "turn": 1.0, "acceleration": 2.0} | limits
    live = _core.LiveOptions(**limits)
    return _core.Snapshot([_core.Object("floor", fixed.surface, np.eye(4), fixed.material, live=live)])


class Driven:
    """A simulation with targets from a function of time, which returns pose, velocity and whether it is lost."""

    def __init__(self, target, scene=None, path=None, **changes):
        self.sim, self.target, self.k = simulation(scene or live_floor(), path, **changes), target, 0

    def run(self, seconds):
        """Ticks of the next seconds; their number is a multiple of PERIOD."""
        rows = []
        for _ in range(round(seconds * 1000 / PERIOD)):
            given = self.target(1e-3 * self.k)
            if given is not None:
                X, V, lost = given
                targets = _core.LiveTargets()
                targets.add(1e-3 * self.k, X, V, lost)
                self.sim.set_live(targets)
            rows.append(self.sim.run(PERIOD))
            self.k += PERIOD
        return as_ticks(np.concatenate(rows))
