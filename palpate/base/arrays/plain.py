"""Plain values: the types that a JSON or YAML file can hold, and the conversion of results to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeAlias

import numpy as np

from palpate.base.arrays.checks import finite_or_none

Content: TypeAlias = dict[str, Any]
"""Content of a YAML or JSON file by key, before it is validated or after it was converted for writing."""


def plain(value: object) -> Any:
    """A value in JSON types: numbers, texts, booleans, None, and lists and dictionaries of these.

    A dataclass becomes the dictionary of its fields, in their order; an array becomes nested lists.

    Raises:
        TypeError: the value has another type; the message names the type.
    """
    if isinstance(value, np.generic):
        return plain(value.item())
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(v) for v in value]
    if isinstance(value, Mapping):
        return {str(k): plain(v) for k, v in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    kinds = "numbers, texts, lists, dictionaries and dataclasses"
    raise TypeError(f"a {type(value).__name__} is not a plain value: only {kinds} of these are")


def finite(value: Any) -> Any:
    """A plain value with None in place of infinity and NaN, as JSON requires."""
    if isinstance(value, dict):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, list):
        return [finite(one) for one in value]
    return finite_or_none(value) if isinstance(value, float) else value
