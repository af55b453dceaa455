"""Primitive and implicit surfaces in a scene file; each section makes the surface for one key of an object."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from palpate.base.values import Positive, Section
from palpate.world import surfaces

_Even = Annotated[int, Field(strict=True, ge=2, le=12, multiple_of=2)]


class PlaneSection(Section):
    """The unbounded half-space below z = 0 of the object."""

    size: Positive = 0.2
    """side of the drawn square [m]"""

    def make(self, name: str) -> surfaces.Plane:
        """The surface."""
        return surfaces.Plane(self.size, name=name)


class SphereSection(Section):
    """A sphere around the object's origin."""

    radius: Positive
    """radius [m]"""

    def make(self, name: str) -> surfaces.Sphere:
        """The surface."""
        return surfaces.Sphere(self.radius, name=name)


class BoxSection(Section):
    """A box around the object's origin, with its sides along the axes."""

    size: tuple[Positive, Positive, Positive]
    """sides along x, y and z [m]"""

    def make(self, name: str) -> surfaces.Box:
        """The surface."""
        return surfaces.Box(self.size, name=name)


class CylinderSection(Section):
    """A cylinder with flat ends around the object's z axis."""

    radius: Positive
    """radius [m]"""
    length: Positive
    """length from end to end [m]"""

    def make(self, name: str) -> surfaces.Cylinder:
        """The surface."""
        return surfaces.Cylinder(self.radius, self.length, name=name)


class CapsuleSection(Section):
    """A cylinder with round ends around the object's z axis."""

    radius: Positive
    """radius of the cylinder and its ends [m]"""
    length: Positive
    """length between the centres of the round ends [m]"""

    def make(self, name: str) -> surfaces.Capsule:
        """The surface."""
        return surfaces.Capsule(self.radius, self.length, name=name)


class ImplicitSection(Section):
    """The implicit surface of the paper's Eq 14: sum of (x_i / half_i)^exponent_i = 1."""

    half: tuple[Positive, Positive, Positive]
    """half lengths along x, y and z [m]"""
    exponents: tuple[_Even, _Even, _Even] = (2, 2, 2)
    """exponents of x, y and z: 2, 4, ... 12; 2 gives an ellipsoid, larger values a pillow [-]"""

    def make(self, name: str) -> surfaces.ImplicitSurface:
        """The surface."""
        return surfaces.ImplicitSurface.of_half_lengths(self.half, self.exponents, name=name)


SOLIDS = ("plane", "sphere", "box", "cylinder", "capsule", "implicit")
"""Keys of an object that take one of these sections."""
