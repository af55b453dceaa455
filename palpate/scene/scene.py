"""A scene: all inputs of a run, read from YAML or made in Python."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import Field, PrivateAttr, ValidationError, model_validator

from palpate import _core
from palpate.arm import NAMES, Arm
from palpate.base.arrays.yaml_loader import Dumper
from palpate.base.errors import ArmError, Place, SceneError, ValueAtError, format_place, where_in
from palpate.base.values import NotNegative, Positive, Section, Vector
from palpate.scene import pairs as pairs_module
from palpate.scene import shipped, text
from palpate.scene.ecm import EcmSection
from palpate.scene.force import ForceSection
from palpate.scene.graspable import GraspableSection
from palpate.scene.guidance.lists import FixtureList, with_unique_names
from palpate.scene.mapping import MappingSection
from palpate.scene.model import (
    ArmsSection,
    ContactSection,
    ObjectSection,
    RatesSection,
    RecordSection,
    TorqueSection,
)
from palpate.scene.operator import OperatorSection
from palpate.scene.pairs import InstrumentsSection, PairSection
from palpate.scene.planning import PlanningSection
from palpate.scene.registration import RegistrationSection
from palpate.scene.remote import RemoteSection
from palpate.scene.sensors import SensorSection, with_topics
from palpate.scene.stability import StabilitySection
from palpate.scene.task import TaskSection
from palpate.scene.trackers import TrackerSection
from palpate.world.bodies import BodySection, EngineSection
from palpate.world.bodies.sections import check as check_bodies
from palpate.world.frames import FrameSection

_C = _core.SimulationOptions()
_VARIABLE = re.compile(r"\$\{(\w+)(?::-([^}]*))?\}")


class Scene(Section):
    """Arms, objects, gains, rates and operator of one run. Values are in SI units unless a key names another unit.

    ``Scene.load(path)`` reads a file and reports errors with their line; ``Scene.model_validate(dict)`` takes values.
    """

    preset: Literal["paper", "as-shipped"] | None = None
    """default values of the paper or of its published code; keys given in this file take precedence"""
    objects: Annotated[tuple[ObjectSection, ...], Field(min_length=1, max_length=_core.MAX_OBJECTS)]
    """objects that can be touched"""
    arms: ArmsSection = ArmsSection()
    """leader and follower"""
    pairs: dict[str, PairSection] = Field(default_factory=dict, exclude_if=lambda pairs: not pairs)
    """instead of one pair: several, by name, each with its own arms, mapping, contact, guidance and limits
    (docs/pairs.md)"""
    instruments: InstrumentsSection = Field(default=InstrumentsSection(), exclude_if=lambda s: not s.model_fields_set)
    """contact between the instruments of several pairs"""
    graspable: GraspableSection | None = Field(default=None, exclude_if=lambda s: s is None)
    """a rigid object that the instruments of several pairs hold and hand over (docs/pairs-handing-over.md)"""
    bodies: Annotated[tuple[BodySection, ...], Field(max_length=128, exclude_if=lambda bodies: not bodies)] = ()
    """rigid bodies that tools grasp, move and feel (docs/bodies.md)"""
    engine: EngineSection = Field(default=EngineSection(), exclude_if=lambda s: not s.model_fields_set)
    """the engine that moves the bodies, and the coupling of the tools to it"""
    task: TaskSection | None = Field(default=None, exclude_if=lambda s: s is None)
    """a task that is scored (docs/tasks.md)"""
    ecm: EcmSection | None = None
    """the endoscope arm: the surgeon's view, and the axes of the hands (docs/ecm.md)"""
    frames: Annotated[tuple[FrameSection, ...], Field(max_length=128)] = ()
    """frames of cameras, trackers, markers and anatomy, in which objects and arms are placed (docs/frames.md)"""
    trackers: dict[str, TrackerSection] = Field(default_factory=dict)
    """trackers that move frames while a session runs, by name"""
    sensors: dict[str, SensorSection] = Field(default_factory=dict)
    """depth cameras, by name (docs/camera.md)"""
    registration: RegistrationSection | None = None
    """registration of the organ: targets, accuracy and sensors (docs/registration-session.md)"""
    mapping: MappingSection = MappingSection()
    """mapping of motion from hand to tool, and of force from tool to hand"""
    contact: ContactSection = ContactSection()
    """contact method and geometry of the tool"""
    force: ForceSection = ForceSection()
    """source of the force on the tool"""
    guidance: FixtureList = ()
    """virtual fixtures: constraints on the tool (docs/guidance.md)"""
    places: dict[str, Vector] = Field(default_factory=dict)
    """named positions in W that fixtures can use, e.g. entry and target [m]"""
    stability: StabilitySection = StabilitySection()
    """limits and passivity of the force"""
    torque: TorqueSection = TorqueSection()
    """joint torques of the leader"""
    rates: RatesSection = RatesSection()
    """rates of the haptic cycle and the simulated arms"""
    loop_delay: Annotated[NotNegative, Field(le=1.0)] = _C.loop_delay
    """delay from the computed force to the torque of the drives [s]"""
    loop_jitter: Annotated[NotNegative, Field(le=1.0)] = _C.loop_jitter
    """random delay in addition to loop_delay, uniform from 0 to this for each cycle's force; the order is kept [s]"""
    operator: OperatorSection = OperatorSection()
    """the simulated hand"""
    planning: PlanningSection = Field(default=PlanningSection(), exclude_if=lambda s: not s.model_fields_set)
    """motion plans of the follower (docs/planning.md)"""
    remote: RemoteSection | None = Field(default=None, exclude_if=lambda s: s is None)
    """a follower that is felt across a network (docs/network.md)"""
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**64)] = _C.seed
    """seed of all random numbers"""
    duration: Positive = 20.0
    """default duration of a run [s]"""
    record: RecordSection = RecordSection()
    """output of a run"""

    _file: str = PrivateAttr(default="")
    _lines: dict[Place, int] = PrivateAttr(default_factory=dict)
    _trusted: bool = PrivateAttr(default=False)

    @classmethod
    def load(cls, path: str | os.PathLike[str], trust: bool = False) -> Scene:
        """Read a scene file, or a scene that comes with Palpate by its name, such as ``palpation``.

        Args:
            path: the file, or the name.
            trust: True lets the driver that the scene names run, even if it is not installed (docs/security.md).

        Raises:
            SceneError: the file is invalid; the message gives file and line of every error, and how to correct it.
        """
        file = shipped.find(Path(path))
        return cls.parse(text.read(file), str(file), trust)

    @classmethod
    def of(cls, given: Scene | dict[str, Any] | str | os.PathLike[str]) -> Scene:
        """The scene that is given as itself, as its values, as its file, or as the name of a shipped scene.

        Raises:
            SceneError: it is neither, or an invalid one.
        """
        if isinstance(given, Scene):
            return given
        if isinstance(given, dict):
            return cls.model_validate(given)
        if isinstance(given, (str, os.PathLike)):
            return cls.load(given)
        what = f"{given!r} is no scene"
        raise SceneError(what, mend="give palpate.Scene.load(FILE), the path of a file, or a dictionary of its values")

    @classmethod
    def parse(cls, source: str, name: str = "scene.yaml", trust: bool = False) -> Scene:
        """Parse YAML text. ``name`` is the path of the file; relative paths in the scene start at its folder.

        ``trust`` as in ``load``.

        Raises:
            SceneError: as for ``load``.
        """
        data, lines = text.parse(source, name)
        if text.is_exercise(data):
            from palpate.scene import exercises

            data, lines = exercises.values(data, name), {}
        try:
            scene = cls.validated(data, {"folder": Path(name).parent})
        except ValidationError as error:
            raise _explained(error, name, lines) from None
        scene._file, scene._lines, scene._trusted = name, lines, trust
        return scene

    def with_file_of(self, other: Scene) -> Scene:
        """Take over the file and line numbers of another scene, for relative paths and messages; return self."""
        return self.with_origin(other._file, other._lines, other._trusted)

    def with_origin(self, file: str, lines: dict[Place, int], trust: bool = False) -> Scene:
        """Set the file of the scene, the line of each value, and whether code that it names may run; return self."""
        self._file, self._lines, self._trusted = file, lines, trust
        return self

    def pair(self, name: str) -> Scene:
        """The scene of one pair alone: the values of the scene, overridden by those of the pair.

        Raises:
            SceneError: there is no such pair, or its values contradict those of the scene.
        """
        if name not in self.pairs:
            mend = f"name one of {', '.join(self.pairs)}" if self.pairs else "the scene has one pair, without a name"
            raise SceneError(f"there is no pair {name!r}", where=self.where("pairs"), mend=mend)
        data = self.model_dump(mode="json", exclude_unset=True, exclude={"pairs"})
        own = self.pairs[name].model_dump(mode="json", exclude_unset=True, exclude={"devices"})
        lines = self._lines | {at[2:]: n for at, n in self._lines.items() if at[:2] == ("pairs", name) and at[2:]}
        try:
            made = Scene.validated(pairs_module.merged(data, own), {"folder": Path(self._file).parent})
        except ValidationError as error:
            raise _explained(error, self._file or f"pair {name}", lines) from None
        return made.with_origin(self._file, lines, self._trusted)

    def with_driver(self, name: str, pair: str | None = None) -> Scene:
        """The scene on a device: with this driver in place of its leader.

        Args:
            name: the driver.
            pair: the pair whose hand feels on it; None: a scene without pairs. The device stands where the leader of
                this pair stands, and has the axes of its base.

        Raises:
            SceneError: there is no such driver, or the scene cannot run on a device.
        """
        data = self.model_dump(mode="json", exclude_unset=True)
        section = data if pair is None else data["pairs"][pair]
        leader = section.setdefault("arms", {}).setdefault("leader", {})
        leader["driver"] = name
        try:
            made = Scene.validated(data, {"folder": Path(self._file).parent})
        except ValidationError as error:
            raise _explained(error, self._file or "scene", self._lines) from None
        return made.with_file_of(self)

    def each_pair(self) -> dict[str, Scene]:
        """The scenes of all pairs by name; the scene itself under the empty name if it has no section `pairs`."""
        return {name: self.pair(name) for name in self.pairs} or {"": self}

    @property
    def file(self) -> str:
        """Path of the scene file; empty for a scene made in Python."""
        return self._file

    @property
    def trusted(self) -> bool:
        """True if the user trusts the code that the scene names, its driver."""
        return self._trusted

    @property
    def title(self) -> str:
        """Short name of the scene for folders and headings."""
        return Path(self._file).stem or "scene"

    def where(self, *place: str | int) -> str:
        """``file:line`` of a value, e.g. ``where("objects", 0, "mesh")``, or of its section."""
        return where_in(self._file, self._lines, place) if self._file else format_place(place)

    def path_of(self, index: int) -> Path:
        """Geometry file of object ``index``, with variables replaced; relative paths start at the scene's folder.

        Raises:
            SceneError: the object has no file, or the path contains an unset variable.
        """
        obj = self.objects[index]
        where, value = self.where("objects", index, obj.source), obj.file
        if value is None:
            raise SceneError(f"object {obj.name!r} has no file", where=where, mend=f"it is a {obj.source}")
        return self.path_to(value, where)

    def arm_path(self, side: str) -> Path | None:
        """Model file of the arm on ``side``, ``leader`` or ``follower``; None for an arm shipped with Palpate.

        Raises:
            SceneError: the path contains an unset variable.
        """
        model: str = getattr(self.arms, side).model
        return None if model in NAMES else self.path_to(model, self.where("arms", side, "model"))

    def arm(self, side: str) -> Arm:
        """A new arm object for ``side``, ``leader`` or ``follower``.

        Raises:
            SceneError: the model file cannot be read, or does not describe a movable arm.
        """
        path = self.arm_path(side)
        try:
            return Arm.model(getattr(self.arms, side).model) if path is None else Arm.load(path)
        except ArmError as error:
            why = "; ".join(part for part in (error.where, error.why) if part)
            what = f"arms.{side}.model: {error.what}"
            raise SceneError(what, where=self.where("arms", side, "model"), why=why, mend=error.mend) from None

    def resolved_driver(self) -> str | None:
        """Driver of the leader with the absolute path of its file, if that lies beside the scene; None without one.

        ``my_device:Omega`` beside the scene becomes ``/path/to/my_device.py:Omega``, and a shared object its path.
        """
        name = self.arms.leader.driver
        if name is None or self._file == "":
            return name
        head, colon, rest = name.partition(":")
        file = head if head.endswith((".so", ".py")) else head.replace(".", "/") + ".py"
        path = Path(self._file).parent / Path(file).expanduser()
        return f"{path.resolve()}{colon}{rest}" if path.is_file() else name

    def gravity_path(self, key: str) -> Path | None:
        """File of ``arms.leader.gravity_model`` or ``plant_gravity_model``, as `path_of`; None without one."""
        value: str | None = getattr(self.arms.leader, key)
        return None if value is None else self.path_to(value, self.where("arms", "leader", key))

    def dynamics_path(self) -> Path | None:
        """File of ``force.dynamics``, as `path_of`; None if the scene names none."""
        value = self.force.dynamics
        return None if value is None else self.path_to(value, self.where("force", "dynamics"))

    def path_to(self, value: str, where: str) -> Path:
        """Path of a file named in the scene at ``where``: variables replaced, relative to the scene's folder.

        Raises:
            SceneError: the path contains an unset variable.
        """

        def replace(match: re.Match[str]) -> str:
            found = os.environ.get(match[1]) or match[2]
            if found is None:
                mend = f"export {match[1]}=/path/to/files, or write ${{{match[1]}:-/path/to/files}}"
                raise SceneError(f"variable {match[1]} is not set", where=where, why=value, mend=mend)
            return found

        return Path(self._file).parent / Path(_VARIABLE.sub(replace, value)).expanduser()

    def to_yaml(self) -> str:
        """Every value of the scene, defaults included, as YAML that ``parse`` reads back."""
        data = self.model_dump(mode="json", exclude={"pairs"})
        if self.pairs:  # a key that a pair leaves out has the scene's value, not its default
            each = {name: pair.model_dump(mode="json", exclude_unset=True) for name, pair in self.pairs.items()}
            data["pairs"] = each
            if "rate_cap" not in self.stability.model_fields_set:
                del data["stability"]["rate_cap"]  # it follows the scale of each pair
        return str(yaml.dump(data, sort_keys=False, allow_unicode=True, Dumper=Dumper))

    @model_validator(mode="before")
    @classmethod
    def _apply_preset(cls, data: Any) -> Any:
        data = with_topics(data)
        if not isinstance(data, dict) or data.get("preset") is None:
            return data
        from palpate.scene import presets

        return presets.apply(data)

    @model_validator(mode="after")
    def _fill_names(self) -> Scene:
        taken: dict[str, int] = {}
        named = []
        for i, obj in enumerate(self.objects):
            name = obj.name or (Path(obj.file).stem if obj.file else obj.shape or obj.source)
            if name in taken and obj.name:
                raise ValueAtError(f"another object is named {name!r} too | rename one of them", "objects", i, "name")
            count = taken[name] = taken.get(name, 0) + 1
            named.append(obj.model_copy(update={"name": name if count == 1 else f"{name}-{i + 1}"}))
        object.__setattr__(self, "objects", tuple(named))
        object.__setattr__(self, "guidance", with_unique_names(self.guidance))
        palpated = self.operator.palpate.object
        if palpated and palpated not in [o.name for o in named]:
            names = ", ".join(o.name for o in named)
            what = f"there is no object {palpated!r} | name one of {names}"
            raise ValueAtError(what, "operator", "palpate", "object")
        return self

    @model_validator(mode="after")
    def _fill_rate_cap(self) -> Scene:
        stiffest = max((obj.stiffest for obj in self.objects if obj.tissue is None), default=0.0)
        felt = self.mapping.scale * self.mapping.force_scale * stiffest
        object.__setattr__(self, "stability", self.stability.following(felt))
        return self

    @model_validator(mode="after")
    def _check_pairs(self) -> Scene:
        pairs_module.check(self.pairs)
        return self

    @model_validator(mode="after")
    def _check_bodies(self) -> Scene:
        check_bodies(self.bodies, self.engine, {obj.name for obj in self.objects}, _core.MAX_BODIES)
        if self.task is not None:
            regions = {obj.name: [region.name for region in obj.regions] for obj in self.objects}
            self.task.check({body.name: body.free for body in self.bodies}, regions)
        return self

    @model_validator(mode="after")
    def _check_frames(self) -> Scene:
        taken = {"world", "leader", "follower", "tool", *(obj.name for obj in self.objects)}
        for i, frame in enumerate(self.frames):
            if frame.child in taken and not frame.check:
                what = f"{frame.child!r} is the name of the world, an arm, the tool or an object"
                raise ValueAtError(f"{what} | rename this frame", "frames", i, "child")
            if frame.tracker is not None and frame.tracker not in self.trackers:
                names = ", ".join(self.trackers) or "none"
                what = f"there is no tracker {frame.tracker!r} | name one of the scene's trackers: {names}"
                raise ValueAtError(what, "frames", i, "tracker")
        for name, tracker in self.trackers.items():
            seen = [frame.child for frame in self.frames if frame.tracker == name]
            if tracker.topic is not None and "{tool}" not in tracker.topic and len(seen) > 1:
                frames = ", ".join(seen)
                what = f"one topic for the frames {frames} | write {{tool}} in it, and name the tool of each frame"
                raise ValueAtError(what, "trackers", name, "topic")
        return self


def _explained(error: ValidationError, name: str, lines: dict[Place, int]) -> SceneError:
    """The error of a scene file whose values are invalid."""
    from palpate.base.values.wording import explain

    return explain.scene_error(error, Scene, name, lines)
