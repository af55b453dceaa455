"""Descriptions of the fields of scene sections, read from the strings below the fields in the source."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from functools import cache
from itertools import pairwise
from pathlib import Path

from pydantic import BaseModel

from palpate.base.values import units

_UNIT = re.compile(r"\[([^\]]+)\]$")


@cache
def unit_of(model: type[BaseModel], key: str) -> str:
    """Unit at the end of a field's description, e.g. ``N/m``; empty for text, numbers without a unit, and no field."""
    match = _UNIT.search(descriptions(model).get(key, ""))
    return match[1] if match and units.is_known(match[1]) else ""


@cache
def descriptions(model: type[BaseModel]) -> dict[str, str]:
    """Strings below the fields of a model and its bases, by field name; empty if the source is not available."""
    found: dict[str, str] = {}
    for cls in reversed(model.__mro__):
        if issubclass(cls, BaseModel) and cls is not BaseModel:
            found |= _below_fields(cls)
    return {name: text for name, text in found.items() if name in model.model_fields}


@cache
def _classes(file: str) -> dict[str, ast.ClassDef]:
    """Classes at the top of a source file, by name; one parse is much faster than inspect.getsource of each class."""
    tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    return {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}


def _below_fields(cls: type[BaseModel]) -> dict[str, str]:
    try:
        found = _classes(inspect.getfile(cls)).get(cls.__qualname__)
        node = found or ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0]
    except (OSError, TypeError):
        return {}
    body = node.body if isinstance(node, ast.ClassDef) else []
    return {
        field.target.id: inspect.cleandoc(text.value.value)
        for field, text in pairwise(body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(field.target, ast.Name)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
        and isinstance(text.value.value, str)
    }
