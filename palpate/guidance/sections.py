"""Sections of a fixture: what is wanted, how the hand is told, what fades it, what it is attached to."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from palpate import _core
from palpate.values import Length, NotNegative, NotNegativeLength, Number, Positive, PositiveLength, Section, Vector
from palpate.values import Pose as PoseSection

_R, _L = _core.GuidanceRoleOptions(), _core.GuidanceLawOptions()
RoleName = Literal["guide", "forbid", "keep-in", "orient", "limit", "rcm"]
LawName = Literal["spring", "potential", "admittance", "optimise"]


#: What each role, and each law, reads beside its name.
OF_ROLE = {
    "guide": {"margin"},
    "forbid": {"margin"},
    "keep-in": {"margin"},
    "orient": {"angle_deg", "axis", "target"},
    "limit": {"margin", "speed", "force"},
    "rcm": {"margin", "axis"},
}
_SPRING = {"stiffness", "damping", "turning_stiffness", "turning_damping"}
OF_LAW = {
    "spring": _SPRING,
    "potential": _SPRING | {"force", "moment", "range", "turning_range_deg"},
    "admittance": {"damping", "turning_damping", "ratio"},
    "optimise": _SPRING | {"force", "moment"},
}


#: Of a law: what is read of a place, and in its stead of an angle.
OF_PLACE_AND_ANGLE = {
    "stiffness": "turning_stiffness",
    "damping": "turning_damping",
    "force": "moment",
    "range": "turning_range_deg",
}


def law_is_read(role: Role, law: Law) -> None:
    """Raises ValueError for a key of the law that is about a place where an angle is wanted, or the other way round."""
    for place, turn in OF_PLACE_AND_ANGLE.items():
        unread, read = (place, turn) if role.name == "orient" else (turn, place)
        if unread in law.model_fields_set and getattr(law, unread) != Law.model_fields[unread].default:
            raise ValueError(f"role {role.name} does not read law.{unread} | it reads law.{read}")


def _all_are_read(section: Role | Law, read: set[str]) -> None:
    """Raises ValueError for a key that is given, differs from its default, and is not read."""
    fields = type(section).model_fields
    for key in sorted(section.model_fields_set - read - {"name"}):
        if getattr(section, key) != fields[key].default:
            raise ValueError(
                f"{section.name} does not read {key} | it reads {', '.join(sorted(read))}: leave {key} out"
            )


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

    @model_validator(mode="after")
    def _read(self) -> Self:
        _all_are_read(self, OF_ROLE[self.name] - ({"axis"} if self.target == "frame" else set()))
        return self

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
    ratio: Annotated[Number, Field(ge=0.01, le=1.0)] = _L.ratio
    """admittance: speed across what is free per speed along it [-]"""

    @model_validator(mode="after")
    def _read(self) -> Self:
        _all_are_read(self, OF_LAW[self.name])
        return self

    def core(self) -> _core.GuidanceLawOptions:
        """As the core knows it."""
        o = _core.GuidanceLawOptions()
        o.K, o.B, o.K_turn, o.B_turn = self.stiffness, self.damping, self.turning_stiffness, self.turning_damping
        o.force, o.moment, o.range, o.ratio = self.force, self.moment, self.range, self.ratio
        o.range_turn = float(np.radians(self.turning_range_deg))
        return o


class Ramp(Section):
    """Authority that fades with something measured: 0 at `start`, 1 at `end`, either may be the larger."""

    by: Literal["pedal", "distance", "angle", "time", "force"] = "pedal"
    """guidance pedal [0-1], distance from what is wanted [m], of `orient` the angle from it [deg], time since it was
    engaged [s], force of the hand [N]"""
    start: Length = 0.0
    """authority is 0 here; of a distance also with its unit: 2 cm"""
    end: Length = 1.0
    """and 1 here"""

    @model_validator(mode="before")
    @classmethod
    def _of_a_length(cls, value: Any) -> Any:
        given = value if isinstance(value, dict) else {}
        for key in ("start", "end"):
            if isinstance(given.get(key), str) and given.get("by", "pedal") != "distance":
                raise ValueError(f"{key}: {given[key]!r} of a ramp by {given.get('by', 'pedal')} | a plain number")
        return value

    @model_validator(mode="after")
    def _not_the_same(self) -> Self:
        if self.start == self.end:
            raise ValueError(f"a ramp from {self.start:g} to {self.end:g} is none | start and end must differ")
        return self

    def core(self) -> _core.Ramp:
        """As the core knows it, to which an angle is a distance [rad]."""
        if self.by == "angle":
            return _core.Ramp("distance", float(np.radians(self.start)), float(np.radians(self.end)))
        return _core.Ramp(self.by, self.start, self.end)


class Frame(Section):
    """Where a fixture is attached, and how it sits there."""

    of: str = "world"
    """world, leader, follower, tool, camera, or an object of the scene, with its motion"""
    pose: PoseSection = PoseSection()
    """X_FG: the geometry in that frame"""
    patience: Positive | None = None
    """camera: the fixture fades out once the frame is told no longer; never when left out [s]"""
