"""A task in a session: the judge looks on, and a simulated operator moves the hands that nobody else moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.so3 import pose
from palpate.base.errors import SceneError
from palpate.scene.rig import Rig
from palpate.scene.scene import Scene
from palpate.session import PairsSession, Session
from palpate.session.tasks.hand import EVERY, Hand
from palpate.session.tasks.judge import Judge, Seen, TaskResult, judge_of
from palpate.session.tasks.scripts import Script, script_of
from palpate.world.bodies.engine import World


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
        session: the session, which does not run yet. On a device nobody acts but the person who holds it.

    Raises:
        SceneError: the scene has no task.
    """

    def __init__(self, session: Session | PairsSession) -> None:
        self._hands: list[Any] = list(session.pairs.values()) if isinstance(session, PairsSession) else [session]
        self.judge = judge_in(self._hands[0].rig)
        assert session.scene.task is not None
        self._session, self.section = session, session.scene.task
        simulated = all(isinstance(one, Session) and one.plant.simulated for one in self._hands)
        self._operated = self.section.operator and simulated
        self._marks: list[Array] = []
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
        if self._operated and self._turn % EVERY == 0:
            self._act(seen)

    def look(self, t: float) -> Seen:
        """The world as it is."""
        p_WT = np.array([np.array(one.latest()["p_WT"]) for one in self._hands])
        return look(t, p_WT, self._session.world, self._marks)

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


def look(t: float, p_WT: Array, world: World | None, marks: Sequence[Array] = ()) -> Seen:
    """What a judge sees at a time [s].

    Args:
        t: the time.
        p_WT: positions of the tools (n, 3) [m].
        world: the rigid bodies; None: there are none.
        marks: positions (3,) of a tool when the pedal coag was pressed [m].
    """
    if world is None:
        return Seen(t, p_WT, marks=tuple(marks))
    states, names = world.states(), world.moving
    bodies = {name: pose(row[:3], row[3:]) for name, row in zip(names, states["poses"], strict=True)}
    held = {name: int(count) for name, count in zip(names, (states["grip"] > 0.0).sum(axis=0), strict=True)}
    holders = {name: tuple(np.flatnonzero(states["grip"][:, k] > 0.0).tolist()) for k, name in enumerate(names)}
    return Seen(t, p_WT, bodies, held, int(states["lost"].sum()), tuple(marks), holders)


def judge_in(rig: Rig) -> Judge:
    """The judge of the task of a rig's scene.

    Raises:
        SceneError: the scene has no task.
    """
    scene = rig.scene
    if scene.task is None:
        raise SceneError("the scene has no task", where=scene.where("task"), mend="give it a section task")
    find = scene.task.find
    if find is None:
        return judge_of(scene.task)
    index = next(i for i, obj in enumerate(scene.objects) if obj.name == find.object)
    region = next(one for one in scene.objects[index].regions if one.name == find.region)
    return judge_of(scene.task, (rig.surfaces[index].X_WO, np.array(region.at)))
