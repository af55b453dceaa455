"""Types of the values in scene files. SI units without a suffix; a key that is not SI says its unit in its name."""

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


def _three(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        return value
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"must be a number, or a list of three. Got: {value!r:.60} | write e.g. 500")
    return (value, value, value)


#: One number for all axes, or one for each axis of W.
Diagonal = Annotated[
    tuple[NotNegative, NotNegative, NotNegative],
    BeforeValidator(_three),
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
    """A part of a scene file: unchangeable, and unknown keys are errors.

    The text below a field describes it. `palpate.scene.descriptions` reads these texts when they are wanted: pydantic
    would read them at every import.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")


class Pose(Section):
    """Where one frame is in another."""

    xyz: Vector = (0.0, 0.0, 0.0)
    """origin [m]"""
    rpy_deg: Vector = (0.0, 0.0, 0.0)
    """roll, pitch, yaw about fixed x, then y, then z [deg]"""

    def matrix(self) -> npt.NDArray[np.float64]:
        """X_AB as a 4 x 4 matrix: R = Rz(yaw) Ry(pitch) Rx(roll)."""
        (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in np.radians(self.rpy_deg))
        X = np.eye(4)
        X[:3, :3] = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
        X[:3, 3] = self.xyz
        return X


_UNITS = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
_LENGTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z]+)\s*")


def metres(value: Any) -> Any:
    """``3 mm`` as 0.003; numbers are metres already."""
    if not isinstance(value, str):
        return value
    match = _LENGTH.fullmatch(value)
    if match is None or match[2] not in _UNITS:
        units = ", ".join(_UNITS)
        raise ValueError(f"{value!r} is no length | a number of metres, or one with its unit: 3 mm ({units})")
    return float(f"{float(match[1]) * _UNITS[match[2]]:.15g}")


def _bounds(**limits: float) -> Any:
    number = {"type": "number", **{{"gt": "exclusiveMinimum", "ge": "minimum"}[k]: v for k, v in limits.items()}}
    return WithJsonSchema({"anyOf": [number, {"type": "string", "pattern": r"^.*\d\s*(um|mm|cm|m|in)$"}]})


#: Metres, or text with a unit.
Length = Annotated[float, Field(strict=True, allow_inf_nan=False), BeforeValidator(metres), _bounds()]
PositiveLength = Annotated[
    float, Field(strict=True, allow_inf_nan=False, gt=0.0), BeforeValidator(metres), _bounds(gt=0.0)
]
NotNegativeLength = Annotated[
    float, Field(strict=True, allow_inf_nan=False, ge=0.0), BeforeValidator(metres), _bounds(ge=0.0)
]


def _place(value: Any) -> Any:
    return tuple(metres(x) for x in value) if isinstance(value, (list, tuple)) else value


#: Three numbers [m] in the fixture's frame, or the name of a place of the scene.
Place = Annotated[Vector | str, BeforeValidator(_place)]
