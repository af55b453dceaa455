"""Words for an invalid value of a scene file: what it must be, and how to correct it."""

from __future__ import annotations

import difflib
from typing import Any

from palpate.base.values import units
from palpate.base.values.wording.keys import Field

_WHOLE = ("whole number", "int_type", "int_from_float", "int_parsing", "int_parsing_size")
_NUMBER = ("number", "float_type", "float_parsing")
_LIMITS = {
    "greater_than": ("greater than", "gt"),
    "greater_than_equal": ("at least", "ge"),
    "less_than": ("less than", "lt"),
    "less_than_equal": ("at most", "le"),
    "multiple_of": ("a multiple of", "multiple_of"),
}


def words(error: Any, field: Field) -> tuple[str, str]:
    """What the value must be, and the correction, for one of pydantic's errors."""
    kind, given, limits = error["type"], error["input"], error.get("ctx", {})
    if kind in _LIMITS:
        text, key = _LIMITS[kind]
        limit = f"{text} {limits[key]:g}"
        return f"must be {limit}", f"write a number {limit}{_or_unit(field)}"
    if kind == "literal_error":
        near = difflib.get_close_matches(
            str(given), limits["expected"].replace("'", "").replace(" or ", ", ").split(", ")
        )
        return f"must be {limits['expected']}", f"did you mean {near[0]!r}?" if near else "write one of these"
    if kind in ("too_short", "too_long"):
        return _count(kind, limits, given)
    for name, *kinds in (_NUMBER, _WHOLE):
        if kind in kinds:
            return f"must be a {name}", _number(name, given, field)
    return _other(kind, given, field)


def shown(value: Any) -> str:
    """The value in at most 60 characters."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def example(field: Field) -> str:
    """An example of a value: the default of the field if it has one."""
    default = field.info.default if field.info is not None else None
    if field.keys:
        return f"{{{field.keys[0]}: ...}}"
    if isinstance(default, (int, float)) and not isinstance(default, bool):
        return f"{default:g}"
    return "a value" + (f" [{field.unit}]" if field.unit else "")


def _number(name: str, given: Any, field: Field) -> str:
    if isinstance(given, str) and field.unit and units.has_unit(given):
        return f"write it in {field.unit}, or in another unit of the same kind: {units.examples(field.unit)}"
    if isinstance(given, (dict, list)):
        return f"write a single {name}{_or_unit(field)}"
    return f"write a {name}{_or_unit(field)}"


def _or_unit(field: Field) -> str:
    if not field.unit:
        return ""
    names = units.examples(field.unit)
    return f" [{field.unit}]" + (f", or one with its unit ({names})" if "," in names else "")


def _count(kind: str, limits: Any, given: Any) -> tuple[str, str]:
    limit = limits.get("min_length") or limits.get("max_length")
    count = f"{limit} {'entry' if limit == 1 else 'entries'}"
    if kind == "too_short":
        return f"must have at least {count}", "add an entry"
    extra = len(given) - limit if hasattr(given, "__len__") else 0
    return f"must have at most {count}", f"remove {extra if extra > 0 else 'some'}"


def _other(kind: str, given: Any, field: Field) -> tuple[str, str]:
    if kind in ("tuple_type", "list_type"):
        if isinstance(given, dict):
            return "must be a list", "add `- ` before its first key: each entry of a list begins with a dash"
        return "must be a list", "write [ ] around it" if given is not None else "write a list, or remove the key"
    if kind in ("model_type", "dict_type", "model_attributes_type"):
        such = f" with keys such as {', '.join(field.keys)}" if field.keys else " of names, each with its value"
        return f"must be a section{such}", f"write {field.key}: {example(field)}" if field.keys else "write NAME: value"
    if kind in ("bool_type", "bool_parsing"):
        return "must be true or false", "write true or false"
    if kind.startswith("string"):
        plain = isinstance(given, (int, float))
        return "must be text", f"put it in quotes: '{given}'" if plain else "write text, or remove the key"
    if kind == "missing":
        return "has too few numbers", "write one number for each axis, such as [0, 0, 0]"
    if kind == "finite_number":
        return "must be a finite number", f"write a number{_or_unit(field)}"
    if kind == "invalid_key":
        return "is a name that is not text", f"put it in quotes: '{given}'"
    return "is not a valid value", "correct it, or remove the key"
