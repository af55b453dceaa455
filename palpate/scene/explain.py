"""Converts pydantic's errors to scene errors with file and line, the nearest valid key and the expected unit."""

from __future__ import annotations

import difflib
import types
import typing
from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import BaseModel, ValidationError

from palpate.errors import SceneError, format_place
from palpate.scene.descriptions import descriptions
from palpate.scene.text import Place


def scene_error(error: ValidationError, model: type[BaseModel], name: str, lines: dict[Place, int]) -> SceneError:
    """One SceneError whose message lists all errors of the file; its attributes describe the first."""
    found = error.errors(include_url=False)
    # pydantic also reports a list with invalid items as too short: keep only the items' errors.
    deeper = {tuple(e["loc"])[:1] for e in found if len(e["loc"]) > 1}
    found = [e for e in found if not (e["type"] == "too_short" and len(e["loc"]) == 1 and tuple(e["loc"]) in deeper)]
    errors = [
        _to_scene_error(e, model, name, lines) for e in sorted(found, key=lambda e: _line(lines, tuple(e["loc"])))
    ]
    unique = list({str(e): e for e in errors}.values())
    first = unique[0]
    first.add_others(unique[1:])
    return first


def where(name: str, lines: dict[Place, int], place: Place) -> str:
    """``file:line`` of a place, or of the nearest enclosing place that the file contains."""
    line = _line(lines, place)
    return f"{name}:{line}" if line else name


def _line(lines: dict[Place, int], place: Place) -> int:
    return next((lines[place[:end]] for end in range(len(place), 0, -1) if place[:end] in lines), 0)


def _to_scene_error(e: Any, model: type[BaseModel], name: str, lines: dict[Place, int]) -> SceneError:
    place: Place = tuple(e["loc"])
    at = where(name, lines, place)
    spelled = format_place(place)
    if e["type"] == "extra_forbidden":
        return SceneError(f"unknown key {spelled!r}", where=at, mend=_nearest(place, model))
    if e["type"] == "value_error":
        what, _, mend = str(e["ctx"]["error"]).partition(" | ")
        return SceneError(f"{spelled}: {what}" if spelled else what, where=at, mend=mend)
    why = _purpose(place, model)
    if e["type"] == "missing" and isinstance(place[-1], str):
        return SceneError(f"{spelled!r} is missing", where=at, why=why, mend="add it")
    expected = e["msg"].replace("Input should be", "must be")
    if e["type"] in ("model_type", "dict_type"):
        expected = f"must be a section with keys such as {', '.join(_keys(_model_at(model, place)))}"
    elif e["type"] == "missing":
        expected = "is missing in a list of numbers"
    elif e["type"] in ("tuple_type", "list_type"):
        expected = "must be a list"
    elif e["type"] in ("too_short", "too_long"):
        limit = e["ctx"].get("min_length") or e["ctx"].get("max_length")
        count = f"{limit} {'entry' if limit == 1 else 'entries'}"
        expected = f"must have {'at least' if e['type'] == 'too_short' else 'at most'} {count}"
    return SceneError(f"{spelled} {expected}. Got: {_show(e['input'])}", where=at, mend=why and f"expected: {why}")


def _show(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _nearest(place: Place, model: type[BaseModel]) -> str:
    key = str(place[-1])
    here = _keys(_model_at(model, place[:-1]))
    near = difflib.get_close_matches(key, here, n=1, cutoff=0.6)
    if near:
        return f"did you mean {near[0]!r}?"
    outermost_last = sorted(_all_keys(model), key=lambda spelled: -spelled.count("."))
    everywhere = {spelled.rsplit(".", 1)[-1]: spelled for spelled in outermost_last}
    far = difflib.get_close_matches(key, list(everywhere), n=1, cutoff=0.75)
    if far:
        return f"did you mean {everywhere[far[0]]!r}?"
    return f"valid keys here: {', '.join(here)}" if here else "remove it"


def _purpose(place: Place, model: type[BaseModel]) -> str:
    """Description of the field at a place, or of the field that contains the list entry."""
    while place and not isinstance(place[-1], str):
        place = place[:-1]
    if not place:
        return ""
    parent = _model_at(model, place[:-1])
    info = parent.model_fields.get(str(place[-1])) if parent else None
    return descriptions(parent).get(str(place[-1]), "") if parent and info else ""


def _keys(model: type[BaseModel] | None) -> list[str]:
    return list(model.model_fields) if model else []


def _all_keys(model: type[BaseModel], prefix: str = "", above: tuple[type[BaseModel], ...] = ()) -> Iterator[str]:
    for key, info in model.model_fields.items():
        inner = _model_in(info.annotation)
        yield prefix + key
        if inner and inner not in above:  # a section may contain sections of its own type
            yield from _all_keys(inner, f"{prefix}{key}.", (*above, model))


def _model_at(model: type[BaseModel], place: Place) -> type[BaseModel] | None:
    current: type[BaseModel] | None = model
    for part in place:
        if isinstance(part, int) or current is None:
            continue
        info = current.model_fields.get(part)
        current = _model_in(info.annotation) if info else None
    return current


def _model_in(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    if typing.get_origin(annotation) in (Annotated, typing.Union, types.UnionType, list, tuple):
        for inner in typing.get_args(annotation):
            found = _model_in(inner)
            if found:
                return found
    return None
