"""The scene of each task in each condition."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from palpate.arm.hands import Hand
from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate.base.errors import PalpateError, SceneError
from palpate.experiment.course import SIGNALS, Course, course_of
from palpate.experiment.model import ConditionSection, ExperimentFile
from palpate.scene import shipped
from palpate.scene.overrides import override
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.scene.surface import Bodies, placed

if TYPE_CHECKING:
    from palpate.session import Session
    from palpate.session.network.conditions import Network

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
    link: Network | None = None
    """The network of the condition."""

    def join(self, session: Session, seed: int) -> None:
        """Put the condition's network, if it has one, between a session and a simulated instrument."""
        if self.link is not None:
            from palpate.session.remote.emulated import emulate

            emulate(session, self.link, seed)


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
            _require_usable(scene)
            course = course_of(section, scene, placed(scene, self._bodies))
            if given.network is not None:
                _require_remote(scene)
            if given.guidance == "path":
                scene = override(scene, {"guidance": [*_dumped(scene), _fixture(course.path)]})
            setting = Setting(scene, course, given, self._link(given))
            self._require_start(setting)
        except PalpateError as error:
            what = f"condition {condition!r}, task {task!r}: {error.what}"
            where = f"{self._experiment.where(*named)}" + (f" ({error.where})" if error.where else "")
            raise SceneError(what, where=where, why=error.why, mend=error.mend) from None
        return setting

    def _path(self, name: str) -> Path:
        beside = Path(self._experiment.file).parent / name
        return beside if beside.is_file() or Path(name) == shipped.find(Path(name)) else Path(name)

    def _link(self, given: ConditionSection) -> Network | None:
        if given.network is None:
            return None
        from palpate.session.network import network

        beside = Path(self._experiment.file).parent / given.network
        return network(str(beside) if beside.is_file() else given.network)

    def _require_start(self, setting: Setting) -> None:
        """Refuse a scene that cannot run, or whose simulated hand cannot rest at the start."""
        if setting.scene.arms.leader.driver is None:
            self.rig(setting)
        else:
            build(setting.scene, self._bodies, until=0.0)


def _require_usable(scene: Scene) -> None:
    """Refuse scenes that no participant can work in, and records that do not tell how a trial ended."""
    if scene.pairs or scene.remote is not None:
        what = "a scene with several pairs" if scene.pairs else "a scene with a section remote"
        mend = "name a scene with one pair of arms on this machine"
        raise SceneError(f"{what} cannot be used in an experiment yet", where=scene.file, mend=mend)
    needed = [name for name in SIGNALS[1:] if name != "F_held_W" or scene.bodies]
    lacking = [] if scene.record.signals is None else [name for name in needed if name not in scene.record.signals]
    if lacking:
        what = f"the record would lack {', '.join(lacking)}, by which trials are judged"
        raise SceneError(what, where=scene.where("record", "signals"), mend="add them to record.signals")


def _require_remote(scene: Scene) -> None:
    """Refuse scenes that cannot run across an emulated network."""
    from palpate.scene.held import refuse

    refuse(scene, "across a network")
    if scene.arms.leader.driver is not None:
        what = "a leader with a driver cannot be used across a network yet"
        raise SceneError(what, where=scene.where("arms", "leader"), mend="leave the condition's network out")


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
