"""A fixture: a geometry, a role, a law and a policy; one item of the scene's list ``guidance``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
import yaml
from pydantic import Field, GetJsonSchemaHandler, TypeAdapter, ValidationError, field_validator, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from palpate import _core
from palpate.errors import GuidanceError
from palpate.guidance import one_line
from palpate.guidance.combine import Geometry
from palpate.guidance.geometry import Shape, placed
from palpate.guidance.here import Here
from palpate.guidance.values import NotNegativeLength, PositiveLength
from palpate.scene.values import NotNegative, Number, Positive, Section, Vector
from palpate.scene.values import Pose as PoseSection

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = npt.NDArray[np.float64]

_R, _L, _P = _core.GuidanceRoleOptions(), _core.GuidanceLawOptions(), _core.Policy()
Share = Annotated[Number, Field(ge=0.0, le=1.0)]
RoleName = Literal["guide", "forbid", "keep-in", "orient", "limit", "rcm"]
LawName = Literal["spring", "potential", "admittance", "optimise"]


class Role(Section):
    """What is wanted of the tool at the geometry; each role reads what concerns it."""

    name: RoleName
    """guide: attracts; forbid: stay out; keep-in: stay inside; orient: turn to it; limit: speed, force or workspace
    inside; rcm: the shaft passes through"""
    margin: NotNegativeLength = _R.margin
    """guide: free play; forbid: kept clear around; keep-in: kept clear inside [m]"""
    angle_deg: NotNegative = float(np.degrees(_R.angle))
    """orient: free tilt [deg]"""
    axis: Vector = (_R.axis[0], _R.axis[1], _R.axis[2])
    """orient, rcm: of the tool, in T, what points or slides [-]"""
    target: Literal["axis", "normal", "frame"] = _R.target
    """orient: to the geometry's axis, against its normal, or as its whole frame"""
    speed: NotNegative = _R.speed
    """limit: of the tool; 0: none [m/s]"""
    force: NotNegative = _R.force
    """limit: of what it touches, on the tool; 0: none [N]"""

    def core(self) -> _core.GuidanceRoleOptions:
        """As the core knows it."""
        o = _core.GuidanceRoleOptions()
        o.margin, o.angle, o.axis = self.margin, float(np.radians(self.angle_deg)), np.array(self.axis)
        o.target, o.speed, o.force = self.target, self.speed, self.force
        return o


class Law(Section):
    """How the hand is told; each law reads what concerns it. On the tool's side: the hand feels it by the mapping."""

    name: LawName = "spring"
    """spring: spring and damper to the closest place; potential: with range and saturation; admittance: free along,
    hard across; optimise: all such fixtures together, by a quadratic program"""
    stiffness: NotNegative = _L.K
    """of the spring [N/m]"""
    damping: NotNegative = _L.B
    """against what is not wanted [N s/m]"""
    turning_stiffness: NotNegative = _L.K_turn
    """the same of an angle [N m/rad]"""
    turning_damping: NotNegative = _L.B_turn
    """the same of an angle [N m s/rad]"""
    force: NotNegative = _L.force
    """potential, optimise: most that it pulls [N]"""
    moment: NotNegative = _L.moment
    """the same of an angle [N m]"""
    range: PositiveLength = _L.range
    """potential: attracts or repels from so far [m]"""
    turning_range_deg: Positive = float(np.degrees(_L.range_turn))
    """potential: the same of an angle [deg]"""
    ratio: Annotated[Number, Field(gt=0.0, le=1.0)] = _L.ratio
    """admittance: speed across what is free per speed along it [-]"""

    def core(self) -> _core.GuidanceLawOptions:
        """As the core knows it."""
        o = _core.GuidanceLawOptions()
        o.K, o.B, o.K_turn, o.B_turn = self.stiffness, self.damping, self.turning_stiffness, self.turning_damping
        o.force, o.moment, o.range, o.ratio = self.force, self.moment, self.range, self.ratio
        o.range_turn = float(np.radians(self.turning_range_deg))
        return o


class Ramp(Section):
    """Authority that fades with something measured: 0 at `start`, 1 at `end`, either may be the larger."""

    by: Literal["pedal", "distance", "time", "force"] = "pedal"
    """guidance pedal [0-1], distance from what is wanted [m], time since it was engaged [s], force of the hand [N]"""
    start: Number = 0.0
    """authority is 0 here"""
    end: Number = 1.0
    """and 1 here"""


