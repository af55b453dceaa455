"""Soft tissue: bodies to touch, materials, meshes of tetrahedra, and closed forms of indentation and viscosity."""

from palpate.tissue.body import PERIOD, Tissue
from palpate.tissue.files import load, save
from palpate.tissue.make import tetrahedralize
from palpate.tissue.material import TissueMaterial
from palpate.tissue.presets import MEASUREMENTS, PRESETS
from palpate.tissue.quality import Quality, edge_lengths, quality, shapes, stable_steps
from palpate.tissue.tetrahedra import TetMesh

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
