"""A fixture: a geometry, a role, a law and a policy; one item of the scene's list ``guidance``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, GetJsonSchemaHandler, field_validator, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from palpate import _core
from palpate.errors import GuidanceError
from palpate.guidance import one_line, yaml_text
from palpate.guidance.combine import Geometry
from palpate.guidance.geometry import Shape, placed, refused
from palpate.guidance.here import Here
from palpate.guidance.sections import Frame, Law, Ramp, Role, law_is_read
from palpate.values import Number, Positive, PositiveLength, Section

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_P = _core.Policy()
Share = Annotated[Number, Field(ge=0.0, le=1.0)]


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
    engage_deg: Positive | None = None
    """orient: takes part once the tool is nearer than this angle; always when left out [deg]"""
    release_deg: Positive | None = None
    """orient: until it is farther than this; never when left out [deg]"""
    rise: Annotated[Number, Field(ge=0.01)] = _P.rise
    """shortest time for its authority from 0 to 1 [s]"""
    fall: Annotated[Number, Field(ge=0.01)] = _P.fall
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

    @model_validator(mode="after")
    def _law_is_read(self) -> Self:
        law_is_read(self.role, self.law)
        return self

    @model_validator(mode="after")
    def _policy_is_read(self) -> Self:
        turns = self.role.name == "orient"
        place, turn = ("engage", "release", "a ramp by distance"), ("engage_deg", "release_deg", "a ramp by angle")
        given = {key for key in (*place, *turn) if getattr(self, key, None) is not None}
        given |= {f"a ramp by {ramp.by}" for ramp in self.ramps}
        for unread, read in zip(place if turns else turn, turn if turns else place, strict=True):
            if unread in given:
                raise ValueError(f"role {self.role.name} does not read {unread} | it reads {read}")
        return self

    @model_validator(mode="after")
    def _hysteresis(self) -> Self:
        for unit, engage, release in (("m", self.engage, self.release), ("deg", self.engage_deg, self.release_deg)):
            if engage is not None and release is not None and release < engage:
                told = f"release {release:g} {unit} is below engage {engage:g} {unit}"
                raise ValueError(f"{told} | it takes part below engage, until above release: release the larger")
        return self

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
        policy.engage = self.engage or float(np.radians(self.engage_deg or np.inf))
        policy.release = self.release or float(np.radians(self.release_deg or np.inf))
        policy.ramps = [ramp.core() for ramp in self.ramps]
        try:
            made = _core.Fixture(name, geometry, self.role.name, self.role.core(), self.law.name, self.law.core(),
                                 policy, self.enabled, self.frame.patience or np.inf)  # fmt: skip
            _core.Fixtures([made])
        except ValueError as error:
            raise refused(error, name) from None
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

        title = f"{self.name or self.role.name}: {self.role.name}"
        return plot(self.make_geometry(here), self.role, title, ax)

    def why(self, X_WT: npt.ArrayLike, V_WT: npt.ArrayLike | None = None, t: float = 0.0,
            here: Here | None = None) -> str:  # fmt: skip
        """What it does to a tool at X_WT (4, 4), or at p_WT (3,), in words; V_WT (6,): how the hand moves it."""
        from palpate.guidance.reasons import reasons

        return reasons(self.make(here), self.role, self.law, X_WT, V_WT, t)

    def to_yaml(self) -> str:
        """As one item of a scene's list ``guidance``; `from_yaml` reads it back."""
        return yaml_text.to_yaml([self])

    @classmethod
    def from_yaml(cls, text: str) -> Fixture:
        """The one fixture of a text, as `from_yaml`.

        Raises:
            GuidanceError: none or several.
        """
        found = yaml_text.from_yaml(text, cls)
        if len(found) != 1:
            raise GuidanceError(f"{len(found)} fixtures where one is wanted", mend="guidance.from_yaml reads lists")
        return found[0]