class Frame(Section):
    """Where a fixture is attached, and how it sits there."""

    of: str = "world"
    """world, leader, follower, tool, camera, or an object of the scene, with its motion"""
    pose: PoseSection = PoseSection()
    """X_FG: the geometry in that frame"""
    patience: Positive | None = None
    """camera: the fixture fades out once the frame is told no longer; never when left out [s]"""


class Fixture(Section):
    """A geometry, a role, a law and a policy.

        Fixture(Sphere(radius=0.03), role="forbid")
        Fixture(Path(file="suture.csv"), role={"name": "guide", "margin": 0.001}, law="potential", authority=0.5)

    Args:
        geometry: a `Shape`, or the text of one line: ``margin: 3 mm around: vessel.stl``.
        values: the keys below.
    """

    geometry: Geometry
    """where"""
    name: str = ""
    """how plots and messages call it; its role when left out"""
    role: Role
    """what is wanted there: a name, or a section with it and more"""
    law: Law = Law()
    """how the hand is told: a name, or a section with it and more"""
    frame: Frame = Frame()
    """what it is attached to: a name, or a section"""
    enabled: bool = True
    """false: it is there, but does nothing until it is switched on"""
    hard: bool = _P.hard
    """the tool's goal is corrected as well: the tool does not go there, whatever the hand does"""
    authority: Share = _P.authority
    """how much of it counts, times its ramps [-]"""
    priority: Annotated[int, Field(strict=True, ge=-100, le=100)] = _P.priority
    """a lower one never pulls against a higher one; hard ones come first [-]"""
    engage: PositiveLength | None = None
    """takes part once the tool is nearer than this to what is wanted; always when left out [m]"""
    release: PositiveLength | None = None
    """until it is farther than this; never when left out [m]"""
    rise: NotNegative = _P.rise
    """shortest time for its authority from 0 to 1 [s]"""
    fall: NotNegative = _P.fall
    """and back [s]"""
    ramps: Annotated[tuple[Ramp, ...], Field(max_length=8)] = ()
    """its authority fades with each of them"""

    def __init__(self, geometry: Shape | Geometry | str | None = None, /, **values: Any) -> None:
        if isinstance(geometry, str):
            values = {**one_line.expand(geometry), **values}
        elif geometry is not None:
            values["geometry"] = geometry
        super().__init__(**values)

    @model_validator(mode="before")
    @classmethod
    def _expanded(cls, value: Any) -> Any:
        return one_line.expand(value)

    @field_validator("role", "law", mode="before")
    @classmethod
    def _named(cls, value: Any) -> Any:
        return {"name": value} if isinstance(value, str) else value

    @field_validator("frame", mode="before")
    @classmethod
    def _frame(cls, value: Any) -> Any:
        return {"of": value} if isinstance(value, str) else value

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """The section, with the keys of the lines, or the text of one; role, law and frame by name alone, too."""
        whole = handler.resolve_ref_schema(handler(core))
        for key in ("role", "law", "frame"):
            section = whole["properties"][key]
            whole["properties"][key] = {"anyOf": [{"type": "string"}, section], "description": section["description"]}
        whole["properties"] |= {key: {"description": words} for key, words in one_line.WORDS.items()}
        required = [whole.pop("required"), *([key] for key in one_line.KEYS)]
        return {**whole, "type": ["object", "string"], "anyOf": [{"required": keys} for keys in required]}

    def make(self, here: Here | None = None) -> _core.Fixture:
        """As the core knows it.

        Raises:
            GuidanceError, MeshError, SurfaceError: what it names is not there, or cannot be.
        """
        name = self.name or self.role.name
        geometry = self.make_geometry(here)
        if self.role.name == "forbid" and not geometry.solid and self.geometry.mesh is not None:
            raise GuidanceError(
                f"{name}: the mesh {self.geometry.mesh.file!r} is open, a forbidden region needs an inside",
                why="the nearest wall pushes to the side that the tool is on, and that may be the wrong one",
                mend="palpate check FILE --repair closes small holes; for a wall of both sides wrap it: offset",
            )
        return self.made_of(geometry)

    def made_of(self, geometry: _core.Geometry) -> _core.Fixture:
        """As the core knows it, of a geometry in the world.

        Raises:
            GuidanceError: role and geometry, or the values, do not fit.
        """
        name = self.name or self.role.name
        policy = _core.Policy()
        policy.hard, policy.authority, policy.priority = self.hard, self.authority, self.priority
        policy.rise, policy.fall = self.rise, self.fall
        policy.engage = np.inf if self.engage is None else self.engage
        policy.release = np.inf if self.release is None else self.release
        policy.ramps = [_core.Ramp(ramp.by, ramp.start, ramp.end) for ramp in self.ramps]
        try:
            made = _core.Fixture(name, geometry, self.role.name, self.role.core(), self.law.name, self.law.core(),
                                 policy, self.enabled, self.frame.patience or np.inf)  # fmt: skip
            _core.Fixtures([made])
        except ValueError as error:
            what, _, mend = str(error).partition("; ")
            raise GuidanceError(what, where=name, mend=mend) from None
        return made

    def make_geometry(self, here: Here | None = None) -> _core.Geometry:
        """Its geometry in the world, moving with its frame.

        Raises:
            GuidanceError, MeshError, SurfaceError: what it names is not there, or cannot be.
        """
        here = here or Here()
        if self.geometry.object is not None:
            here.body(self.geometry.object.name)  # told as an object that is missing, not as a frame
        frame, X_FG = here.frame(self.frame.of), self.frame.pose.matrix()
        X_WF = np.eye(4) if isinstance(frame, _core.LiveFrame) else frame.at(0.0)[0]
        shape = self.geometry.make(here, X_WF @ X_FG)
        if self.frame.of == "world":
            return placed(shape, X_FG)
        return _core.PlacedGeometry(shape, X_FG, frame)

    def plot(self, ax: Axes | None = None, here: Here | None = None) -> Axes:
        """Draw it with matplotlib: what is allowed green, what is forbidden red, and its normals."""
        from palpate.guidance.plot import plot

        return plot(self, ax, here)

    def why(self, X_WT: npt.ArrayLike, V_WT: npt.ArrayLike | None = None, t: float = 0.0,
            here: Here | None = None) -> str:  # fmt: skip
        """What it does to a tool at X_WT (4, 4), or at p_WT (3,), in words; V_WT (6,): how the hand moves it."""
        from palpate.guidance.why import why

        return why(self, X_WT, V_WT, t, here)

    def to_yaml(self) -> str:
        """As one item of a scene's list ``guidance``; `from_yaml` reads it back."""
        return to_yaml([self])

    @classmethod
    def from_yaml(cls, text: str) -> Fixture:
        """The one fixture of a text, as `from_yaml`.

        Raises:
            GuidanceError: none or several.
        """
        found = from_yaml(text)
        if len(found) != 1:
            raise GuidanceError(f"{len(found)} fixtures where one is wanted", mend="guidance.from_yaml reads lists")
        return found[0]


