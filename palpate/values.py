"""Types of the values in scene files. Values are in SI units; a key in another unit names it (``rpy_deg``)."""

from __future__ import annotations

import math
import re
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0.0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.0)]
Vector = tuple[Number, Number, Number]


def _repeat_number(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        return value
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"must be a number, or a list of three. Got: {value!r:.60} | write e.g. 500")
    return (value, value, value)


#: Diagonal of a (3, 3) matrix in W: one number for all axes, or one number per axis.
Diagonal = Annotated[
    tuple[NotNegative, NotNegative, NotNegative],
    BeforeValidator(_repeat_number),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "number", "minimum": 0},
                {"type": "array", "items": {"type": "number", "minimum": 0}, "minItems": 3, "maxItems": 3},
            ]
        }
    ),
]


class Section(BaseModel):
    """A section of a scene file. It is immutable, and an unknown key is an error.

    The string below a field describes the field. `palpate.scene.descriptions` reads these strings on demand, because
    pydantic would read them at every import.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")


class Pose(Section):
    """Pose of one frame in another."""

    xyz: Vector = (0.0, 0.0, 0.0)
    """origin [m]"""
    rpy_deg: Vector = (0.0, 0.0, 0.0)
    """roll, pitch, yaw about fixed x, then y, then z [deg]"""

    def matrix(self) -> npt.NDArray[np.float64]:
        """X_AB (4, 4) with R = Rz(yaw) Ry(pitch) Rx(roll)."""
        (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in np.radians(self.rpy_deg))
        X = np.eye(4)
        X[:3, :3] = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
        X[:3, 3] = self.xyz
        return X


UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
"""Length units of files and poses in metres."""

_WRITTEN = {"um": 1e-6, **UNITS}
_LENGTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z]+)\s*")


def metres(value: Any) -> Any:
    """Length in metres: ``3 mm`` gives 0.003; a number is returned unchanged.

    Raises:
        ValueError: the text is not a number with a known unit.
    """
    if not isinstance(value, str):
        return value
    match = _LENGTH.fullmatch(value)
    if match is None or match[2] not in _WRITTEN:
        units = ", ".join(_WRITTEN)
        raise ValueError(f"{value!r} is not a length | write metres, or a number with its unit: 3 mm ({units})")
    return float(f"{float(match[1]) * _WRITTEN[match[2]]:.15g}")


def _length_schema(**limits: float) -> Any:
    number = {"type": "number", **{{"gt": "exclusiveMinimum", "ge": "minimum"}[k]: v for k, v in limits.items()}}
    return WithJsonSchema({"anyOf": [number, {"type": "string", "pattern": r"^.*\d\s*(um|mm|cm|m|in)$"}]})


#: Length [m]: a number of metres, or text with a unit.
Length = Annotated[float, Field(strict=True, allow_inf_nan=False), BeforeValidator(metres), _length_schema()]
PositiveLength = Annotated[
    float, Field(strict=True, allow_inf_nan=False, gt=0.0), BeforeValidator(metres), _length_schema(gt=0.0)
]
NotNegativeLength = Annotated[
    float, Field(strict=True, allow_inf_nan=False, ge=0.0), BeforeValidator(metres), _length_schema(ge=0.0)
]


def _position(value: Any) -> Any:
    return tuple(metres(x) for x in value) if isinstance(value, (list, tuple)) else value


#: A position (3,) in the fixture's frame [m], or the name of a place of the scene.
Place = Annotated[Vector | str, BeforeValidator(_position)]
