"""What other installed distributions add to Palpate, by entry points (docs/extending.md).

Only installed code is found here: a scene, which is data that people exchange, cannot bring any along.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.machinery import PathFinder
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from palpate.base.errors import PalpateError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint, EntryPoints

Group = Literal["palpate.commands", "palpate.studies", "palpate.methods", "palpate.shapes", "palpate.exporters"]


def names(group: Group) -> list[str]:
    """Names that other distributions add to a group, sorted."""
    return sorted({point.name for point in _entry_points(group)})


def _entry_points(group: Group, name: str | None = None) -> EntryPoints:
    from importlib.metadata import entry_points  # takes 20 ms, and few commands need it

    return entry_points(group=group) if name is None else entry_points(group=group, name=name)


def files(group: Group) -> dict[str, tuple[str, Path]]:
    """Module and Python file of each entry point of a group, by name, without an import.

    What is not found, or added by two distributions, is left out: `load` tells why.
    """
    found: dict[str, tuple[str, Path]] = {}
    for name in names(group):
        points = _points(group, name)
        file = source(points[0].module)
        if len(points) == 1 and file is not None and file.suffix == ".py":
            found[name] = points[0].module, file
    return found


def _points(group: Group, name: str) -> list[EntryPoint]:
    return list({one.value: one for one in _entry_points(group, name)}.values())


def load(group: Group, name: str) -> Any | None:
    """The object that an entry point names, imported, or None if there is no entry point of this name.

    Raises:
        PalpateError: its code cannot be imported, or two distributions add the same name.
    """
    found = _points(group, name)
    if not found:
        return None
    if len(found) > 1:
        owners = " and ".join(_owner(one) for one in found)
        raise PalpateError(f"{name!r} is added by {owners}", where=group, mend="uninstall one of them")
    (one,) = found
    try:
        return one.load()
    except Exception as error:  # code of others
        raise PalpateError(
            f"{name!r} of {_owner(one)} cannot be loaded",
            where=f"{group}: {one.value}",
            why=f"{type(error).__name__}: {error}",
            mend=f"install {_owner(one)} again, or uninstall it",
        ) from error


def source(module: str, folders: Sequence[str | Path] | None = None) -> Path | None:
    """File of a module, found without an import of it or of its packages; None if there is none.

    Args:
        module: its name, with dots.
        folders: where its first package is searched; default: where an import looks.
    """
    where: list[str] | None = [str(folder) for folder in (sys.path if folders is None else folders)]
    spec, full = None, ""
    for part in module.split("."):
        full = f"{full}.{part}".strip(".")
        spec = None if where is None else PathFinder.find_spec(full, where)
        if spec is None:
            return None
        where = None if spec.submodule_search_locations is None else list(spec.submodule_search_locations)
    return None if spec is None or spec.origin is None else Path(spec.origin)


def _owner(one: EntryPoint) -> str:
    return one.dist.name if one.dist is not None else one.value
