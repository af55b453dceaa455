"""Soft tissue: bodies to touch, materials, meshes of tetrahedra, and closed forms of indentation and viscosity."""

from palpate.world.tissue.body import PERIOD, Tissue
from palpate.world.tissue.files import load, save
from palpate.world.tissue.make import tetrahedralize
from palpate.world.tissue.material import TissueMaterial
from palpate.world.tissue.presets import MEASUREMENTS, PRESETS
from palpate.world.tissue.quality import Quality, edge_lengths, quality, shapes, stable_steps
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
