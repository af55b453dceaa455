"""Exercises of the dVRK's simulators as scenes: a YAML file that names URDF files of rigid objects and their poses.

    scene:
      name: tray
      objects:
        - {name: cube, asset: package://NAME/share/cube.urdf, fixed: false, position: [0, 0, 0.05],
           orientation_xyzw: [0, 0, 0, 1]}

Each object becomes a body with the collision shapes of its link. Arms and a table plane are added: a PSM with ProGrasp
forceps above the middle of what is fixed, and an MTM.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np

from palpate.arm import urdf
from palpate.base import limits
from palpate.base.arrays import Array, so3
from palpate.base.errors import ArmError, SceneError

_ABOVE = 0.19  # height of the follower's base above the lowest fixed object [m]
_TOOL = 0.07  # height of the tool at the start above it [m]
_FRICTION = 0.6  # where a link states none


def values(data: dict[str, Any], name: str) -> dict[str, Any]:
    """The values of a scene from those of an exercise in the file `name`.

    Raises:
        SceneError: an object has no asset, its URDF is not found or has more than a rigid link.
    """
    folder, objects = Path(name).parent, data["scene"]["objects"]
    bodies = [_body(given, f"{name}: object {k + 1}", folder) for k, given in enumerate(objects)]
    low = min((body["pose"]["xyz"][2] for body in bodies), default=0.0)
    return {
        "objects": [{"name": "plane below", "plane": {"size": 0.4}, "pose": {"xyz": [0, 0, low - 0.006]}}],
        "bodies": bodies,
        "engine": {"field": [[-0.4, -0.4, low - 0.3], [0.4, 0.4, low + 0.5]]},
        "arms": {
            "leader": {"base": {"xyz": [0.345, 0.243, low + 0.219], "rpy_deg": [0, 0, -20]}},
            "follower": {
                "model": "psm_prograsp",
                "base": {"xyz": [0, 0, low + _ABOVE], "rpy_deg": [0, 0, 180]},
                "jaw": {"start": 1.0, "closed": 0.0, "open": 1.0},
            },
        },
        "mapping": {"scale": 0.5, "align_rate": 0},
        "contact": {"radius": 0.002},
        "operator": {"tremor": 0.00005, "path": [{"t": 0.0, "xyz": [0.0, 0.0, low + _TOOL]}]},
    }


def _body(given: Any, where: str, folder: Path) -> dict[str, Any]:
    """A body from an entry of the list `objects`."""
    if not isinstance(given, dict) or not isinstance(given.get("asset"), str):
        mend = "write asset: package://NAME/PATH.urdf, or the path of a URDF file"
        raise SceneError("an object of the exercise has no asset", where=where, mend=mend)
    name = str(given.get("name", Path(given["asset"]).stem))
    where = f"{where} ({name})"
    try:
        return _made(given, name, urdf.file_of(given["asset"], "the exercise", folder), where)
    except ArmError as error:
        raise SceneError(error.what, where=where, why=error.why, mend=error.mend) from None


def _made(given: dict[str, Any], name: str, file: Path, where: str) -> dict[str, Any]:
    link = _link(file, where)
    X = _pose(given, where)
    found = {"name": name, "pose": _as_pose(X), "friction": _friction(link), "parts": _parts(link, file, where)}
    if given.get("fixed", False) is True:
        return found | {"fixed": True}
    mass = link.find("inertial/mass")
    return found if mass is None else found | {"mass": float(urdf.numbers(mass, "value", 1, "the link")[0])}


def _link(file: Path, where: str) -> Xml.Element:
    """The only link of a URDF file."""
    try:
        text = limits.read_text(file)
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise ValueError("it declares entities")
        root = Xml.fromstring(text)
    except (OSError, ValueError, Xml.ParseError) as error:
        raise SceneError(f"{file} cannot be read", where=where, why=str(error), mend="name a URDF file") from None
    links = root.findall("link")
    if root.tag != "robot" or len(links) != 1:
        what = f"{file} has {len(links)} links, and an object of an exercise has one"
        raise SceneError(what, where=where, mend="name a URDF file with a single link; arms are not objects")
    return links[0]


def _parts(link: Xml.Element, file: Path, where: str) -> list[dict[str, Any]]:
    """The parts of a body from the collision shapes of a link, each in the colour of the drawn shape of its number."""
    shapes = link.findall("collision")
    if not shapes:
        what = f"{file}: its link has no collision shape"
        raise SceneError(what, where=where, mend="give it one: box, cylinder, mesh")
    colors = [_color(visual, link) for visual in link.findall("visual")]
    found = []
    for k, shape in enumerate(shapes):
        part = _shape(shape, file, where) | {"pose": _as_pose(urdf.origin(shape, str(file)))}
        color = colors[min(k, len(colors) - 1)] if colors else None
        found.append(part if color is None else part | {"color": color})
    return found


def _shape(collision: Xml.Element, file: Path, where: str) -> dict[str, Any]:
    shape = next(iter(collision.findall("geometry/*")), None)
    kind = "nothing" if shape is None else str(shape.tag)
    if shape is not None and kind in urdf.SIZES:
        size = urdf.size(shape, str(file)).tolist()
        one = size[0] if kind == "sphere" else dict(zip(urdf.SIZES[kind], size, strict=False))
        return {kind: size if kind == "box" else one}
    if shape is not None and kind == "mesh":
        if (urdf.numbers(shape, "scale", 3, str(file), "1 1 1") != 1.0).any():
            raise SceneError(f"{file}: a mesh has a scale", where=where, mend="scale the mesh file itself")
        return {"mesh": str(urdf.file_of(shape.get("filename", ""), str(file), file.parent)), "unit": "m"}
    raise SceneError(f"{file}: a shape is {kind}", where=where, mend="use box, sphere, cylinder, capsule or mesh")


def _color(visual: Xml.Element, link: Xml.Element) -> list[int] | None:
    """Colour of a drawn shape, 0 to 255; None if the link does not state it."""
    own = visual.find("material")
    name = "" if own is None else own.get("name", "")
    for material in [*visual.findall("material"), *link.findall("visual/material")]:
        color = material.find("color")
        if color is not None and material.get("name", "") == name:
            rgba = np.clip(urdf.numbers(color, "rgba", 4, "a material"), 0.0, 1.0)
            return [round(255 * c) for c in rgba[:3].tolist()]
    return None


def _friction(link: Xml.Element) -> float:
    given = link.find("contact/lateral_friction")
    return _FRICTION if given is None else float(urdf.numbers(given, "value", 1, "the link")[0])


def _pose(given: dict[str, Any], where: str) -> Array:
    try:
        p = np.array(given.get("position", [0, 0, 0]), dtype=float).reshape(3)
        x, y, z, w = np.array(given.get("orientation_xyzw", [0, 0, 0, 1]), dtype=float).reshape(4)
    except (TypeError, ValueError) as error:
        mend = "position: three numbers in m; orientation_xyzw: four"
        raise SceneError("the pose of an object is invalid", where=where, why=str(error), mend=mend) from None
    return so3.pose(p, [w, x, y, z])


def _as_pose(X: Array) -> dict[str, list[float]]:
    """A pose as a scene's file has it."""
    R = X[:3, :3]
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    roll, yaw = np.arctan2(R[2, 1], R[2, 2]), np.arctan2(R[1, 0], R[0, 0])
    return {"xyz": X[:3, 3].tolist(), "rpy_deg": np.degrees([roll, pitch, yaw]).tolist()}
