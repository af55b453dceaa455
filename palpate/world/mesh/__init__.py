"""Triangle meshes: files, checks, repairs (`palpate.Mesh`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.base import lazy

if TYPE_CHECKING:
    from palpate.world.mesh.mesh import Mesh, Unit, quiet

__all__ = ["Mesh", "Unit", "quiet"]

_HOMES = {
    "Mesh": "mesh",
    "Unit": "mesh",
    "quiet": "mesh",
}

__getattr__ = lazy.names(__name__, _HOMES)
