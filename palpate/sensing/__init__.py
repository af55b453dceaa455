"""Live sensing: point clouds that become surfaces beside the loop, and trackers of poses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.base import lazy

if TYPE_CHECKING:
    from palpate.sensing.source import CloudFrame, CloudSource

__all__ = ["CloudFrame", "CloudSource"]

_HOMES = {
    "CloudFrame": "source",
    "CloudSource": "source",
}

__getattr__ = lazy.names(__name__, _HOMES)
