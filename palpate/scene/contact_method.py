"""The name of a contact method in a scene: one of ours, or one that an installed distribution adds."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Annotated, Any

from pydantic import AfterValidator, WithJsonSchema

from palpate import _core
from palpate.base import plugins

_OURS = tuple(_core.contact_methods())


def loaded(name: str) -> str:
    """The name, after the library of its method is loaded, which a process that unpickles a scene has not done yet.

    Raises:
        ValueError: there is no such method. PalpateError: its library cannot be loaded.
    """
    if name in _core.contact_methods():
        return name
    if plugins.load("palpate.methods", name) is not None and name in _core.contact_methods():
        return name
    known = [*_OURS, *plugins.names("palpate.methods")]
    near = get_close_matches(name, known, n=1)
    mend = f"did you mean {near[0]!r}?" if near else f"write one of {', '.join(known)}"
    raise ValueError(f"there is no contact method {name!r} | {mend}")


_SCHEMA: dict[str, Any] = {"anyOf": [{"enum": list(_OURS)}, {"type": "string", "description": "an installed one"}]}
ContactMethod = Annotated[str, AfterValidator(loaded), WithJsonSchema(_SCHEMA)]
"""Other distributions add theirs as entry points of the group `palpate.methods`: a module that calls register_method()
of core/palpate/contact/registry.hpp."""
