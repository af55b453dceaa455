"""Soft tissue: materials, tetrahedral meshes, and closed forms of indentation and viscosity."""
