"""Parts of a URDF: frames, primitive shapes, bodies, links and joints. Units: m, rad, kg, N m."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

Vec = tuple[float, float, float]

COLOURS = {
    "shell": (0.84, 0.85, 0.86, 1.0),
    "steel": (0.62, 0.65, 0.69, 1.0),
    "dark": (0.20, 0.22, 0.25, 1.0),
    "grip": (0.09, 0.10, 0.11, 1.0),
    "accent": (0.13, 0.45, 0.66, 1.0),
    "brass": (0.75, 0.66, 0.42, 1.0),
}


# ---------------------------------------------------------------- geometry of frames
def rot(axis: str, degrees: float) -> np.ndarray:
    """Rotation about a coordinate axis as 4x4, exact at multiples of 90 degrees."""
    c, s = round(math.cos(math.radians(degrees)), 15), round(math.sin(math.radians(degrees)), 15)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    X = np.eye(4)
    X[i, i], X[i, j], X[j, i], X[j, j] = c, -s, s, c
    return X


def move(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    """Translation as 4x4 [m]."""
    X = np.eye(4)
    X[:3, 3] = x, y, z
    return X


def rpy(R: np.ndarray) -> Vec:
    """Roll, pitch, yaw of URDF: R = Rz(yaw) Ry(pitch) Rx(roll) [rad]."""
    if abs(R[2, 0]) > 1 - 1e-12:
        return 0.0, -math.copysign(math.pi / 2, R[2, 0]), math.atan2(-R[0, 1], R[1, 1])
    return math.atan2(R[2, 1], R[2, 2]), math.asin(-R[2, 0]), math.atan2(R[1, 0], R[0, 0])


def number(x: float) -> str:
    """A float as text, with all digits and without negative zero."""
    return format(x + 0.0 if abs(x) > 1e-15 else 0.0, ".17g")


def numbers(values: object) -> str:
    """Floats as text, separated by blanks."""
    return " ".join(number(float(x)) for x in np.ravel(np.asarray(values, dtype=float)))


def origin(X: np.ndarray) -> str:
    """The <origin> of a 4x4 pose."""
    return f'<origin xyz="{numbers(X[:3, 3])}" rpy="{numbers(rpy(X[:3, :3]))}"/>'


# ---------------------------------------------------------------- parts of a URDF
@dataclass
class Visual:
    """A primitive drawn at pose X in its link's frame."""

    shape: str
    size: tuple[float, ...]
    X: np.ndarray
    colour: str

    def xml(self) -> str:
        """XML text of this element."""
        geometry = {
            "box": lambda s: f'<box size="{numbers(s)}"/>',
            "cylinder": lambda s: f'<cylinder radius="{number(s[0])}" length="{number(s[1])}"/>',
            "sphere": lambda s: f'<sphere radius="{number(s[0])}"/>',
        }[self.shape](self.size)
        return f'    <visual>{origin(self.X)}<geometry>{geometry}</geometry><material name="{self.colour}"/></visual>\n'


def box(centre: Vec, size: Vec, colour: str) -> Visual:
    """Box along the link's axes."""
    return Visual("box", size, move(*centre), colour)


def rod(a: Vec, b: Vec, radius: float, colour: str) -> Visual:
    """Cylinder from point a to point b."""
    p, q = np.array(a), np.array(b)
    z = (q - p) / np.linalg.norm(q - p)
    helper = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    X = np.eye(4)
    X[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    X[:3, 3] = (p + q) / 2
    return Visual("cylinder", (radius, float(np.linalg.norm(q - p))), X, colour)


def ball(centre: Vec, radius: float, colour: str) -> Visual:
    """Sphere."""
    return Visual("sphere", (radius,), move(*centre), colour)


@dataclass
class Body:
    """Mass [kg], centre of mass in the link's frame [m], and diagonal inertia about that centre [kg m^2]."""

    mass: float
    com: Vec
    inertia: Vec

    def xml(self) -> str:
        """XML text of this element."""
        ixx, iyy, izz = (number(x) for x in self.inertia)
        return (
            f'    <inertial><origin xyz="{numbers(self.com)}" rpy="0 0 0"/><mass value="{number(self.mass)}"/>'
            f'<inertia ixx="{ixx}" ixy="0" ixz="0" iyy="{iyy}" iyz="0" izz="{izz}"/></inertial>\n'
        )


@dataclass
class Link:
    """A link with its visuals and its body."""

    name: str
    visuals: list[Visual] = field(default_factory=list)
    body: Body | None = None

    def xml(self) -> str:
        """XML text of this element."""
        inside = (self.body.xml() if self.body else "") + "".join(v.xml() for v in self.visuals)
        return f'  <link name="{self.name}">\n{inside}  </link>\n' if inside else f'  <link name="{self.name}"/>\n'


@dataclass
class Joint:
    """A joint. `limits`: q_min, q_max, tau_max, v_max. `mimic`: (joint, multiplier) of a joint that is drawn only."""

    name: str
    parent: str
    child: str
    X: np.ndarray
    kind: str = "fixed"
    axis: Vec = (0, 0, 1)
    limits: tuple[float, float, float, float] | None = None
    mimic: tuple[str, float] | None = None

    def xml(self) -> str:
        """XML text of this element."""
        inside = f'    <parent link="{self.parent}"/><child link="{self.child}"/>\n    {origin(self.X)}\n'
        if self.kind != "fixed":
            lower, upper, effort, velocity = self.limits or (-math.pi, math.pi, 0.0, 100.0)
            inside += (
                f'    <axis xyz="{numbers(self.axis)}"/><limit lower="{number(lower)}" upper="{number(upper)}" '
                f'effort="{number(effort)}" velocity="{number(velocity)}"/>\n'
            )
        if self.mimic:
            inside += f'    <mimic joint="{self.mimic[0]}" multiplier="{number(self.mimic[1])}"/>\n'
        return f'  <joint name="{self.name}" type="{self.kind}">\n{inside}  </joint>\n'


def urdf(name: str, parts: list[Link | Joint]) -> str:
    """Text of the whole URDF file."""
    materials = "".join(
        f'  <material name="{key}"><color rgba="{numbers(c)}"/></material>\n' for key, c in COLOURS.items()
    )
    head = (
        f'<?xml version="1.0"?>\n<!-- Generated by models/generate.py: edit that script. -->\n<robot name="{name}">\n'
    )
    return head + materials + "".join(p.xml() for p in parts) + "</robot>\n"


def standard_dh(alpha: float, a: float, d: float, offset: float) -> np.ndarray:
    """T(0) of a standard Denavit-Hartenberg row: pose of the next joint in this joint's frame (degrees, m)."""
    return rot("z", offset) @ move(z=d) @ move(x=a) @ rot("x", alpha)


def modified_dh(alpha: float, a: float, d: float, offset: float) -> np.ndarray:
    """T(0) of a modified (Craig) row: pose of this joint in the previous joint's frame (degrees, m)."""
    return rot("x", alpha) @ move(x=a) @ move(z=d) @ rot("z", offset)
