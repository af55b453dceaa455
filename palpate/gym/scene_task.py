"""The task of a scene, such as `peg_transfer`, as a task of the environments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.gym.instruments import Instruments
from palpate.gym.world import World
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig
from palpate.session.tasks import Judge, TaskResult, judge_in, look
from palpate.session.tasks.hand import OPEN

_CLOSED = 0.5 * OPEN  # pinch angle below which a closing hand marks a place [rad]


class SceneTask:
    """Do what the section `task` of the scene asks for, scored by its judge, who looks once in every step.

    The reward of a step is ten times the share of the task that was done in it, minus 1 for each body that was dropped
    and for each other error, and 10 for the success. In a task that hides a lump, closing the pinch of the first hand
    marks the place, as a person does by the pedal coag. The observation `goal` tells where the task goes on: a free
    place, the next point of the wire or the next gate; it shows zeros for a hidden lump.
    """

    def __init__(self) -> None:
        self.goals = np.zeros((0, 3))
        self._instruments: Instruments | None = None

    def begin(self, n: int, dt: float, world: World) -> None:
        """Prepare for n worlds.

        Raises:
            PalpateError: the scene has no task.
        """
        if world.scene.task is None:
            raise PalpateError("the scene has no section task", mend="name the task press or find, or another scene")
        self.goals, self._judges = np.zeros((n, 3)), [judge_in(world.plain) for _ in range(n)]
        self._marks: list[list[Array]] = [[] for _ in range(n)]
        self._earned, self._closed = np.zeros(n), np.ones(n, dtype=bool)

    def watch(self, instruments: Instruments) -> None:
        """Look at these worlds."""
        self._instruments = instruments

    def reset(self, i: int, rig: Rig, rng: np.random.Generator) -> Array | None:
        """Begin anew."""
        self._judges[i], self._marks[i] = judge_in(rig), []
        self._earned[i], self._closed[i] = 0.0, False
        self._show(i)
        return None

    def evaluate(self, ticks: Ticks, felt: Array) -> tuple[Array, NDArray[np.bool_]]:
        """What the judge of each world says."""
        assert self._instruments is not None
        instruments, n = self._instruments, len(self._judges)
        p_WT, pinches, times = ticks["p_WT"].reshape(n, -1, 3), instruments.pinches, instruments.times
        before = self._earned.copy()
        for i, judge in enumerate(self._judges):
            closed = bool(pinches[i, 0] < _CLOSED)
            if closed and not self._closed[i]:
                self._marks[i].append(np.array(p_WT[i, 0]))
            self._closed[i] = closed
            judge.see(look(float(times[i]), np.array(p_WT[i]), instruments.engines[i], self._marks[i]))
            self._earned[i] = _earned(judge)
            self._show(i)
        return self._earned - before, np.array([judge.success for judge in self._judges])

    def _show(self, i: int) -> None:
        target = self._judges[i].target()
        self.goals[i] = 0.0 if target is None else target

    def results(self) -> list[TaskResult]:
        """The result of each world up to now."""
        return [judge.result() for judge in self._judges]


def _earned(judge: Judge) -> float:
    """Sum of the rewards up to now."""
    errors = judge.drops + sum(value for name, value in judge.errors.items() if not name.endswith("_m"))
    return 10.0 * judge.share - errors + 10.0 * judge.success
