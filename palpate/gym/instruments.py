"""Instruments that step together: actions become goals, the haptic cycle runs between them, and its ticks are read.

The computation of an instrument depends on its own seed and actions only, and not on the number of the others or of
threads.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Literal

import numpy as np
from gymnasium.error import ResetNeeded

from palpate import _core
from palpate.arrays import Array
from palpate.errors import PalpateError
from palpate.gym.world import RATE, Motion, World, cycle_at
from palpate.record.ticks import TICK_DOUBLES, Ticks, as_ticks
from palpate.scene.rig import Rig

Action = Literal["twist", "pose"]


class Instruments:
    """N instruments in worlds of their own.

    Args:
        world: the scene.
        n: number of instruments.
        action: ``twist``: velocity of the goal in W [m/s, rad/s]; ``pose``: goal as displacement and rotation vector
            from the start, in W [m, rad].
        substeps: ticks of 1 ms for each action.
        motion: limits of the motion.
        workers: threads.

    Raises:
        PalpateError: there is no thread.
    """

    def __init__(self, world: World, n: int, action: Action, substeps: int, motion: Motion, workers: int) -> None:
        if workers < 1:
            raise PalpateError(f"workers = {workers}: must be at least 1")
        self.world, self.n, self.action, self.substeps, self.motion = world, n, action, substeps, motion
        self.rigs: list[Rig] = [world.plain] * n
        self._cycles: list[_core.DeviceCycle | None] = [None] * n
        self._p0, self._R0 = np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1))
        self._p, self._r = np.zeros((n, 3)), np.zeros((n, 3))  # goal from the start: displacement, rotation vector
        self._t = np.zeros(n)
        self._rows, self._felt = np.zeros((n, TICK_DOUBLES)), np.zeros(n)
        self._limit = np.repeat([motion.reach, motion.tilt], 3)
        self._pool = ThreadPoolExecutor(min(workers, n), "palpate-gym") if min(workers, n) > 1 else None
        ends = [round(k * n / min(workers, n)) for k in range(min(workers, n) + 1)]
        self._chunks = [slice(a, b) for a, b in pairwise(ends)]

    @property
    def low_high(self) -> tuple[Array, Array]:
        """Limits (6,) of an action."""
        m = self.motion
        high = np.repeat([m.speed, m.turn] if self.action == "twist" else [m.reach, m.tilt], 3)
        return -high, high

    def start(self, i: int, rig: Rig, X_WT: Array | None = None) -> None:
        """Begin anew with instrument i in a scene, at a pose X_WT (4, 4)."""
        self.rigs[i] = rig
        self._cycles[i], X = cycle_at(rig, X_WT)
        self._p0[i], self._R0[i] = X[:3, 3], X[:3, :3]
        self._p[i], self._r[i], self._t[i] = 0.0, 0.0, 0.0
        self._advance(slice(i, i + 1), np.zeros((self.n, 6)), np.zeros((self.n, 6)))

    def step(self, actions: Array) -> None:
        """Move all instruments by actions (n, 6), which are clipped to their limits, for `substeps` ticks.

        Raises:
            ValueError: the actions have another shape, or one is not a number. ResetNeeded: an instrument has not
                begun.
        """
        if None in self._cycles:
            raise ResetNeeded("no episode has begun: call reset() before step()")
        dt, m = self.substeps / RATE, self.motion
        low, high = self.low_high
        actions = np.asarray(actions, dtype=np.float64)
        if actions.shape != (self.n, 6) or np.isnan(actions).any():
            raise ValueError(
                f"actions are (n, 6) numbers with n = {self.n}; got {actions.shape}: {actions.ravel()[:6]}"
            )
        wanted = np.clip(actions, low, high)
        goal = np.concatenate([self._p, self._r], axis=1)
        most = dt * np.repeat([m.speed, m.turn], 3)
        move = dt * wanted if self.action == "twist" else np.clip(wanted - goal, -most, most)
        target = np.clip(goal + move, -self._limit, self._limit)
        if self._pool is None:
            self._advance(slice(0, self.n), goal, target)
        else:
            list(self._pool.map(lambda chunk: self._advance(chunk, goal, target), self._chunks))
        self._p, self._r = target[:, :3].copy(), target[:, 3:].copy()

    @property
    def ticks(self) -> Ticks:
        """Newest tick of each instrument (n,)."""
        return as_ticks(self._rows)

    @property
    def felt(self) -> Array:
        """Largest force that a hand would have felt during the last step (n,), after all caps [N]."""
        return self._felt.copy()

    @property
    def goals(self) -> Array:
        """Goal of each tool from its start (n, 6): displacement [m] and rotation vector [rad], in W."""
        return np.concatenate([self._p, self._r], axis=1)

    @property
    def starts(self) -> Array:
        """Position (n, 3) of each tool at its start, in W [m]."""
        return self._p0

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def _advance(self, chunk: slice, goals: Array, targets: Array) -> None:
        """Run the cycles of some instruments along straight lines between goals (n, 6) from their starts."""
        cycles = [cycle for cycle in self._cycles[chunk] if cycle is not None]
        t, rows, felt = self._t[chunk], self._rows[chunk], self._felt[chunk]
        _core.glide_together(cycles, t, 1.0 / RATE, self.substeps, goals[chunk], targets[chunk], rows, felt)
        t += self.substeps / RATE
