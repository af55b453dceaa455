"""Soft tissue: bodies to touch, materials, tetrahedral meshes, and closed forms of indentation and viscosity."""

from palpate.tissue.body import Tissue

__all__ = ["Tissue"]
