"""Generated shapes: nothing is downloaded, and every machine generates the same arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.base import lazy

if TYPE_CHECKING:
    from palpate.world.shapes.bowel import duodenum
    from palpate.world.shapes.organs import gallbladder, organ

__all__ = ["duodenum", "gallbladder", "organ"]

_HOMES = {
    "duodenum": "bowel",
    "gallbladder": "organs",
    "organ": "organs",
}

__getattr__ = lazy.names(__name__, _HOMES)
