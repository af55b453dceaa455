"""What other installed distributions add to Palpate, by entry points (docs/extending.md).

Only installed code is found here: a scene, which is data that people exchange, cannot bring any along.
"""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points
from typing import Any, Literal

from palpate.errors import PalpateError

Group = Literal["palpate.commands", "palpate.studies", "palpate.methods", "palpate.shapes", "palpate.exporters"]


def names(group: Group) -> list[str]:
    """Names that other distributions add to a group, sorted."""
    return sorted({point.name for point in entry_points(group=group)})


def point(group: Group, name: str) -> EntryPoint | None:
    """The entry point of this name, or None. Its code is not imported.

    Raises:
        PalpateError: two distributions add the same name.
    """
    found = list({one.value: one for one in entry_points(group=group, name=name)}.values())
    if len(found) > 1:
        owners = " and ".join(_owner(one) for one in found)
        raise PalpateError(f"{name!r} is added by {owners}", where=group, mend="uninstall one of them")
    return found[0] if found else None


def load(group: Group, name: str) -> Any | None:
    """The object that an entry point names, imported, or None if there is no entry point of this name.

    Raises:
        PalpateError: its code cannot be imported, or two distributions add the same name.
    """
    one = point(group, name)
    if one is None:
        return None
    try:
        return one.load()
    except Exception as error:  # code of others
        raise PalpateError(
            f"{name!r} of {_owner(one)} cannot be loaded",
            where=f"{group}: {one.value}",
            why=f"{type(error).__name__}: {error}",
            mend=f"install {_owner(one)} again, or uninstall it",
        ) from error


def _owner(one: EntryPoint) -> str:
    return one.dist.name if one.dist is not None else one.value
