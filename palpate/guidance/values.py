"""Values of fixtures: lengths with or without a unit, places by numbers or by name."""

from __future__ import annotations

import re
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, WithJsonSchema

from palpate.scene.values import Vector

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
