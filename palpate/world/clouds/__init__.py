"""Point clouds: points in space with optional normals and colours, and the files that hold them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.base import lazy

if TYPE_CHECKING:
    from palpate.world.clouds.cloud import MAX_POINTS, PointCloud

__all__ = ["MAX_POINTS", "PointCloud"]

_HOMES = {
    "MAX_POINTS": "cloud",
    "PointCloud": "cloud",
}

__getattr__ = lazy.names(__name__, _HOMES)
