"""Sections of the scene file for regions of an object that feel different, and for the motion of an object."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from palpate.arrays import Array
from palpate.values import Diagonal, NotNegative, Number, Positive, Section, Vector


class RegionSection(Section):
    """A ball or a box inside an object that feels otherwise: a tumour, a bone, a vessel."""

    name: str = "region"
    """how plots and messages call it"""
    at: Vector
    """its centre, in the object's own frame [m]"""
    box: Annotated[tuple[Positive, Positive, Positive], Field()] | None = None
    """lengths of a box along the object's axes; a ball when left out [m]"""
    radius: NotNegative = 0.0
    """of the ball, or of the box's round edges [m]"""
    blend: Positive = 0.002
    """width of the seam around it, over which it fades into the object; the force never steps [m]"""
    stiffness: Diagonal | None = None
    """as the object's when left out [N/m]"""
    damping: Diagonal | None = None
    """as the object's when left out [N s/m]"""
    friction: NotNegative | None = None
    """as the object's when left out [-]"""
    static_friction: NotNegative | None = None
    """as the object's when left out [-]"""

    @model_validator(mode="after")
    def _whole(self) -> RegionSection:
        require_sticking(self.friction, self.static_friction)
        if self.box is None and self.radius == 0.0:
            raise ValueError(f"region {self.name!r} has no size | give radius for a ball, or box: [x, y, z]")
        if self.box is not None and 2.0 * self.radius > min(self.box):
            told = f"edges rounded by {self.radius:g} m do not fit into a box {min(self.box):g} m wide"
            raise ValueError(f"region {self.name!r}: {told} | radius at most half of that, or leave box out for a ball")
        return self

    @property
    def half(self) -> Array:
        """(3,) half the lengths of the box without its round edges; zero for a ball [m]."""
        if self.box is None:
            return np.zeros(3)
        return 0.5 * np.array(self.box) - self.radius

    @property
    def reach(self) -> float:
        """Farthest from its centre that it is felt [m]."""
        return float(np.linalg.norm(self.half)) + self.radius + self.blend


class MotionSection(Section):
    """How an object moves, about where its pose says: a sinusoid, a steady motion, or both."""

    amplitude: Vector = (0.0, 0.0, 0.0)
    """of a sinusoidal shift, half the stroke, along the axes of W [m]"""
    turn_deg: Vector = (0.0, 0.0, 0.0)
    """of a sinusoidal turn, about axes of W through the middle of the object [deg]"""
    period: Annotated[Positive, Field(ge=0.01)] = 4.0
    """of the sinusoid; 4 s: quiet breathing, 0.9 s: a heart [s]"""
    phase_deg: Number = 0.0
    """of the sinusoid at the start [deg]"""
    velocity: Vector = (0.0, 0.0, 0.0)
    """of a steady shift [m/s]"""
    spin_deg: Vector = (0.0, 0.0, 0.0)
    """of a steady turn, about axes of W through the middle of the object [deg/s]"""


def require_sticking(friction: float | None, static_friction: float | None) -> None:
    """Refuse a static coefficient below the dynamic one."""
    if friction is not None and static_friction is not None and static_friction < friction:
        told = f"static_friction {static_friction:g} is less than friction {friction:g}"
        raise ValueError(f"{told} | what sticks holds at least as much as what slips: raise it, or leave it out")


def _several(value: Any) -> Any:
    return (value,) if isinstance(value, (dict, MotionSection)) else value


class _OneOrSeveral:
    """The JSON schema of a list whose only entry may stand without the list."""

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """The schema of an entry, or of a list of them."""
        one = handler.resolve_ref_schema(handler(core)["items"])
        return {"anyOf": [one, {"type": "array", "items": one}]}


#: One motion, or a list of motions that add up.
Motions = Annotated[
    tuple[MotionSection, ...],
    BeforeValidator(_several),
    _OneOrSeveral(),
]
