"""Sections `bodies` and `engine` of a scene: rigid bodies, their joints, and their coupling to the tools."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from palpate.base.errors import ValueAtError
from palpate.base.values import Color, NotNegative, Number, Pose, Positive, Section, Vector

Length = Annotated[Positive, Field(le=1.0)]


class CylinderSection(Section):
    """A cylinder, or a capsule, whose axis is z of its frame."""

    radius: Length
    """radius [m]"""
    length: Length
    """length of the axis; a capsule's round ends are not counted [m]"""


class RingSection(Section):
    """A ring around z of its frame, made of capsules."""

    radius: Length
    """radius of the circle in the middle of the ring [m]"""
    thickness: Length
    """thickness of the ring [m]"""
    arc_deg: Annotated[Positive, Field(ge=1.0, le=360.0)] = 360.0
    """arc from x of its frame on; 360: closed [deg]"""
    segments: Annotated[int, Field(strict=True, ge=3, le=48)] = 16
    """number of capsules"""


class WireSection(Section):
    """A wire along a line through points, made of capsules."""

    points: Annotated[tuple[Vector, ...], Field(min_length=2, max_length=200)]
    """points of its axis [m]"""
    radius: Length
    """radius [m]"""

    @model_validator(mode="after")
    def _apart(self) -> WireSection:
        for k, (a, b) in enumerate(pairwise(self.points)):
            if not 1e-6 <= float(np.linalg.norm(np.subtract(a, b))) <= 10.0:
                what = f"points {k} and {k + 1} of a wire are not between 1 um and 10 m apart"
                raise ValueError(f"{what} | leave one out, or move it")
        return self


class PartSection(Section):
    """A part of a body: one shape, at a pose in the body's frame."""

    box: tuple[Length, Length, Length] | None = None
    """lengths of the edges along x, y, z [m]"""
    sphere: Length | None = None
    """radius [m]"""
    cylinder: CylinderSection | None = None
    """a cylinder along z"""
    capsule: CylinderSection | None = None
    """a cylinder with round ends along z"""
    ring: RingSection | None = None
    """a ring around z"""
    wire: WireSection | None = None
    """a wire through points"""
    mesh: str | None = None
    """mesh file, relative to the scene's folder; the engine touches the convex hull of each piece that is not joined"""
    unit: Literal["mm", "cm", "m", "in"] | None = None
    """unit of the mesh file; when left out, as for an object of the scene"""
    pose: Pose = Field(default_factory=Pose)
    """pose in the body's frame"""
    color: Color | None = None
    """colour; that of the body when left out"""

    @model_validator(mode="after")
    def _one_shape(self) -> PartSection:
        shapes = [
            name for name in ("box", "sphere", "cylinder", "capsule", "ring", "wire", "mesh") if getattr(self, name)
        ]
        if len(shapes) != 1:
            given = " and ".join(shapes) or "no shape"
            raise ValueError(f"a part has one shape, and this one has {given} | give one of box, sphere, cylinder, "
                             "capsule, ring, wire, mesh")  # fmt: skip
        return self


class JointSection(Section):
    """How a body is connected to another one."""

    to: str
    """name of the other body, earlier in the list"""
    kind: Literal["hinge", "ball", "slide", "weld"] = "ball"
    """hinge and slide: about and along `axis`"""
    at: Vector = (0.0, 0.0, 0.0)
    """position of the joint in the frame of this body [m]"""
    axis: Vector = (0.0, 0.0, 1.0)
    """axis in the frame of this body [-]"""
    damping: NotNegative = 0.0
    """damping [N m s/rad, N s/m]"""
    stiffness: NotNegative = 0.0
    """stiffness towards the start [N m/rad, N/m]"""


class ChainSection(Section):
    """A thread: capsules in a row along z, each connected to the one before by a ball joint."""

    links: Annotated[int, Field(strict=True, ge=2, le=40)] = 12
    """number of capsules"""
    length: Length = 0.06
    """whole length [m]"""
    radius: Length = 0.0004
    """radius [m]"""
    damping: NotNegative = 2e-6
    """damping of each joint [N m s/rad]"""
    density: Positive = 1200.0
    """density [kg/m^3]"""