def to_yaml(fixtures: Iterable[Fixture]) -> str:
    """A scene's list ``guidance``: what differs from the defaults."""
    data = [f.model_dump(mode="json", exclude_defaults=True) for f in fixtures]
    return str(yaml.safe_dump(data, sort_keys=False, allow_unicode=True, default_flow_style=None, width=110))


def from_yaml(text: str) -> tuple[Fixture, ...]:
    """Fixtures from a list of YAML, of sections or of lines.

    Raises:
        GuidanceError: it is none; names the first mistake.
    """
    try:
        data = yaml.safe_load(one_line.readable(text))
        return TypeAdapter(tuple[Fixture, ...]).validate_python(data if isinstance(data, list) else [data])
    except yaml.YAMLError as error:
        raise GuidanceError("not valid YAML", why=" ".join(str(error).split()), mend="a list of fixtures") from None
    except ValidationError as error:
        from palpate.scene.explain import spell

        first = error.errors(include_url=False)[0]
        what, _, mend = str(first.get("ctx", {}).get("error", first["msg"])).partition(" | ")
        raise GuidanceError(f"{spell(tuple(first['loc']))}: {what}", mend=mend) from None


def named(guidance: tuple[Fixture, ...]) -> tuple[Fixture, ...]:
    """Each with a name of its own: its role where none is given, and a number where one is taken.

    Raises:
        ValueError: two were given the same name.
    """
    out: list[Fixture] = []
    for i, fixture in enumerate(guidance):
        name, taken = fixture.name or fixture.role.name, [f.name for f in out]
        if name in taken and fixture.name:
            raise ValueError(f"two fixtures are named {name!r} | give each fixture its own name")
        out.append(fixture.model_copy(update={"name": f"{name}-{i + 1}" if name in taken else name}))
    return tuple(out)
