"""The message for one of pydantic's errors: what is wrong, why, and how to correct it."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

from palpate.base.errors import Place, format_place
from palpate.base.values.wording import keys, values


def describe(error: Any, place: Place, model: type[BaseModel], above: Place = ()) -> tuple[str, str, str]:
    """What is wrong, why, and the correction, in words of the file.

    Args:
        error: one of pydantic's errors, as its dictionary.
        place: keys and indices of the value in `model` (`place_in_file`).
        model: the section at the top.
        above: keys and indices from the top of the file to `model`.
    """
    too_few = error["type"] == "missing" and bool(place) and isinstance(place[-1], int)  # numbers of a list
    place = place[:-1] if too_few else place
    spelled = format_place((*above, *place))
    if error["type"] == "extra_forbidden":
        return f"unknown key {spelled!r}", "", keys.nearest(place, model)
    if error["type"] == "value_error":
        what, _, mend = str(error["ctx"]["error"]).partition(" | ")
        return f"{spelled}: {what}" if spelled else what, "", mend
    field = keys.field_at(place, model)
    if error["type"] == "missing" and not too_few and place:
        return f"{spelled!r} is missing", field.description, f"add {place[-1]}: {values.example(field)}"
    expected, mend = values.words(error, field)
    why = f"{field.key}: {field.description}" if field.description else ""
    return f"{spelled} {expected}".lstrip() + f". Got: {values.shown(error['input'])}", why, mend
