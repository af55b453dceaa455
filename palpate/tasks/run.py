"""A task in a session: the judge looks on, and a simulated operator moves the hands that nobody else moves."""

from __future__ import annotations

from typing import Any

import numpy as np

from palpate.arrays import Array
from palpate.arrays.so3 import pose
from palpate.errors import SceneError
from palpate.scene.scene import Scene
from palpate.scene.task import FindSection
from palpate.session import PairsSession, Session
from palpate.tasks.hand import EVERY, Hand
from palpate.tasks.judge import Seen, TaskResult, judge_of
from palpate.tasks.scripts import Script, script_of


def drawn(scene: Scene, seed: int) -> Scene:
    """The scene with what its task leaves to the seed: the place of the hidden lump."""
    find = None if scene.task is None else scene.task.find
    if find is None:
        return scene
    low, high = np.array(find.area)
    at = (low + np.random.default_rng([seed, 45]).random(3) * (high - low)).tolist()
    data = scene.model_dump(mode="json", exclude_unset=True)
    for obj in data["objects"]:
        for region in obj.get("regions", ()):
            if obj.get("name") == find.object and region.get("name") == find.region:
                region["at"] = at
    return Scene.validated(data).with_file_of(scene)


class TaskRun:
    """The task of a scene in a session of it.

        session = palpate.Session(drawn(scene, seed), seed=seed)
        task = TaskRun(session)
        session.run()
        task.result.success

    Args:
        session: the session, which does not run yet.

    Raises:
        SceneError: the scene has no task.
    """

    def __init__(self, session: Session | PairsSession) -> None:
        section = session.scene.task
        if section is None:
            raise SceneError("the scene has no task", where=session.scene.where("task"), mend="give it a section task")
        self._session, self.section = session, section
        self._hands: list[Any] = list(session.pairs.values()) if isinstance(session, PairsSession) else [session]
        self._marks: list[Array] = []
        lump = None if section.find is None else _lump(session.scene, self._hands[0].rig, section.find)
        self.judge = judge_of(section, lump)
        self._script: Script | None = None
        self._turn = 0
        session.console.on_change(self._pressed)
        session.steps_beside.append(self.step)
        session.task_words = self.words

    def words(self) -> str:
        """How the task stands, in words."""
        found = self.result
        drops = f", {found.drops} dropped" if found.drops else ""
        return f"{found.time_s:.0f} of {self.judge.limit:.0f} s: {found.progress}{drops}"

    @property
    def result(self) -> TaskResult:
        """The result up to now."""
        return self.judge.result()

    def step(self, t: float) -> None:
        """Look at the world and, every second time, let the operator act; ends the run at the end of the task."""
        seen = self.look(t)
        self.judge.see(seen)
        if self.judge.done:
            self._session.finish()
            return
        self._turn += 1
        if self.section.operator and self._turn % EVERY == 0:
            self._act(seen)

    def look(self, t: float) -> Seen:
        """The world as it is."""
        p_WT = np.array([np.array(one.latest()["p_WT"]) for one in self._hands])
        world = self._session.world
        if world is None:
            return Seen(t, p_WT, marks=tuple(self._marks))
        states = world.states()
        bodies = {name: pose(row[:3], row[3:]) for name, row in zip(world.moving, states["poses"], strict=True)}
        held = {name: int(count) for name, count in zip(world.moving, (states["grip"] > 0.0).sum(axis=0), strict=True)}
        holders = {
            name: tuple(np.flatnonzero(states["grip"][:, k] > 0.0).tolist()) for k, name in enumerate(world.moving)
        }
        return Seen(t, p_WT, bodies, held, int(states["lost"].sum()), tuple(self._marks), holders)

    def _act(self, seen: Seen) -> None:
        if any(one.controls.hold for one in self._hands):
            self._script = None  # a person moves a hand; the operator begins anew afterwards
            return
        if self._script is None:
            hands = [Hand(one, k, self._session.seed) for k, one in enumerate(self._hands)]
            self._script = script_of(self.section, hands, self.judge, self._session.console)
        self._script.step(seen)

    def _pressed(self, pedal: str, down: bool) -> None:
        if pedal == "coag" and down:
            self._marks.append(np.array(self._hands[0].latest()["p_WT"]))


def _lump(scene: Scene, rig: Any, find: FindSection) -> tuple[Array, Array]:
    """X_WO (4, 4) of the object, and the place of the lump in it (3,) [m]."""
    index = next(i for i, obj in enumerate(scene.objects) if obj.name == find.object)
    region = next(one for one in scene.objects[index].regions if one.name == find.region)
    return rig.surfaces[index].X_WO, np.array(region.at)
