"""Soft tissue: bodies to touch, materials, meshes of tetrahedra, and closed forms of indentation and viscosity."""

from __future__ import annotations

from typing import TYPE_CHECKING

from palpate.base import lazy

if TYPE_CHECKING:
    from palpate.world.tissue.body import Tissue
    from palpate.world.tissue.bounds import PERIOD
    from palpate.world.tissue.element_quality import Quality, edge_lengths, quality, shapes, stable_steps
    from palpate.world.tissue.files import load, save
    from palpate.world.tissue.make import tetrahedralize
    from palpate.world.tissue.material import TissueMaterial
    from palpate.world.tissue.presets import MEASUREMENTS, PRESETS
    from palpate.world.tissue.tetrahedra import TetMesh

__all__ = [
    "MEASUREMENTS",
    "PERIOD",
    "PRESETS",
    "Quality",
    "TetMesh",
    "Tissue",
    "TissueMaterial",
    "edge_lengths",
    "load",
    "quality",
    "save",
    "shapes",
    "stable_steps",
    "tetrahedralize",
]

_HOMES = {
    "PERIOD": "bounds",
    "Tissue": "body",
    "load": "files",
    "save": "files",
    "tetrahedralize": "make",
    "TissueMaterial": "material",
    "MEASUREMENTS": "presets",
    "PRESETS": "presets",
    "Quality": "element_quality",
    "edge_lengths": "element_quality",
    "quality": "element_quality",
    "shapes": "element_quality",
    "stable_steps": "element_quality",
    "TetMesh": "tetrahedra",
}

__getattr__ = lazy.names(__name__, _HOMES)