class BodySection(Section):
    """A rigid body. One that is not fixed moves freely, or by its joint."""

    name: Annotated[str, Field(min_length=1)]
    """name of the body"""
    parts: Annotated[tuple[PartSection, ...], Field(min_length=1, max_length=64)]
    """shapes that make up the body"""
    pose: Pose = Field(default_factory=Pose)
    """X_WO: pose at the start; with a joint X_AO, in the frame of the other body"""
    fixed: bool = False
    """the body never moves"""
    mass: Annotated[Positive, Field(ge=1e-4, le=100.0)] | None = None
    """mass, which the parts share by their volume [kg]"""
    density: Positive | None = None
    """instead of the mass: density; 1000 when both are left out [kg/m^3]"""
    friction: NotNegative = 0.6
    """coefficient of friction against tools and other bodies; the larger one of both counts [-]"""
    torsion: NotNegative = 0.002
    """friction against rotation about the normal, as torque per normal force [m]"""
    joint: JointSection | None = None
    """connection to another body"""
    thread: ChainSection | None = None
    """a thread that hangs on this body, from its origin along z"""
    touches: bool = True
    """the body touches the objects of the scene, by the contact stage of the tools"""
    color: Color = (214, 172, 58)
    """colour"""

    @model_validator(mode="after")
    def _consistent(self) -> BodySection:
        if self.mass is not None and self.density is not None:
            raise ValueError(f"{self.name!r} has a mass and a density | give one of them")
        if self.fixed and (self.mass is not None or self.joint is not None or self.thread is not None):
            raise ValueError(f"{self.name!r} is fixed, and has a mass, a joint or a thread | leave one out")
        return self

    @property
    def free(self) -> bool:
        """True if the body moves freely."""
        return not self.fixed and self.joint is None


class EngineSection(Section):
    """The engine that moves the bodies, and the coupling of the tools to it."""

    period: Annotated[Positive, Field(ge=0.0001, le=0.02)] = 0.001
    """step of the engine [s]"""
    stiffness: Annotated[Positive, Field(le=5000.0)] = 300.0
    """stiffness between a tool and its virtual tool [N/m]"""
    damping: Annotated[NotNegative, Field(le=50.0)] | None = None
    """damping between both; when left out, as much as keeps the coupling passive (docs/bodies.md) [N s/m]"""
    force_max: Annotated[Positive, Field(le=50.0)] = 5.0
    """largest force of this spring; beyond it the virtual tool yields [N]"""
    grip: Annotated[Positive, Field(le=1.0)] = 0.04
    """largest torque of each jaw [N m]"""
    friction: NotNegative = 0.8
    """friction of the jaws [-]"""
    shafts: bool = True
    """shafts and wrists of the instruments touch bodies, too"""
    release: Annotated[Positive, Field(le=0.2)] = 0.02
    """distance at which a stuck virtual tool is put back to its tool [m]"""
    field: tuple[Vector, Vector] = ((-0.2, -0.2, -0.1), (0.2, 0.2, 0.3))
    """lowest and highest corner in W; a body outside returns to its start [m]"""
    gravity: Vector = (0.0, 0.0, -9.81)
    """gravity in W [m/s^2]"""

    @model_validator(mode="after")
    def _low_below_high(self) -> EngineSection:
        if not np.less(*self.field).all():
            raise ValueError("the lowest corner of field is not below the highest one | swap their coordinates")
        return self


def check(bodies: tuple[BodySection, ...], engine: EngineSection, taken: set[str], most: int) -> None:
    """Refuse names that are taken, joints to unknown bodies, and free bodies that start outside of the field.

    Raises:
        ValueAtError: the message names the body, and the correction.
    """
    names: list[str] = []
    for i, body in enumerate(bodies):
        if body.name in names or body.name in taken:
            raise ValueAtError(f"another object is named {body.name!r} too | rename one of them", "bodies", i, "name")
        if body.joint is not None and body.joint.to not in names:
            what = f"{body.name!r} has a joint to {body.joint.to!r}, which is not listed before it"
            mend = f"name one of {', '.join(names) or 'the bodies before it'}"
            raise ValueAtError(f"{what} | {mend}", "bodies", i, "joint", "to")
        if (
            body.free
            and not (
                np.less_equal(engine.field[0], body.pose.xyz) & np.less_equal(body.pose.xyz, engine.field[1])
            ).all()
        ):
            what = f"{body.name!r} starts outside of the engine's field, to which it would return"
            raise ValueAtError(f"{what} | move it, or make engine.field larger", "bodies", i, "pose", "xyz")
        names.append(body.name)
    moving = sum(not body.fixed for body in bodies)
    if moving > most:
        raise ValueAtError(f"{moving} bodies move, and at most {most} can | fix or remove some", "bodies")


def numbers(values: tuple[Number, ...] | np.ndarray) -> str:
    """Numbers as the engine's files write them."""
    return " ".join(f"{value:.9g}" for value in values)
