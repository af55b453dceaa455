"""The scene of each task in each condition."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from palpate.arrays import Array
from palpate.arrays.plain import Content
from palpate.errors import PalpateError, SceneError
from palpate.experiment.course import Course, course_of
from palpate.experiment.model import ConditionSection, ExperimentFile
from palpate.hands import Hand
from palpate.scene import shipped
from palpate.scene.overrides import override
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies

UNFELT = 1e-9
"""Force on the hand per force on the tool where the force is not felt [-]: the force on the tool stays known."""
_RECORD = {"report": False, "frames": False}  # frames can be computed from a record, and take half of its time
_PULL = {"name": "potential", "force": 1.0, "range": "1 cm"}


@dataclass(frozen=True)
class Setting:
    """A task in a condition."""

    scene: Scene
    course: Course
    condition: ConditionSection


class Settings:
    """All tasks in all conditions of an experiment; surfaces are read once.

    Args:
        experiment: the file.
        trust: True lets drivers beside the scene files run (docs/security.md).

    Raises:
        SceneError, MeshError: a scene cannot run; the message names the condition and the task.
    """

    def __init__(self, experiment: ExperimentFile, trust: bool = False) -> None:
        self._experiment, self._trust = experiment, trust
        self._bodies: Bodies = {}
        self._made: dict[tuple[str, str], Setting] = {}

    def of(self, task: str, condition: str) -> Setting:
        """A task in a condition.

        Raises:
            SceneError, MeshError: as for the class.
        """
        key = (task, condition)
        if key not in self._made:
            self._made[key] = self._make(task, condition)
        return self._made[key]

    def all(self) -> dict[tuple[str, str], Setting]:
        """Every task in every condition."""
        return {(t, c): self.of(t, c) for t in self._experiment.tasks for c in self._experiment.conditions}

    def rig(self, setting: Setting, hand: Hand | None = None, tremor: float = 0.0, seed: int = 0) -> Rig:
        """The rig of a trial: the hand rests at the start.

        Args:
            setting: task and condition.
            hand: of a simulated participant; None: that of the scene.
            tremor: of a simulated participant, rms per axis [m].
            seed: of the trial.
        """
        start = setting.course.start.tolist()
        operator: Content = {"path": [{"t": 0.0, "xyz": start}]}
        if hand is not None:
            operator |= {key: getattr(hand, key) for key in ("mass", "damping", "stiffness")} | {"tremor": tremor}
        data = setting.scene.model_dump(mode="json", exclude_unset=True)
        before = {k: v for k, v in data.get("operator", {}).items() if k not in ("palpate", "path")}
        data |= {"operator": before | operator, "seed": seed, "record": _RECORD | data.get("record", {})}
        made = Scene.validated(data, {"folder": Path(setting.scene.file).parent})
        return build(made.with_file_of(setting.scene), self._bodies)

    def _make(self, task: str, condition: str) -> Setting:
        section, given = self._experiment.tasks[task], self._experiment.conditions[condition]
        named = ("conditions", condition, "scene") if given.scene is not None else ("tasks", task, "scene")
        try:
            base = Scene.load(self._path(given.scene or section.scene), self._trust)
            scene = override(base, {**section.changes, **given.changes, **_changes(given, base)})
            rig = build(scene, self._bodies, until=0.0)
            course = course_of(section, rig)
            if given.guidance == "path":
                scene = override(scene, {"guidance": [*_dumped(scene), _fixture(course.path)]})
        except PalpateError as error:
            what = f"condition {condition!r}, task {task!r}: {error.what}"
            where = f"{self._experiment.where(*named)}" + (f" ({error.where})" if error.where else "")
            raise SceneError(what, where=where, why=error.why, mend=error.mend) from None
        self._require_simple(scene, named)
        return Setting(scene, course, given)

    def _path(self, name: str) -> Path:
        beside = Path(self._experiment.file).parent / name
        return beside if beside.is_file() or Path(name) == shipped.find(Path(name)) else Path(name)

    def _require_simple(self, scene: Scene, place: tuple[str, ...]) -> None:
        if scene.pairs or scene.remote is not None:
            what = "a scene with several pairs" if scene.pairs else "a scene with a section remote"
            where = self._experiment.where(*place)
            raise SceneError(f"{what} cannot be used in an experiment yet", where=where, mend="name one of one pair")


def _changes(given: ConditionSection, base: Scene) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if not given.felt:
        found["mapping.force_scale"] = UNFELT
    if given.delay > 0.0:
        found["loop_delay"] = given.delay
    if given.guidance == "none":
        found["guidance"] = []
    elif given.guidance not in (None, "path"):
        own = [one.model_dump(mode="json", exclude_unset=True) for one in given.guidance]  # type: ignore[union-attr]
        found["guidance"] = [*_dumped(base), *own]
    return found


def _dumped(scene: Scene) -> list[Content]:
    return [one.model_dump(mode="json", exclude_unset=True) for one in scene.guidance]


def _fixture(path: Array) -> Content:
    kept = path[:: max(1, len(path) // 100)]
    points = [[float(x) for x in p] for p in kept]
    if len(points) < 2 or not (path[-1] == kept[-1]).all():
        points.append([float(x) for x in path[-1]])
    return {"name": "task-path", "geometry": {"path": {"waypoints": points}}, "role": "guide", "law": _PULL}
