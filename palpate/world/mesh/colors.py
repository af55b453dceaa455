"""Colours of a mesh file: of its vertices, its faces, its material, or its texture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.world.mesh.headers import load_by_trimesh

FORMATS = (".obj", ".ply", ".off", ".glb", ".gltf", ".3mf", ".dae")
"""Formats that can hold colours."""


def colors_of(path: Path, vertices: Array) -> Array | None:
    """Colours for vertices of a mesh file, from the file's nearest vertex: a texture is sampled at the vertices.

    Args:
        path: the file.
        vertices: (n, 3) in the unit of the file; welded, repaired or coarser ones than in the file are welcome.

    Returns:
        (n, 3) red, green, blue from 0 to 255. None if the file holds no colours, or cannot be read.
    """
    if path.suffix.lower() not in FORMATS:
        return None
    from scipy.spatial import cKDTree

    try:
        loaded = load_by_trimesh(path)
        colors = _vertex_colors(loaded)
        points = np.asarray(getattr(loaded, "vertices", ()), dtype=np.float64)
    except (
        Exception,
        RecursionError,
    ):  # trimesh raises many types of exception; the mesh itself was read, so only colours are missing
        return None
    if colors is None or len(colors) != len(points) or not np.isfinite(points).all():
        return None
    _, nearest = cKDTree(points).query(vertices)
    return np.asarray(colors[nearest], dtype=np.float64)


def _vertex_colors(mesh: object) -> NDArray[np.uint8] | None:
    """(n, 3) colours of a mesh of trimesh; None if it has trimesh's default colour."""
    visual = getattr(mesh, "visual", None)
    if visual is None or not visual.defined:
        return None
    if visual.kind == "texture":
        material = visual.material
        has_image = any(getattr(material, name, None) is not None for name in ("image", "baseColorTexture"))
        names = ("baseColorFactor", "diffuse") if not has_image else ()
        if not has_image and all(getattr(material, name, None) is None for name in names):
            return None
        visual = visual.to_color()
    return np.asarray(visual.vertex_colors, dtype=np.uint8)[:, :3]
