"""Many environments that step together, on all cores."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.base.sweep.local import cores
from palpate.gym.instruments import Action, Instruments
from palpate.gym.observation import MORE, PARTS, Observation, observe, poses, space_of
from palpate.gym.picture import Eye
from palpate.gym.scene_task import SceneTask
from palpate.gym.tasks import TASKS, Task
from palpate.gym.world import RATE, Motion, World
from palpate.scene.scene import Scene


class PalpateVectorEnv(VectorEnv[Observation, NDArray[np.float64], NDArray[Any]]):
    """N instruments, each with its own scene and task, stepped together.

    Args:
        num_envs: number of instruments.
        scene: a scene, its values, its file, or the name of a shipped one.
        task: ``press``, ``find``, ``scene`` for the section `task` of the scene, or an object of your own (`Task`);
            when left out, ``scene`` if the scene has one, and otherwise ``press``.
        action: ``twist`` or ``pose`` (`Instruments`).
        substeps: ticks of 1 ms for each step.
        duration: time after which an episode is truncated [s]; 5 s, or the limit of the task ``scene``, when left out.
        observe: parts of the observation, of ``pose joints force contact goal``, and ``jaw bodies`` of a scene with
            bodies, several pairs or a task; all of them when left out.
        picture: height and width of the picture of the endoscope that the observation also holds as ``picture``
            [pixels]; None: no picture, which is a hundred times as fast.
        motion: limits of the motion.
        vary: ranges of values of the scene, drawn at each reset (`World`).
        workers: threads; one per core when left out.

    Instruments whose episode is over begin anew with their next step, as Gymnasium's ``NEXT_STEP`` mode says.
    """

    def __init__(
        self,
        num_envs: int = 1,
        scene: Scene | dict[str, Any] | str | os.PathLike[str] = "palpation",
        task: str | Task | None = None,
        action: Action = "twist",
        substeps: int = 20,
        duration: float | None = None,
        observe: Sequence[str] | None = None,
        motion: Motion | None = None,
        vary: Mapping[str, tuple[float, float]] | None = None,
        picture: tuple[int, int] | None = None,
        workers: int | None = None,
    ) -> None:
        world = World(scene, vary or {})
        own = world.scene.task
        task = ("press" if own is None else "scene") if task is None else task
        if duration is None:
            duration = own.limit if task == "scene" and own is not None else 5.0
        if num_envs < 1 or substeps < 1 or not 0.0 < duration < np.inf or action not in ("twist", "pose"):
            what = f"num_envs = {num_envs}, substeps = {substeps}, duration = {duration:g} s, action = {action!r}"
            mend = "numbers must be 1 or more, the duration positive and finite, the action twist or pose"
            raise PalpateError(what, mend=mend)
        self.task = _task(task)
        self.instruments = Instruments(
            world, num_envs, action, substeps, motion or Motion(), cores() if workers is None else workers
        )
        self.task.begin(num_envs, substeps / RATE, world)
        if isinstance(self.task, SceneTask):
            self.task.watch(self.instruments)
        self._joints = world.plain.arms.follower.n
        self._moving = [body.name for body in world.scene.bodies if body.free]
        further = MORE[: 2 if self._moving else 1] if world.pinches else ()
        self.parts = PARTS + further if observe is None else tuple(observe)
        self._eye = None if picture is None else Eye(world.rigs, picture)
        self._most = max(1, round(duration * RATE / substeps))
        self.num_envs = num_envs
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}
        low, high = self.instruments.low_high
        self.single_action_space = spaces.Box(low.astype(np.float32), high.astype(np.float32))
        hands, bodies = self.instruments.h, len(self._moving)
        self.single_observation_space = space_of(self.parts, self._joints, picture, hands, bodies)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._rngs = [np.random.default_rng() for _ in range(num_envs)]
        self._steps = np.zeros(num_envs, dtype=np.int64)
        self._over = np.zeros(num_envs, dtype=bool)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin all episodes anew. Environment i of a seed s gets the seed s + i.

        Raises:
            ValueError: several seeds that are not one for each environment.
        """
        many: Sequence[int | None] | int = [None] * self.num_envs if seed is None else seed
        seeds = [many + i for i in range(self.num_envs)] if isinstance(many, (int, np.integer)) else list(many)
        if len(seeds) != self.num_envs:
            raise ValueError(f"{len(seeds)} seeds for {self.num_envs} environments")
        for i, one in enumerate(seeds):
            if one is not None:
                self._rngs[i] = np.random.default_rng(one)
            self._begin(i)
        return self._observe(), {}

    def step(
        self, actions: NDArray[np.float64]
    ) -> tuple[Observation, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """One step of all instruments by actions (n, m); those whose episode was over begin anew instead.

        Raises:
            ValueError: as of `Instruments.step`.
        """
        begun = self._over.copy()
        asked = np.array(actions, dtype=np.float64)
        if asked.shape == self.action_space.shape:
            asked[begun] = 0.0  # whatever is asked of an episode that is over
        self.instruments.step(asked)
        for i in np.flatnonzero(begun):
            self._begin(int(i))
        reward, success = self.task.evaluate(self.instruments.ticks, self.instruments.felt)
        self._steps += ~begun
        success = success & ~begun
        truncated = (self._steps >= self._most) & ~success & ~begun
        self._over = success | truncated
        return self._observe(), np.where(begun, 0.0, reward), success, truncated, {"is_success": success.copy()}

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads."""
        self.instruments.close()
        if self._eye is not None:
            self._eye.close()

    def _begin(self, i: int) -> None:
        rng = self._rngs[i]
        rigs = self.instruments.world.drawn(rng)
        self.instruments.start(i, rigs, self.task.reset(i, rigs[0], rng))
        self._steps[i], self._over[i] = 0, False

    def _observe(self) -> Observation:
        instruments = self.instruments
        ticks = instruments.ticks
        seen = observe(self.parts, self._joints, ticks, instruments.felt, self.task.goals, self._bodies())
        return seen if self._eye is None else seen | {"picture": self._eye.pictures(ticks, instruments.engines)}

    def _bodies(self) -> Array | None:
        """Poses of the bodies that move (n, 7 bodies)."""
        if not self._moving or "bodies" not in self.parts:
            return None
        engines = self.instruments.engines
        rows = [np.zeros((len(self._moving), 7)) if one is None else one.states()["poses"] for one in engines]
        return poses(np.stack(rows)).reshape(self.num_envs, -1)


def _task(task: str | Task) -> Task:
    if not isinstance(task, str):
        return task
    if task == "scene":
        return SceneTask()
    if task not in TASKS:
        names = ", ".join((*TASKS, "scene"))
        raise PalpateError(f"there is no task {task!r}", mend=f"name one of {names}, or give an object")
    made: Task = TASKS[task]()
    return made
