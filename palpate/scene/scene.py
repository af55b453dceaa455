"""One scene: everything a run depends on, read from YAML or made in Python."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import Field, PrivateAttr, ValidationError, model_validator

from palpate import _core
from palpate.arm import NAMES, Arm
from palpate.errors import ArmError, SceneError, spell
from palpate.guidance.fixture import Fixture
from palpate.guidance.lists import named as fixture_names
from palpate.scene import explain, presets, text
from palpate.scene.force import ForceSection
from palpate.scene.model import (
    ArmsSection,
    ContactSection,
    MappingSection,
    ObjectSection,
    RatesSection,
    RecordSection,
    TorqueSection,
)
from palpate.scene.operator import OperatorSection
from palpate.scene.stability import StabilitySection
from palpate.values import NotNegative, Positive, Section, Vector

_C = _core.SimulationOptions()
_VARIABLE = re.compile(r"\$\{(\w+)(?::-([^}]*))?\}")


class Scene(Section):
    """Arms, objects, gains, rates and the operator of one run. All values in SI units unless a key names another.

    ``Scene.load(path)`` reads a file and tells mistakes with their line; ``Scene.model_validate(dict)`` takes values.
    """

    preset: Literal["paper", "as-shipped"] | None = None
    """values of the paper or of its published code, below what this file gives itself"""
    objects: Annotated[tuple[ObjectSection, ...], Field(min_length=1, max_length=32)]
    """what can be touched"""
    arms: ArmsSection = ArmsSection()
    """leader and follower"""
    mapping: MappingSection = MappingSection()
    """from the hand to the tool, and back for forces"""
    contact: ContactSection = ContactSection()
    """how contact is found"""
    force: ForceSection = ForceSection()
    """where the force on the tool comes from"""
    guidance: Annotated[tuple[Fixture, ...], Field(max_length=128)] = ()
    """virtual fixtures: what guides, forbids and keeps in (docs/guidance.md)"""
    places: dict[str, Vector] = Field(default_factory=dict)
    """named places in W that fixtures may be made from, e.g. entry and target [m]"""
    stability: StabilitySection = StabilitySection()
    """the last word on the force"""
    torque: TorqueSection = TorqueSection()
    """joint torques of the leader"""
    rates: RatesSection = RatesSection()
    """how often things happen"""
    loop_delay: Annotated[NotNegative, Field(le=1.0)] = _C.loop_delay
    """from the computed force to the torque of the drives [s]"""
    loop_jitter: Annotated[NotNegative, Field(le=1.0)] = _C.loop_jitter
    """on top of loop_delay: uniform from 0 to this, of each cycle's force anew, in their order [s]"""
    operator: OperatorSection = OperatorSection()
    """the simulated hand"""
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**64)] = _C.seed
    """of everything random"""
    duration: Positive = 20.0
    """of a run that is not told otherwise [s]"""
    record: RecordSection = RecordSection()
    """what is kept of a run"""

    _file: str = PrivateAttr(default="")
    _lines: dict[text.Place, int] = PrivateAttr(default_factory=dict)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Scene:
        """Read a scene file.

        Raises:
            SceneError: with file and line of every mistake, the nearest valid key, and the unit that is expected.
        """
        return cls.parse(text.read(Path(path)), str(path))

    @classmethod
    def parse(cls, source: str, name: str = "scene.yaml") -> Scene:
        """A scene from YAML text; ``name`` is the file it stands for: mesh paths are relative to its folder.

        Raises:
            SceneError: as ``load``.
        """
        data, lines = text.parse(source, name)
        try:
            scene = cls.model_validate(data, context={"folder": Path(name).parent})
        except ValidationError as error:
            raise explain.scene_error(error, cls, name, lines) from None
        scene._file, scene._lines = name, lines
        return scene

    def standing_for(self, other: Scene) -> Scene:
        """Itself, with the file and the lines of another scene: for its relative paths and messages."""
        self._file, self._lines = other._file, other._lines
        return self

    @property
    def file(self) -> str:
        """Path of the file it was read from; empty for a scene made in Python."""
        return self._file

    @property
    def title(self) -> str:
        """Short name for folders and headings."""
        return Path(self._file).stem or "scene"

    def where(self, *place: str | int) -> str:
        """``file:line`` of a value, e.g. ``where("objects", 0, "mesh")``, or of its section."""
        return explain.where(self._file, self._lines, place) if self._file else spell(place)

    def path_of(self, index: int) -> Path:
        """File of object ``index``: variables replaced, relative paths taken from the scene's folder.

        Raises:
            SceneError: the object has no file, or names a variable that is not set.
        """
        thing = self.objects[index]
        where, value = self.where("objects", index, thing.source), thing.file
        if value is None:
            raise SceneError(f"object {thing.name!r} has no file", where=where, mend=f"it is a {thing.source}")
        return self.path_to(value, where)

    def arm_path(self, side: str) -> Path | None:
        """Model file of the arm on a ``side``, ``leader`` or ``follower``; None for one that comes with Palpate.

        Raises:
            SceneError: names a variable that is not set.
        """
        model: str = getattr(self.arms, side).model
        return None if model in NAMES else self.path_to(model, self.where("arms", side, "model"))

    def arm(self, side: str) -> Arm:
        """A fresh arm of a ``side``, ``leader`` or ``follower``.

        Raises:
            SceneError: its model file cannot be read, or describes nothing that can move.
        """
        path = self.arm_path(side)
        try:
            return Arm.model(getattr(self.arms, side).model) if path is None else Arm.load(path)
        except ArmError as error:
            why = "; ".join(part for part in (error.where, error.why) if part)
            what = f"arms.{side}.model: {error.what}"
            raise SceneError(what, where=self.where("arms", side, "model"), why=why, mend=error.mend) from None

    def gravity_path(self, key: str) -> Path | None:
        """File of ``arms.leader.gravity_model`` or ``plant_gravity_model``, as `path_of`; None when there is none."""
        value: str | None = getattr(self.arms.leader, key)
        return None if value is None else self.path_to(value, self.where("arms", "leader", key))

    def dynamics_path(self) -> Path | None:
        """File of ``force.dynamics``, as `path_of`; None when there is none."""
        value = self.force.dynamics
        return None if value is None else self.path_to(value, self.where("force", "dynamics"))

    def path_to(self, value: str, where: str) -> Path:
        """A file that the scene names at ``where``: variables replaced, relative to the scene's folder.

        Raises:
            SceneError: names a variable that is not set.
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
        return str(yaml.safe_dump(self.model_dump(mode="json"), sort_keys=False, allow_unicode=True))

    @model_validator(mode="before")
    @classmethod
    def _preset(cls, data: Any) -> Any:
        return presets.apply(data)

    @model_validator(mode="after")
    def _names(self) -> Scene:
        taken: dict[str, int] = {}
        named = []
        for i, thing in enumerate(self.objects):
            name = thing.name or (Path(thing.file).stem if thing.file else thing.shape or thing.source)
            if name in taken and thing.name:
                raise ValueError(f"two objects are named {name!r} | give each object its own name")
            count = taken[name] = taken.get(name, 0) + 1
            named.append(thing.model_copy(update={"name": name if count == 1 else f"{name}-{i + 1}"}))
        object.__setattr__(self, "objects", tuple(named))
        object.__setattr__(self, "guidance", fixture_names(self.guidance))
        wanted = self.operator.palpate.object
        if wanted and wanted not in [o.name for o in named]:
            names = ", ".join(o.name for o in named)
            raise ValueError(f"operator.palpate.object: there is no object {wanted!r} | objects: {names}")
        return self
