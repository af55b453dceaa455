"""Shapes made by generators of our own: nothing to download, the same on every machine."""
