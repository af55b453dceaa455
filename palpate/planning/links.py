"""The geometry of an arm's links as its URDF gives it: primitives and meshes, with the places of mesh files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm, urdf
from palpate.base.arrays import Array
from palpate.base.errors import ArmError, MeshError, PlanningError
from palpate.world.mesh import files


@dataclass(frozen=True)
class Part:
    """One primitive or mesh of a link."""

    link: str
    shape: str  # a key of urdf.SIZES, or "mesh"
    size: tuple[float, ...]  # numbers of urdf.SIZES [m]; a mesh: its scale along x, y, z [-]
    X_link_part: Array  # (4, 4)
    file: Path | None = None  # of a mesh
    vertices: Array | None = None  # (v, 3) of a mesh with its scale, in the frame of the part [m]
    triangles: NDArray[Any] | None = None  # (t, 3) of a mesh


def parts(arm: Arm) -> dict[str, list[Part]]:
    """Collision geometry of the links, where the URDF gives it: <collision>, else the <visual> of links with meshes.

    Links that have only <visual> primitives are left out: capsules contain these (`palpate.planning.robot`).

    Raises:
        PlanningError: a shape is unknown or without size, or a mesh file is not found or not readable.
    """
    found: dict[str, list[Part]] = {}
    for link in ElementTree.fromstring(arm.urdf).findall("link") if arm.urdf else []:
        name = link.get("name", "")
        elements = link.findall("collision")
        if not elements and link.find("visual/geometry/mesh") is not None:
            elements = link.findall("visual")
        try:
            made = [_part(element, name, arm.folder) for element in elements]
        except ArmError as error:
            why = "; ".join(filter(None, (error.why, "motions cannot be checked without it")))
            raise PlanningError(error.what, why=why, mend=error.mend) from None
        if any(made):
            found[name] = [part for part in made if part is not None]
    return found


def bare(arm: Arm) -> bool:
    """True if the URDF gives no link any geometry."""
    shapes = ElementTree.fromstring(arm.urdf).findall("link/collision/geometry/*") if arm.urdf else []
    return not shapes and not ElementTree.fromstring(arm.urdf).findall("link/visual/geometry/*")


def massive(arm: Arm) -> set[str]:
    """Links with a mass above zero."""
    masses = {
        link.get("name", ""): link.find("inertial/mass") for link in ElementTree.fromstring(arm.urdf).iter("link")
    }
    return {name for name, mass in masses.items() if mass is not None and float(mass.get("value", "0")) > 0.0}


def _part(element: ElementTree.Element, link: str, folder: Path | None) -> Part | None:
    """A <collision> or <visual> element; None if it has no geometry."""
    shape = next(iter(element.findall("geometry/*")), None)
    if shape is None:
        return None
    owner = f"link {link}"
    X = urdf.origin(element, owner)
    if shape.tag == "mesh":
        scale = urdf.numbers(shape, "scale", 3, owner, "1 1 1")
        if (scale == 0.0).any():
            raise PlanningError(f"the mesh of link {link} has the scale {shape.get('scale')}", mend="scale it by 1 1 1")
        file = urdf.file_of(shape.get("filename", ""), owner, folder)
        vertices, triangles = _read(file, link)
        return Part(link, "mesh", tuple(scale.tolist()), X, file, vertices * scale, triangles)
    if shape.tag not in urdf.SIZES:
        raise PlanningError(
            f"link {link} has the geometry <{shape.tag}>, which is not understood",
            why="motions cannot be checked without it", mend=f"use <mesh>, <{'>, <'.join(urdf.SIZES)}>",
        )  # fmt: skip
    size = urdf.size(shape, owner)
    return Part(link, shape.tag, tuple(size.tolist()), X)


def _read(file: Path, link: str) -> tuple[Array, NDArray[Any]]:
    """Vertices (v, 3) and triangles (t, 3) of a mesh file, in metres where the file names its unit (COLLADA, glTF)."""
    import trimesh

    try:
        vertices, triangles, _ = files.read_with_unit(file)
    except MeshError as error:
        raise PlanningError(
            f"the mesh of link {link} cannot be read: {error.what}", where=error.where or str(file), why=error.why,
            mend=error.mend,
        ) from None  # fmt: skip
    whole = trimesh.Trimesh(vertices, triangles)  # joins the corners of triangle soups
    return np.asarray(whole.vertices, dtype=np.float64), np.asarray(whole.faces)
