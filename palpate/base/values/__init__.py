"""Types of the values in scene files. Values are in SI units; a key in another unit names it (``rpy_deg``)."""

from __future__ import annotations

import math
from typing import Annotated, Any, Self

import numpy as np
import numpy.typing as npt
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, WithJsonSchema, model_validator

from palpate.base.errors import InvalidSceneError
from palpate.base.values import units

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0.0)]
NotNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0.0)]
Vector = tuple[Number, Number, Number]


def _repeat_number(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        return value
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"must be a number, or a list of three. Got: {value!r:.60} | write e.g. 500")
    if not 0.0 <= value < math.inf:
        raise ValueError(f"must be 0 or more, and finite. Got: {value!r:.60} | write e.g. 500")
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


def _rgb(value: Any) -> Any:
    if not isinstance(value, str):
        return value
    digits = value.removeprefix("#")
    if len(digits) != 6 or any(digit not in "0123456789abcdefABCDEF" for digit in digits):
        raise ValueError(f'must be three numbers, or "#rrggbb". Got: {value!r:.60} | write e.g. [140, 40, 32]')
    return tuple(int(digits[k : k + 2], 16) for k in (0, 2, 4))


_Byte = Annotated[int, Field(strict=True, ge=0, le=255)]

#: A colour: red, green, blue from 0 to 255; ``"#rrggbb"`` is converted.
Color = Annotated[
    tuple[_Byte, _Byte, _Byte],
    BeforeValidator(_rgb),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "string", "pattern": "^#[0-9a-fA-F]{6}$"},
                {
                    "type": "array",
                    "items": {"type": "integer", "minimum": 0, "maximum": 255},
                    "minItems": 3,
                    "maxItems": 3,
                },
            ]
        }
    ),
]


class Section(BaseModel):
    """A section of a scene file. It is immutable, and an unknown key is an error.

    The string below a field describes the field. `palpate.base.values.descriptions` reads these strings on demand,
    because pydantic would read them at every import. The unit in brackets at the end of a description is the unit of
    the field: text with another unit of the same dimension is converted to it, so that ``radius: 2 mm`` gives 0.002 m.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    def __init__(self, /, **values: Any) -> None:
        """A section from the values of its keys.

        Raises:
            InvalidSceneError: a value is invalid; the message names every one, why, and the correction.
        """
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise _explained(error, type(self)) from None

    setattr(__init__, "__pydantic_base_init__", True)  # noqa: B010 - pydantic then validates values without calling it

    @classmethod
    def model_validate(cls, obj: Any, **options: Any) -> Self:
        """A section from its values in a scene file, such as a dictionary; raises as the constructor."""
        try:
            return super().model_validate(obj, **options)
        except ValidationError as error:
            raise _explained(error, cls) from None

    @classmethod
    def validated(cls, values: Any, context: dict[str, Any] | None = None) -> Self:
        """As `model_validate`, with pydantic's own error: for readers of files, which know the lines."""
        return super().model_validate(values, context=context)

    @model_validator(mode="before")
    @classmethod
    def _convert_units(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        return {key: _converted(cls, key, value) if _has_quantity(value) else value for key, value in data.items()}


def _explained(error: ValidationError, section: type[Section]) -> InvalidSceneError:
    from palpate.base.values.wording import explain

    return explain.invalid(error, section)


def _has_quantity(value: Any) -> bool:
    """Whether a text in the value is a number with letters; only then the source is read for the field's unit."""
    if isinstance(value, (list, tuple)):
        return any(map(_has_quantity, value))
    if isinstance(value, dict):
        return any(map(_has_quantity, value.values()))
    return isinstance(value, str) and units.has_unit(value)


def _converted(section: type[Section], key: Any, value: Any) -> Any:
    """The value with its texts converted to the field's unit; texts that cannot be converted stay."""
    from palpate.base.values.descriptions import unit_of

    unit = unit_of(section, key)
    return _in_unit(value, unit) if unit else value


def _in_unit(value: Any, unit: str) -> Any:
    if isinstance(value, (list, tuple)):
        return [_in_unit(item, unit) for item in value]
    if isinstance(value, dict):
        return {key: _in_unit(item, unit) for key, item in value.items()}
    number = units.convert(value, unit) if isinstance(value, str) else None
    return value if number is None else number


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


#: A position (3,) in the fixture's frame [m], or the name of a place of the scene.
Place = Vector | str
