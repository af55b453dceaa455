"""The name of a contact method in a scene: one of ours, or one that an installed distribution adds."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Annotated, Any

from pydantic import AfterValidator, WithJsonSchema

from palpate import _core

COLLISIONS = ("paper-plane", "paper-alg1", "face-normal", "approach-velocity")
"""The paper's methods and those that it rejects; the part `collision` adds them."""
METHODS = ("proxy", "penalty", *COLLISIONS)
"""Our methods, the default first."""


def loaded(name: str) -> str:
    """The name, after the library of its method is loaded, which a process that unpickles a scene has not done yet.

    Raises:
        ValueError: there is no such method. PalpateError: its library is not installed or cannot be loaded.
    """
    if name in COLLISIONS:
        from palpate import _collision  # noqa: F401 - the import adds these methods
    if name in _core.contact_methods():
        return name
    from palpate.base import plugins

    if plugins.load("palpate.methods", name) is not None and name in _core.contact_methods():
        return name
    known = [*METHODS, *plugins.names("palpate.methods")]
    near = get_close_matches(name, known, n=1)
    mend = f"did you mean {near[0]!r}?" if near else f"write one of {', '.join(known)}"
    raise ValueError(f"there is no contact method {name!r}; {mend}")


def _known(name: str) -> str:
    try:
        return loaded(name)
    except ValueError as error:  # of a scene, an error tells its fix after a bar
        raise ValueError(str(error).replace("; ", " | ", 1)) from None


_SCHEMA: dict[str, Any] = {"anyOf": [{"enum": list(METHODS)}, {"type": "string", "description": "an installed one"}]}
ContactMethod = Annotated[str, AfterValidator(_known), WithJsonSchema(_SCHEMA)]
"""Other distributions add theirs as entry points of the group `palpate.methods`: a module that calls register_method()
of core/palpate/contact/registry.hpp."""
