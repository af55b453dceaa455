"""Instruments that step together: actions become goals, the haptic cycle runs between them, and its ticks are read.

The computation of an instrument depends on its own seed and actions only, and not on the number of the others or of
threads.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise
from typing import Literal

import numpy as np
from gymnasium.error import ResetNeeded

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.gym.world import RATE, Motion, World, cycle_at
from palpate.record.ticks import TICK_DOUBLES, Ticks, as_ticks
from palpate.scene import held, soft
from palpate.scene.rig import Rig
from palpate.scene.together import capsules, join_instruments
from palpate.session.tasks.hand import OPEN
from palpate.world.bodies.engine import World as Engine

Action = Literal["twist", "pose"]


class Instruments:
    """N worlds with the h instruments of a scene's pairs each, h = 1 for a scene without pairs.

    Args:
        world: the scene.
        n: number of worlds.
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
        self.h = h = len(world.rigs)
        self.rigs: list[Rig] = [world.plain] * n  #: of the first pair of each world
        self.engines: list[Engine | None] = [None] * n  #: the rigid bodies of each world; None: it has none
        self._cycles: list[_core.DeviceCycle | None] = [None] * (n * h)
        self._p0, self._R0 = np.zeros((n, h, 3)), np.tile(np.eye(3), (n, h, 1, 1))
        self._goal = np.zeros((n, h, 7))  # from the start: displacement, rotation vector, pinch angle
        self._t = np.zeros(n)
        self._rows, self._felt = np.zeros((n * h, TICK_DOUBLES)), np.zeros(n * h)
        self._limit = np.repeat([motion.reach, motion.tilt], 3)
        self._pool = ThreadPoolExecutor(min(workers, n), "palpate-gym") if min(workers, n) > 1 else None
        ends = [round(k * n / min(workers, n)) for k in range(min(workers, n) + 1)]
        self._chunks = [slice(a, b) for a, b in pairwise(ends)]

    @property
    def low_high(self) -> tuple[Array, Array]:
        """Limits of an action (6,), or (h * 7,) with a pinch: 0 closes the jaws, and 1 opens them."""
        m = self.motion
        high = np.repeat([m.speed, m.turn] if self.action == "twist" else [m.reach, m.tilt], 3)
        if not self.world.pinches:
            return -high, high
        return np.tile(np.append(-high, 0.0), self.h), np.tile(np.append(high, 1.0), self.h)

    def start(self, i: int, rigs: tuple[Rig, ...], X_WT: Array | None = None) -> None:
        """Begin anew with world i in a scene, with the first tool at a pose X_WT (4, 4).

        Raises:
            MissingExtraError: MuJoCo is missing, which moves the bodies of the scene.
        """
        if self.h > 1:  # the tools of a world press the same soft bodies, and those of other worlds do not
            snapshot = soft.shared(rigs[0].snapshot)
            rigs = tuple(replace(rig, snapshot=snapshot) for rig in rigs)
        self.rigs[i] = rigs[0]
        cycles = []
        for k, rig in enumerate(rigs):
            cycle, X = cycle_at(rig, X_WT if k == 0 else None)
            cycles.append(cycle)
            self._p0[i, k], self._R0[i, k] = X[:3, 3], X[:3, :3]
        if self.h > 1:
            law = self.world.scene.instruments
            join_instruments(cycles, [capsules(rig) for rig in rigs], law.stiffness, law.damping)
        self.engines[i] = held.join(dict(zip(self.world.names, rigs, strict=True)), cycles)
        self._cycles[i * self.h : (i + 1) * self.h] = cycles
        self._goal[i], self._t[i] = 0.0, 0.0
        self._goal[i, :, 6] = OPEN if self.world.pinches else 0.0
        self._advance(slice(i, i + 1), self._goal)

    def step(self, actions: Array) -> None:
        """Move all instruments by actions (n, size of `low_high`), clipped to their limits, for `substeps` ticks.

        Raises:
            ValueError: the actions have another shape, or one is not a number. ResetNeeded: a world has not begun.
        """
        if None in self._cycles:
            raise ResetNeeded("no episode has begun: call reset() before step()")
        dt, m = self.substeps / RATE, self.motion
        low, high = self.low_high
        actions = np.asarray(actions, dtype=np.float64)
        if actions.shape != (self.n, len(low)) or np.isnan(actions).any():
            what = f"actions are (n, {len(low)}) numbers with n = {self.n}"
            raise ValueError(f"{what}; got {actions.shape}: {actions.ravel()[:6]}")
        wanted = np.clip(actions, low, high).reshape(self.n, self.h, -1)
        goal, target = self._goal, self._goal.copy()
        most = dt * np.repeat([m.speed, m.turn], 3)
        by = wanted[..., :6]
        move = dt * by if self.action == "twist" else np.clip(by - goal[..., :6], -most, most)
        target[..., :6] = np.clip(goal[..., :6] + move, -self._limit, self._limit)
        if self.world.pinches:
            target[..., 6] += np.clip(OPEN * wanted[..., 6] - goal[..., 6], -dt * m.pinch, dt * m.pinch)
        if self._pool is None:
            self._advance(slice(0, self.n), target)
        else:
            list(self._pool.map(lambda chunk: self._advance(chunk, target), self._chunks))
        self._goal = target

    @property
    def ticks(self) -> Ticks:
        """Newest tick of each instrument (n,); (n, h) with several pairs."""
        ticks = as_ticks(self._rows)
        return ticks if self.h == 1 else ticks.reshape(self.n, self.h)

    @property
    def felt(self) -> Array:
        """Largest force that each hand would have felt during the last step (n,), or (n, h), after all caps [N]."""
        return self._felt.copy() if self.h == 1 else self._felt.reshape(self.n, self.h).copy()

    @property
    def times(self) -> Array:
        """Time of each world (n,) [s]."""
        return self._t.copy()

    @property
    def goals(self) -> Array:
        """Goal of each tool from its start: displacement [m] and rotation vector [rad], in W; (n, 6), or (n, h, 6)."""
        goals = self._goal[..., :6]
        return np.array(goals[:, 0] if self.h == 1 else goals)

    @property
    def pinches(self) -> Array:
        """Pinch angle of each hand (n, h) [rad]."""
        return np.array(self._goal[..., 6])

    @property
    def starts(self) -> Array:
        """Position of each tool at its start, in W [m]; (n, 3), or (n, h, 3)."""
        return self._p0[:, 0] if self.h == 1 else self._p0

    def close(self) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def _advance(self, chunk: slice, targets: Array) -> None:
        """Run the cycles of some worlds along straight lines from the present goals to targets (n, h, 7)."""
        hands = slice(chunk.start * self.h, chunk.stop * self.h)
        cycles = [cycle for cycle in self._cycles[hands] if cycle is not None]
        engines = [engine.core_bodies for engine in self.engines[chunk] if engine is not None]
        goals, ends = (np.ascontiguousarray(one[chunk].reshape(-1, 7)) for one in (self._goal, targets))
        t, rows, felt = self._t[chunk], self._rows[hands], self._felt[hands]
        _core.glide_together(cycles, engines, t, 1.0 / RATE, self.substeps, goals, ends, rows, felt)
        t += self.substeps / RATE
