"""Shapes made by generators of our own: nothing to download, the same on every machine."""

from palpate.shapes.organ import gallbladder, organ

__all__ = ["gallbladder", "organ"]
