"""Sections of a fixture: role (constraint), law (force), ramps (authority) and frame."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from palpate import _core
from palpate.base.values import NotNegative, Number, Positive, Section, Vector, units
from palpate.base.values import Pose as PoseSection

_R, _L = _core.GuidanceRoleOptions(), _core.GuidanceLawOptions()
RoleName = Literal["guide", "forbid", "keep-in", "orient", "limit", "rcm"]
LawName = Literal["spring", "potential", "admittance", "optimise"]


#: Keys that each role, and each law, reads in addition to its name.
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


#: Keys of a law for positions, and the corresponding keys for angles.
OF_PLACE_AND_ANGLE = {
    "stiffness": "turning_stiffness",
    "damping": "turning_damping",
    "force": "moment",
    "range": "turning_range_deg",
}


def check_law_keys(role: Role, law: Law) -> None:
    """Raise ValueError for a translational key in the law of role `orient`, or a rotational key with other roles."""
    for place, turn in OF_PLACE_AND_ANGLE.items():
        unread, read = (place, turn) if role.name == "orient" else (turn, place)
        if unread in law.model_fields_set and getattr(law, unread) != Law.model_fields[unread].default:
            raise ValueError(f"role {role.name} does not read law.{unread} | it reads law.{read}")


def _check_keys(section: Role | Law, read: set[str]) -> None:
    """Raise ValueError for a given key that differs from its default but is not in `read`."""
    fields = type(section).model_fields
    for key in sorted(section.model_fields_set - read - {"name"}):
        if getattr(section, key) != fields[key].default:
            raise ValueError(
                f"{section.name} does not read {key} | it reads {', '.join(sorted(read))}: leave {key} out"
            )


#: A path crosses itself if two of its stretches come closer than this [m].
CROSSING = 2e-4


class Role(Section):
    """Constraint on the tool relative to the geometry. Each role reads its own keys."""

    name: RoleName
    """guide: attract the tool; forbid: keep the tool out; keep-in: keep the tool inside; orient: align the tool; limit:
    limit speed, force or workspace inside; rcm: the shaft passes through the geometry"""
    margin: NotNegative = _R.margin
    """guide: free distance; forbid: clearance outside the geometry; keep-in: clearance inside it [m]"""
    angle_deg: NotNegative = float(np.degrees(_R.angle))
    """orient: free angle [deg]"""
    axis: Vector = (_R.axis[0], _R.axis[1], _R.axis[2])
    """orient, rcm: axis of the tool in T that is aligned, or that slides through the centre [-]"""
    target: Literal["axis", "normal", "frame"] = _R.target
    """orient: align with the geometry's axis, against its normal, or with its whole frame"""
    speed: NotNegative = _R.speed
    """limit: maximum speed of the tool; 0: no limit [m/s]"""
    force: NotNegative = _R.force
    """limit: maximum contact force on the tool; 0: no limit [N]"""

    @model_validator(mode="after")
    def _check_read(self) -> Self:
        _check_keys(self, OF_ROLE[self.name] - ({"axis"} if self.target == "frame" else set()))
        return self

    def core(self) -> _core.GuidanceRoleOptions:
        """The options for the core."""
        o = _core.GuidanceRoleOptions()
        o.margin, o.angle, o.axis = self.margin, float(np.radians(self.angle_deg)), np.array(self.axis)
        o.target, o.speed, o.force = self.target, self.speed, self.force
        return o


class Law(Section):
    """Force law of a fixture; each law reads its own keys. Forces act on the tool, and the mapping scales them."""

    name: LawName = "spring"
    """spring: spring and damper to the closest point; potential: spring with range and saturation; admittance: free
    motion along the geometry, slow motion across; optimise: all such fixtures together, by a quadratic program"""
    stiffness: NotNegative = _L.K
    """stiffness of the spring [N/m]"""
    damping: NotNegative = _L.B
    """damping against motion that increases the violation [N s/m]"""
    turning_stiffness: NotNegative = _L.K_turn
    """rotational stiffness [N m/rad]"""
    turning_damping: NotNegative = _L.B_turn
    """rotational damping [N m s/rad]"""
    force: NotNegative = _L.force
    """potential, optimise: maximum force [N]"""
    moment: NotNegative = _L.moment
    """potential, optimise: maximum moment [N m]"""
    range: Positive = _L.range
    """potential: distance within which the fixture attracts or repels [m]"""
    turning_range_deg: Positive = float(np.degrees(_L.range_turn))
    """potential: angle within which the fixture attracts [deg]"""
    ratio: Annotated[Number, Field(ge=0.01, le=1.0)] = _L.ratio
    """admittance: speed across the geometry per speed along it [-]"""

    @model_validator(mode="after")
    def _check_read(self) -> Self:
        _check_keys(self, OF_LAW[self.name])
        return self

    def core(self) -> _core.GuidanceLawOptions:
        """The options for the core."""
        o = _core.GuidanceLawOptions()
        o.K, o.B, o.K_turn, o.B_turn = self.stiffness, self.damping, self.turning_stiffness, self.turning_damping
        o.force, o.moment, o.range, o.ratio = self.force, self.moment, self.range, self.ratio
        o.range_turn = float(np.radians(self.turning_range_deg))
        return o


_RAMP_UNITS = {"distance": "m", "angle": "deg", "time": "s", "force": "N"}


class Ramp(Section):
    """Factor of the authority, linear in a measured quantity: 0 at `start`, 1 at `end`; either may be larger."""

    by: Literal["pedal", "distance", "angle", "time", "force"] = "pedal"
    """measured quantity: guidance pedal [0-1], distance to the constraint [m], for `orient` the angle to the constraint
    [deg], time since engagement [s], or force of the hand [N]"""
    start: Number = 0.0
    """value at which the factor is 0; a distance may have a unit: 2 cm"""
    end: Number = 1.0
    """value at which the factor is 1"""

    @model_validator(mode="before")
    @classmethod
    def _convert_ends(cls, data: Any) -> Any:
        given = data if isinstance(data, dict) else {}
        unit = _RAMP_UNITS.get(str(given.get("by", "pedal")), "")
        texts = {key: units.convert(given[key], unit) for key in ("start", "end") if isinstance(given.get(key), str)}
        for key, value in texts.items():
            if value is None:
                what = f"{key}: {given[key]!r} of a ramp by {given.get('by', 'pedal')}"
                raise ValueError(
                    f"{what} | write a plain number" + (f" [{unit}], or one with its unit" if unit else "")
                )
        return {**data, **texts} if texts else data

    @model_validator(mode="after")
    def _check_span(self) -> Self:
        if self.start == self.end:
            raise ValueError(f"a ramp from {self.start:g} to {self.end:g} is empty | start and end must differ")
        return self

    def core(self) -> _core.Ramp:
        """The ramp for the core, where an angle is a distance in rad."""
        if self.by == "angle":
            return _core.Ramp("distance", float(np.radians(self.start)), float(np.radians(self.end)))
        return _core.Ramp(self.by, self.start, self.end)


class Frame(Section):
    """Frame that carries a fixture, and the pose of the geometry in that frame."""

    of: str = "world"
    """world, leader, follower, tool, camera, or a (possibly moving) object of the scene"""
    pose: PoseSection = PoseSection()
    """X_FG: pose of the geometry in the frame"""
    patience: Positive | None = None
    """camera: timeout after which the fixture fades out if no pose was received; never when left out [s]"""
