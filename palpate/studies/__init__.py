"""Studies: `palpate study NAME`. One file each, with its command as the dataclass ``Study``; simulated, and said so."""

from __future__ import annotations

from importlib import import_module

#: A study is a file here and its name in this list.
NAMES: tuple[str, ...] = (
    "certificate",
    "contact",
    "drift",
    "figure12",
    "force",
    "geometry",
    "guidance",
    "laws",
    "passivity",
    "radius",
    "wall",
    "zwidth",
)


def commands() -> dict[str, type]:
    """Name to command; a study's heavy imports are its own, made when it runs."""
    return {name: import_module(f"palpate.studies.{name}").Study for name in NAMES}
