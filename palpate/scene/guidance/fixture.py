"""A fixture: a geometry, a role, a law and a policy; an item of the scene's list ``guidance``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, GetJsonSchemaHandler, field_validator, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from palpate import _core
from palpate.base.errors import GuidanceError, InvalidSceneError
from palpate.base.values import Number, Positive, Section
from palpate.scene.guidance import one_line
from palpate.scene.guidance.combine import Geometry
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.guidance.geometry import Shape, as_guidance_error, placed
from palpate.scene.guidance.sections import Frame, Law, Ramp, Role, check_law_keys

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from palpate import _guidance


_P = _core.Policy()
Share = Annotated[Number, Field(ge=0.0, le=1.0)]


class Fixture(Section):
    """A geometry, a role, a law and a policy.

        Fixture(Sphere(radius=0.03), role="forbid")
        Fixture(Path(file="suture.csv"), role={"name": "guide", "margin": 0.001}, law="potential", authority=0.5)

    Args:
        geometry: a `Shape`, or one line of text: ``margin: 3 mm around: vessel.stl``.
        values: the keys below.
    """

    ONE_LINE: ClassVar[dict[str, str]] = {example.partition(":")[0]: example for example in one_line.EXAMPLES}

    geometry: Geometry
    """shape and position of the constraint"""
    name: str = ""
    """name in plots and messages; the role when left out"""
    role: Role
    """type of constraint: a name, or a section with the name and more keys"""
    law: Law = Law()
    """force law of the constraint: a name, or a section with the name and more keys"""
    frame: Frame = Frame()
    """frame that carries the fixture: a name, or a section"""
    enabled: bool = True
    """false: the fixture has no effect until it is switched on"""
    hard: bool = _P.hard
    """true: the commanded tool pose is corrected, too, so that the tool always satisfies the constraint"""
    authority: Share = _P.authority
    """scale of the fixture's force, multiplied by its ramps [-]"""
    priority: Annotated[int, Field(strict=True, ge=-100, le=100)] = _P.priority
    """a fixture of lower priority never acts against one of higher priority; hard fixtures come first [-]"""
    engage: Positive | None = None
    """engages when the absolute constraint value falls below this; always engaged when left out [m]"""
    release: Positive | None = None
    """releases when the absolute constraint value exceeds this; never when left out [m]"""
    engage_deg: Positive | None = None
    """orient: engages when the absolute angle to the constraint falls below this; always engaged when left out [deg]"""
    release_deg: Positive | None = None
    """orient: releases when the absolute angle to the constraint exceeds this; never when left out [deg]"""
    rise: Annotated[Number, Field(ge=0.01)] = _P.rise
    """minimum time for the authority to rise from 0 to 1 [s]"""
    fall: Annotated[Number, Field(ge=0.01)] = _P.fall
    """minimum time for the authority to fall from 1 to 0 [s]"""
    ramps: Annotated[tuple[Ramp, ...], Field(max_length=8)] = ()
    """ramps that scale the authority; their values are multiplied"""

    def __init__(self, geometry: Shape | Geometry | str | None = None, /, **values: Any) -> None:
        if isinstance(geometry, str):
            values = {**_expanded(geometry), **values}
        elif geometry is not None:
            values["geometry"] = geometry
        super().__init__(**values)

    setattr(__init__, "__pydantic_base_init__", True)  # noqa: B010 - as in `Section`

    @model_validator(mode="before")
    @classmethod
    def _expand_line(cls, value: Any) -> Any:
        return one_line.expand(value)

    @field_validator("role", "law", mode="before")
    @classmethod
    def _name_as_section(cls, value: Any) -> Any:
        return {"name": value} if isinstance(value, str) else value

    @field_validator("frame", mode="before")
    @classmethod
    def _frame_as_section(cls, value: Any) -> Any:
        return {"of": value} if isinstance(value, str) else value

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        check_law_keys(self.role, self.law)
        return self

    @model_validator(mode="after")
    def _check_policy(self) -> Self:
        turns = self.role.name == "orient"
        place, turn = ("engage", "release", "a ramp by distance"), ("engage_deg", "release_deg", "a ramp by angle")
        given = {key for key in (*place, *turn) if getattr(self, key, None) is not None}
        given |= {f"a ramp by {ramp.by}" for ramp in self.ramps}
        for unread, read in zip(place if turns else turn, turn if turns else place, strict=True):
            if unread in given:
                raise ValueError(f"role {self.role.name} does not read {unread} | it reads {read}")
        return self

    @model_validator(mode="after")
    def _check_hysteresis(self) -> Self:
        for unit, engage, release in (("m", self.engage, self.release), ("deg", self.engage_deg, self.release_deg)):
            if engage is not None and release is not None and release < engage:
                what = f"release {release:g} {unit} is below engage {engage:g} {unit}"
                raise ValueError(f"{what} | it engages below engage and releases above release: release the larger")
        return self

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Schema of a section (with the one-line keys) or one line of text; role, law and frame also as names."""
        whole = handler.resolve_ref_schema(handler(core))
        for key in ("role", "law", "frame"):
            section = whole["properties"][key]
            whole["properties"][key] = {"anyOf": [{"type": "string"}, section], "description": section["description"]}
        whole["properties"] |= {key: {"description": words} for key, words in one_line.WORDS.items()}
        required = [whole.pop("required"), *([key] for key in one_line.KEYS)]
        return {**whole, "type": ["object", "string"], "anyOf": [{"required": keys} for keys in required]}

    def make(self, context: FixtureContext | None = None) -> _guidance.Fixture:
        """The fixture for the core.

        Raises:
            GuidanceError, MeshError, SurfaceError: a file, object or place is missing, or a value is invalid.
        """
        name = self.name or self.role.name
        geometry = self.make_geometry(context)
        if self.role.name == "forbid" and not geometry.solid and self.geometry.mesh is not None:
            raise GuidanceError(
                f"{name}: the mesh {self.geometry.mesh.file!r} is open, but a forbidden region needs an inside",
                why="the nearest wall pushes to the side where the tool is, which may be the wrong side",
                mend="palpate check FILE --repair closes small holes; for a two-sided wall wrap the mesh in an offset",
            )
        return self.make_with(geometry)

    def make_with(self, geometry: _guidance.Geometry) -> _guidance.Fixture:
        """The fixture for the core, with a geometry in the world.

        Raises:
            GuidanceError: role and geometry do not match, or a value is invalid.
        """
        from palpate import _guidance

        name = self.name or self.role.name
        policy = _core.Policy()
        policy.hard, policy.authority, policy.priority = self.hard, self.authority, self.priority
        policy.rise, policy.fall = self.rise, self.fall
        policy.engage = self.engage or float(np.radians(self.engage_deg or np.inf))
        policy.release = self.release or float(np.radians(self.release_deg or np.inf))
        policy.ramps = [ramp.core() for ramp in self.ramps]
        try:
            made = _guidance.Fixture(name, geometry, self.role.name, self.role.core(), self.law.name, self.law.core(),
                                 policy, self.enabled, self.frame.patience or np.inf)  # fmt: skip
            _guidance.Fixtures([made])
        except ValueError as error:
            raise as_guidance_error(error, name) from None
        return made

    def make_geometry(self, context: FixtureContext | None = None) -> _guidance.Geometry:
        """The geometry in the world, moving with the fixture's frame.

        Raises:
            GuidanceError, MeshError, SurfaceError: a file, object or place is missing, or a value is invalid.
        """
        from palpate import _guidance

        context = context or FixtureContext()
        if self.geometry.object is not None:
            context.body(self.geometry.object.name)  # a missing object is reported as an object, not as a frame
        frame, X_FG = context.frame(self.frame.of), self.frame.pose.matrix()
        X_WF = np.eye(4) if isinstance(frame, _core.LiveFrame) else frame.at(0.0)[0]
        shape = self.geometry.make(context, X_WF @ X_FG)
        if self.frame.of == "world":
            return placed(shape, X_FG)
        return _guidance.PlacedGeometry(shape, X_FG, frame)

    def plot(self, ax: Axes | None = None, context: FixtureContext | None = None) -> Axes:
        """Draw the fixture with matplotlib: allowed regions green, forbidden regions red, and the normals."""
        from palpate.scene.guidance.plot import plot

        title = f"{self.name or self.role.name}: {self.role.name}"
        return plot(self.make_geometry(context), self.role, title, ax)

    def why(self, X_WT: npt.ArrayLike, V_WT: npt.ArrayLike | None = None, t: float = 0.0,
            context: FixtureContext | None = None) -> str:  # fmt: skip
        """Explain in words the fixture's force on a tool.

        Args:
            X_WT: pose (4, 4) of the tool, or its position (3,) [m].
            V_WT: velocity (6,) of the tool over its angular velocity, in W [m/s, rad/s]; zero when None.
            t: time [s].
            context: files, frames, places and objects that the fixture names.
        """
        from palpate.scene.guidance.reasons import reasons

        return reasons(self.make(context), self.role, self.law, X_WT, V_WT, t)

    def to_yaml(self) -> str:
        """YAML text of one item of a scene's list ``guidance``; `from_yaml` reads it back."""
        from palpate.scene.guidance import yaml_text

        return yaml_text.to_yaml([self])

    @classmethod
    def from_yaml(cls, text: str) -> Fixture:
        """The single fixture in a YAML text, in the format of `from_yaml`.

        Raises:
            GuidanceError: the text holds none or several fixtures, or a value is invalid.
        """
        from palpate.scene.guidance import yaml_text

        found = yaml_text.from_yaml(text, cls)
        if len(found) != 1:
            raise GuidanceError(f"{len(found)} fixtures where one is expected", mend="guidance.from_yaml reads lists")
        return found[0]


def _expanded(line: str) -> Any:
    """The values of a fixture in one line of text; an invalid line is refused as values are."""
    try:
        return one_line.expand(line)
    except ValueError as error:
        what, _, mend = str(error).partition(" | ")
        raise InvalidSceneError(what, where="Fixture", mend=mend) from None
