"""Keys of a scene file by their place: the field that a place names, its description and unit, and similar keys."""

from __future__ import annotations

import difflib
import types
import typing
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from palpate.base.errors import Place
from palpate.base.values.descriptions import descriptions, unit_of


@dataclass(frozen=True)
class Field:
    """The field at a place of a scene file; empty if there is none."""

    key: str = ""
    description: str = ""  # on one line
    unit: str = ""
    info: FieldInfo | None = None
    keys: tuple[str, ...] = ()  # of the section that the field contains


def place_in_file(loc: Place, model: type[BaseModel], keep_last: bool) -> tuple[Place, int]:
    """The place in the file of a location in pydantic's error, which also names alternatives of unions.

    Args:
        loc: pydantic's location.
        model: the section at the top.
        keep_last: the last part is an unknown key of the file.

    Returns:
        The place, and its length up to the first alternative of a union (its whole length without a union).
    """
    place: list[str | int] = []
    kind: Any = model
    union = -1
    for i, part in enumerate(loc):
        inner = _step(kind, part)
        if inner is None and not (keep_last and i + 1 == len(loc)) and (place or part == "[key]"):
            union = len(place) if union < 0 else union
            continue
        place.append(part)
        kind = inner
    return tuple(place), len(place) if union < 0 else union


def field_at(place: Place, model: type[BaseModel]) -> Field:
    """The field at a place, or the field that contains the list entry."""
    while place and not isinstance(place[-1], str):
        place = place[:-1]
    while place:
        section, key = _model_at(model, place[:-1]), str(place[-1])
        if section is not None and key in section.model_fields:
            text = " ".join(descriptions(section).get(key, "").split())
            info = section.model_fields[key]
            inner = _model_in(info.annotation)
            return Field(key, text, unit_of(section, key), info, tuple(inner.model_fields) if inner else ())
        place = place[:-1]  # an entry of a mapping: the field that contains the mapping
    return Field()


def nearest(place: Place, model: type[BaseModel]) -> str:
    """Advice for an unknown key: a similar key of the section, or of another section, or all keys of the section."""
    key = str(place[-1])
    section = _model_at(model, place[:-1])
    here = list(section.model_fields) if section else []
    lines = _lines_of(section) if section else {}
    near = difflib.get_close_matches(key, [*here, *lines], n=1, cutoff=0.6)
    outermost_last = sorted(_all_keys(model), key=lambda found: -found[1].count("."))
    everywhere = dict(outermost_last)
    far = difflib.get_close_matches(key, list(everywhere), n=1, cutoff=0.75)
    if near and not (far and _likeness(key, far[0]) > _likeness(key, near[0]) + _CLEARLY):
        return f"did you mean {lines.get(near[0], near[0])!r}?"
    if far:
        return f"did you mean {everywhere[far[0]]!r}?"
    return f"remove it; valid keys here: {', '.join(here)}" if here else "remove it"


_CLEARLY = 0.2
"""By how much more alike a key of another section must be than the best key of the same section [-]."""


def _likeness(a: str, b: str) -> float:
    return difflib.SequenceMatcher(None, a, b).ratio()


def _lines_of(model: type[BaseModel]) -> dict[str, str]:
    """First words of the lines by which a section can be written, each with an example."""
    found: dict[str, str] = getattr(model, "ONE_LINE", {})
    return found


def _step(kind: Any, part: str | int) -> Any:
    """Type of an entry or field inside a type; None if the type has no such part."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        info = kind.model_fields.get(str(part))
        return info.annotation if info else None
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin is Annotated:
        return _step(args[0], part)
    if origin in (typing.Union, types.UnionType):
        return next((found for inner in args if (found := _step(inner, part)) is not None), None)
    if origin in (tuple, list) and isinstance(part, int):
        return args[min(part, len(args) - 1)] if args[-1] is not Ellipsis else args[0]
    return args[1] if origin is dict and part != "[key]" else None


def _all_keys(
    model: type[BaseModel], prefix: str = "", above: tuple[type[BaseModel], ...] = ()
) -> Iterator[tuple[str, str]]:
    """Keys, each with its place in the file."""
    for key, info in model.model_fields.items():
        inner = _model_in(info.annotation)
        yield key, prefix + key
        for word, example in (_lines_of(inner) if inner else {}).items():
            yield word, f"{prefix}{key}: [{example}]"
        if inner and inner not in above:  # a section may contain sections of its own type
            yield from _all_keys(inner, f"{prefix}{key}.", (*above, model))


def _model_at(model: type[BaseModel], place: Place) -> type[BaseModel] | None:
    kind: Any = model
    for part in place:
        kind = _step(kind, part)
    return _model_in(kind)


def _model_in(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    if typing.get_origin(annotation) in (Annotated, typing.Union, types.UnionType, list, tuple):
        for inner in typing.get_args(annotation):
            found = _model_in(inner)
            if found:
                return found
    return None
