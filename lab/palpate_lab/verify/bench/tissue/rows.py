"""One judged figure: its value, the limit, and whether the limit holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypedDict


class Row(TypedDict):
    """A figure with its limit."""

    name: str
    value: float  #: in `unit`
    unit: str
    asked: float  #: limit, in the same unit
    least: bool  #: True if the value must reach the limit, False if it must not exceed the limit
    met: bool


@dataclass(frozen=True)
class Found:
    """What a figure's measurement returns."""

    rows: tuple[Row, ...] = ()
    details: Mapping[str, Any] = field(default_factory=dict)  #: keys of ``--json``


def at_most(name: str, value: float, limit: float, unit: str = "%") -> Row:
    """A row whose value must not exceed the limit; NaN does not meet it."""
    return _row(name, value, limit, unit, least=False)


def at_least(name: str, value: float, limit: float, unit: str = "%") -> Row:
    """A row whose value must reach the limit."""
    return _row(name, value, limit, unit, least=True)


def _row(name: str, value: float, limit: float, unit: str, *, least: bool) -> Row:
    met = bool(value >= limit if least else value <= limit)
    return {"name": name, "value": float(value), "unit": unit, "asked": limit, "least": least, "met": met}
