"""Appearance of an arm: the primitives and drawn joints of its URDF, or sticks if it has no primitives."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array, so3

_STICK = 0.012  # radius of a stick [m]
_STEEL = (0.62, 0.65, 0.69, 1.0)


@dataclass(frozen=True)
class Visual:
    """One primitive of a link, drawn at `X_0link @ X_link_visual`."""

    link: str
    shape: str  # "box" | "cylinder" (along z) | "sphere"
    size: tuple[float, ...]  # box: x y z; cylinder: radius, length; sphere: radius [m]
    X_link_visual: Array  # (4, 4)
    colour: tuple[float, float, float, float]  # r g b a, 0..1


@dataclass(frozen=True)
class DrawnJoint:
    """A joint outside the kinematic chain (jaw, grip, bar of a parallelogram): drawn, but without dynamics."""

    name: str
    parent: str
    child: str
    X_parent: Array
    axis: Array
    source: str  # the joint that it follows: a joint of the chain, or a free one such as "jaw"
    multiplier: float


def _numbers(text: str | None, default: str) -> Array:
    return np.array([float(x) for x in (text or default).split()])


def _origin(element: ElementTree.Element | None) -> Array:
    X = np.eye(4)
    if element is None:
        return X
    roll, pitch, yaw = _numbers(element.get("rpy"), "0 0 0")
    X[:3, :3] = (
        turn_about(np.array([0, 0, 1.0]), yaw)
        @ turn_about(np.array([0, 1.0, 0]), pitch)
        @ turn_about(np.array([1.0, 0, 0]), roll)
    )[:3, :3]
    X[:3, 3] = _numbers(element.get("xyz"), "0 0 0")
    return X


def turn_about(axis: Array, angle: npt.ArrayLike) -> Array:
    """Rotation (..., 4, 4) by each of the angles (...) [rad] about a unit axis (3,)."""
    X = np.zeros((*np.shape(angle), 4, 4))
    X[..., :3, :3], X[..., 3, 3] = so3.about(axis, angle), 1.0
    return X


def sticks(segments: list[tuple[str, Array]]) -> list[Visual]:
    """A cylinder from each link's origin to the end of its segment, and a sphere at that end."""
    found = []
    for link, end in segments:
        length = float(np.linalg.norm(end))
        radius = min(_STICK, 0.15 * length)
        z = end / length
        x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
        x /= np.linalg.norm(x)
        X = np.eye(4)
        X[:3, 0], X[:3, 1], X[:3, 2], X[:3, 3] = x, np.cross(z, x), z, 0.5 * end
        found.append(Visual(link, "cylinder", (radius, length), X, _STEEL))
        ball = np.eye(4)
        ball[:3, 3] = end
        found.append(Visual(link, "sphere", (1.3 * radius,), ball, _STEEL))
    return found


def visuals(robot: ElementTree.Element) -> list[Visual]:
    """Boxes, cylinders and spheres of every link."""
    colours: dict[str | None, tuple[float, ...]] = {
        m.get("name"): tuple(_numbers(c.get("rgba"), "0.7 0.7 0.7 1"))
        for m in robot.iter("material")
        if (c := m.find("color")) is not None
    }
    found = []
    for link in robot.findall("link"):
        for visual in link.findall("visual"):
            geometry = visual.find("geometry")
            shape = None if geometry is None else next(iter(geometry), None)
            if shape is None or shape.tag not in ("box", "cylinder", "sphere"):
                continue
            keys = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}[shape.tag]
            size = tuple(float(x) for key in keys for x in _numbers(shape.get(key), "0"))
            material = visual.find("material")
            r, g, b, a = colours.get(None if material is None else material.get("name"), (0.7, 0.7, 0.7, 1.0))
            found.append(Visual(link.get("name", ""), shape.tag, size, _origin(visual.find("origin")), (r, g, b, a)))
    return found


def _moving(robot: ElementTree.Element, chain: set[str]) -> list[ElementTree.Element]:
    """Joints that move but are not in the chain."""
    return [j for j in robot.findall("joint") if j.get("type") != "fixed" and j.get("name") not in chain]


def drawn_joints(robot: ElementTree.Element, chain: set[str]) -> list[DrawnJoint]:
    """Drawn joints in file order, parents before children. A joint without <mimic> follows the jaw angle."""
    drawn = []
    for joint in _moving(robot, chain):
        parent, child, axis, mimic = (joint.find(tag) for tag in ("parent", "child", "axis", "mimic"))
        assert parent is not None
        assert child is not None
        name = joint.get("name", "")
        drawn.append(
            DrawnJoint(
                name,
                parent.get("link", ""),
                child.get("link", ""),
                _origin(joint.find("origin")),
                _numbers(None if axis is None else axis.get("xyz"), "1 0 0"),
                name if mimic is None else mimic.get("joint", ""),
                1.0 if mimic is None else float(mimic.get("multiplier", "1")),
            )
        )
    return drawn


def jaw_range(robot: ElementTree.Element, chain: set[str]) -> tuple[float, float]:
    """Limits of the joint that opens the jaws or the grips [rad]; (0, 0) for an arm without one."""
    for joint in _moving(robot, chain):
        limit = joint.find("limit")
        if joint.find("mimic") is None and limit is not None:
            return float(limit.get("lower", "0")), float(limit.get("upper", "0"))
    return 0.0, 0.0
