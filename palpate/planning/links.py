"""The geometry of an arm's links as its URDF gives it: primitives and meshes, with the places of mesh files."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm, models_folder
from palpate.arrays import Array
from palpate.errors import MeshError, PlanningError
from palpate.mesh import files
from palpate.planning.kinematics import pose_of

SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "capsule": ("radius", "length")}
"""Attributes of the primitives of a URDF [m]; cylinders and capsules lie along z."""


@dataclass(frozen=True)
class Part:
    """One primitive or mesh of a link."""

    link: str
    shape: str  # a key of SIZES, or "mesh"
    size: tuple[float, ...]  # numbers of SIZES [m]; a mesh: its scale along x, y, z [-]
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
        made = [_part(element, name, arm.folder) for element in elements]
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
    X = _origin(element, link)
    if shape.tag == "mesh":
        scale = _numbers(shape, "scale", link, 3, "1 1 1")
        if (scale == 0.0).any():
            raise PlanningError(f"the mesh of link {link} has the scale {shape.get('scale')}", mend="scale it by 1 1 1")
        file = mesh_file(shape.get("filename", ""), link, folder)
        vertices, triangles = _read(file, link)
        return Part(link, "mesh", tuple(scale.tolist()), X, file, vertices * scale, triangles)
    if shape.tag not in SIZES:
        raise PlanningError(
            f"link {link} has the geometry <{shape.tag}>, which is not understood",
            why="motions cannot be checked without it", mend=f"use <mesh>, <{'>, <'.join(SIZES)}>",
        )  # fmt: skip
    size = np.concatenate([_numbers(shape, key, link, 3 if key == "size" else 1) for key in SIZES[shape.tag]])
    if not (size > 0.0).all():
        what = f"the {shape.tag} of link {link} has the size {', '.join(f'{x:g}' for x in size)} m"
        raise PlanningError(what, mend="give sizes above zero in the URDF")
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


def mesh_file(name: str, link: str, folder: Path | None) -> Path:
    """The file that a URDF names: beside the URDF in `folder` or above, in a package, or among the models.

    The folder of package://NAME is searched for as a folder above the URDF that has this name or contains one, then in
    ROS_PACKAGE_PATH and AMENT_PREFIX_PATH; if none is found, the path within the package is looked for in the folders
    above the URDF, as an archive of a package may be unpacked under another name.

    Raises:
        PlanningError: it is not found; the message names the places.
    """
    places = _places(name, (folder or Path()).resolve())
    found = next((place for place in places if place.is_file()), None)
    if found is None:
        tried = ", ".join(str(place) for place in places[:3]) + (", ..." if len(places) > 3 else "")
        raise PlanningError(
            f"the mesh {name} of link {link} is not found",
            why=f"looked for {tried}; motions cannot be checked without it",
            mend="put it beside the URDF, give its full path there, or name the package's folder in ROS_PACKAGE_PATH",
        )  # fmt: skip
    return found


def _places(name: str, folder: Path) -> list[Path]:
    """Where a mesh file may lie, the most specific place first."""
    for scheme in ("package://", "model://"):
        if name.startswith(scheme):
            package, _, rest = unquote(name.removeprefix(scheme)).partition("/")
            above = [folder, *folder.parents]
            own = [place / rest for place in above if place.name == package]
            ros = [Path(one) for one in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if one]
            prefixes = [Path(one) / "share" for one in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if one]
            named = [place / package / rest for place in (*above, *ros, *prefixes)]
            itself = [place / rest for place in ros if place.name == package]
            return [*own, *named, *itself, *(place / rest for place in above), models_folder() / rest]
    plain = unquote(name.removeprefix("file://").removeprefix("localhost")) if name.startswith("file:") else name
    return [folder / plain, models_folder() / plain]  # an absolute path replaces the folder


def _origin(element: ElementTree.Element, link: str) -> Array:
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    return pose_of(_numbers(origin, "xyz", link, 3, "0 0 0"), _numbers(origin, "rpy", link, 3, "0 0 0"))


def _numbers(element: ElementTree.Element, key: str, link: str, count: int, default: str = "") -> Array:
    text = element.get(key, default)
    try:
        values = np.array([float(x) for x in text.split()])
    except ValueError:
        values = np.empty(0)
    if len(values) != count or not np.isfinite(values).all():
        what = f"<{element.tag} {key}={text!r}> of link {link} is not {count} number{'s' if count > 1 else ''}"
        raise PlanningError(what, mend="mend it in the URDF")
    return values
