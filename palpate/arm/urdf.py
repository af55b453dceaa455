"""What a URDF file says of the geometry of a link: numbers, poses, sizes of primitives, and the files of its meshes."""

from __future__ import annotations

import os
from pathlib import Path
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

from palpate.arm.arm import models_folder
from palpate.base.arrays import Array, so3
from palpate.base.errors import ArmError

SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "capsule": ("radius", "length")}
"""Attributes of the primitives of a URDF [m]; cylinders and capsules lie along z."""


def numbers(element: ElementTree.Element, key: str, count: int, owner: str, default: str = "") -> Array:
    """The numbers (count,) of an attribute of an element of `owner`, such as ``link tip``.

    Raises:
        ArmError: they are not `count` finite numbers.
    """
    text = element.get(key, default)
    try:
        values = np.array([float(x) for x in text.split()])
    except ValueError:
        values = np.empty(0)
    if len(values) != count or not np.isfinite(values).all():
        what = f"<{element.tag} {key}={text!r}> of {owner} is not {count} number{'s' if count > 1 else ''}"
        raise ArmError(what, mend="mend it in the URDF")
    return values


def origin(element: ElementTree.Element, owner: str) -> Array:
    """Pose (4, 4) of an element by its <origin>.

    Raises:
        ArmError: as `numbers`.
    """
    X, given = np.eye(4), element.find("origin")
    if given is not None:
        X[:3, 3] = numbers(given, "xyz", 3, owner, "0 0 0")
        x, y, z = np.eye(3)
        roll, pitch, yaw = numbers(given, "rpy", 3, owner, "0 0 0")
        X[:3, :3] = so3.about(z, yaw) @ so3.about(y, pitch) @ so3.about(x, roll)
    return X


def size(shape: ElementTree.Element, owner: str) -> Array:
    """Numbers of `SIZES` of a primitive [m].

    Raises:
        ArmError: as `numbers`, or a size is not above zero.
    """
    found = np.concatenate([numbers(shape, key, 3 if key == "size" else 1, owner) for key in SIZES[shape.tag]])
    if not (found > 0.0).all():
        what = f"the {shape.tag} of {owner} has the size {', '.join(f'{x:g}' for x in found)} m"
        raise ArmError(what, mend="give sizes above zero in the URDF")
    return found


def file_of(name: str, owner: str, folder: Path | None) -> Path:
    """The file that a URDF, or a file beside it, names: beside it in `folder` or above, in a package, or of the models.

    The folder of package://NAME is searched for as a folder above the URDF that has this name or contains one, then in
    ROS_PACKAGE_PATH and AMENT_PREFIX_PATH; if none is found, the path within the package is looked for in the folders
    above the URDF, as an archive of a package may be unpacked under another name.

    Raises:
        ArmError: it is not found; the message names the places.
    """
    places = _places(name, (folder or Path()).resolve())
    found = next((place for place in places if place.is_file()), None)
    if found is None:
        tried = ", ".join(str(place) for place in places[:3]) + (", ..." if len(places) > 3 else "")
        mend = "put it beside the URDF, give its full path there, or name the package's folder in ROS_PACKAGE_PATH"
        raise ArmError(f"{name} of {owner} is not found", why=f"looked for {tried}", mend=mend)
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
