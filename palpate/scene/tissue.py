"""Sections of the scene file for regions with other material values, and for the motion of an object."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from palpate.base.arrays import Array
from palpate.base.values import Diagonal, NotNegative, Number, Positive, Section, Vector


class RegionSection(Section):
    """A ball or a box inside an object with other material values, for example a tumour, a bone or a vessel."""

    name: str = "region"
    """name in plots and messages"""
    at: Vector
    """centre in the object's frame [m]"""
    box: Annotated[tuple[Positive, Positive, Positive], Field()] | None = None
    """lengths of a box along the object's axes; the region is a ball when left out [m]"""
    radius: NotNegative = 0.0
    """radius of the ball, or of the rounded edges of the box [m]"""
    blend: Positive = 0.002
    """width of the transition from region to object, which keeps the force continuous [m]"""
    stiffness: Diagonal | None = None
    """stiffness; the object's when left out [N/m]"""
    damping: Diagonal | None = None
    """damping; the object's when left out [N s/m]"""
    friction: NotNegative | None = None
    """Coulomb friction coefficient; the object's when left out [-]"""
    static_friction: NotNegative | None = None
    """static friction coefficient; the object's when left out [-]"""

    @model_validator(mode="after")
    def _check(self) -> RegionSection:
        check_friction(self.friction, self.static_friction)
        if self.box is None and self.radius == 0.0:
            raise ValueError(f"region {self.name!r} has no size | give radius for a ball, or box: [x, y, z]")
        if self.box is not None and 2.0 * self.radius > min(self.box):
            what = f"edges rounded by {self.radius:g} m do not fit into a box {min(self.box):g} m wide"
            raise ValueError(f"region {self.name!r}: {what} | radius at most half of that, or leave box out for a ball")
        return self

    @property
    def half(self) -> Array:
        """Half lengths (3,) of the box without its rounded edges; zero for a ball [m]."""
        if self.box is None:
            return np.zeros(3)
        return 0.5 * np.array(self.box) - self.radius

    @property
    def reach(self) -> float:
        """Largest distance from the centre at which the region has an effect [m]."""
        return float(np.linalg.norm(self.half)) + self.radius + self.blend


class MotionSection(Section):
    """Motion of an object relative to its pose: a sinusoid, a steady motion, or both."""

    amplitude: Vector = (0.0, 0.0, 0.0)
    """amplitude (half the stroke) of a sinusoidal translation along the axes of W [m]"""
    turn_deg: Vector = (0.0, 0.0, 0.0)
    """amplitude of a sinusoidal rotation about axes of W through the centre of the object [deg]"""
    period: Annotated[Positive, Field(ge=0.01)] = 4.0
    """period of the sinusoid; breathing at rest: 4 s, heartbeat: 0.9 s [s]"""
    phase_deg: Number = 0.0
    """phase of the sinusoid at the start [deg]"""
    velocity: Vector = (0.0, 0.0, 0.0)
    """velocity of a steady translation [m/s]"""
    spin_deg: Vector = (0.0, 0.0, 0.0)
    """angular velocity of a steady rotation about axes of W through the centre of the object [deg/s]"""


def check_friction(friction: float | None, static_friction: float | None) -> None:
    """Raise ValueError if the static friction coefficient is below the dynamic one."""
    if friction is not None and static_friction is not None and static_friction < friction:
        what = f"static_friction {static_friction:g} is less than friction {friction:g}"
        raise ValueError(f"{what} | static friction is never below dynamic friction: raise it, or leave it out")


def _as_list(value: Any) -> Any:
    return (value,) if isinstance(value, (dict, MotionSection)) else value


class _OneOrSeveral:
    """JSON schema of a list whose single entry may be given without the list."""

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """The schema of an entry, or of a list of entries."""
        one = handler.resolve_ref_schema(handler(core)["items"])
        return {"anyOf": [one, {"type": "array", "items": one}]}


#: One motion, or a list of motions that are added.
Motions = Annotated[
    tuple[MotionSection, ...],
    BeforeValidator(_as_list),
    _OneOrSeveral(),
]
