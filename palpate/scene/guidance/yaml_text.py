"""Conversion between YAML text and the items of a scene's list ``guidance``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

import yaml
from pydantic import TypeAdapter, ValidationError

from palpate.base.arrays.yaml_loader import load
from palpate.base.errors import GuidanceError
from palpate.base.values import Section
from palpate.base.values.wording import describe, place_in_file
from palpate.scene.guidance import one_line

_Item = TypeVar("_Item", bound=Section)


def to_yaml(fixtures: Iterable[Section]) -> str:
    """YAML text of a scene's list ``guidance``, with the values that differ from the defaults."""
    data = [f.model_dump(mode="json", exclude_defaults=True) for f in fixtures]
    return str(yaml.safe_dump(data, sort_keys=False, allow_unicode=True, default_flow_style=None, width=110))


def from_yaml(text: str, kind: type[_Item]) -> tuple[_Item, ...]:
    """Items of one kind from a YAML list; each item is a section or one line of text.

    Raises:
        GuidanceError: the text is invalid; the message names the first error.
    """
    try:
        data = load(one_line.readable(text))
        items = one_line.expand_list(data if isinstance(data, list) else [data])
        return TypeAdapter(tuple[kind, ...]).validate_python(items)  # type: ignore[valid-type]
    except yaml.YAMLError as error:
        raise GuidanceError("not valid YAML", why=" ".join(str(error).split()), mend="a list of fixtures") from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place, _ = place_in_file(tuple(first["loc"][1:]), kind, keep_last=first["type"] == "extra_forbidden")
        what, why, mend = describe(first, place, kind, above=tuple(first["loc"][:1]))
        raise GuidanceError(what, why=why, mend=mend) from None
