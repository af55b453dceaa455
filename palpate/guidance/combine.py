"""Geometries made of geometries, and the section of a scene file that is any of them."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from palpate import _core
from palpate.arrays import Array
from palpate.errors import GuidanceError
from palpate.guidance.geometry import (
    Box,
    Cloud,
    Cone,
    Cylinder,
    Grid,
    Line,
    Mesh,
    OfObject,
    Plane,
    Point,
    Shape,
    Sphere,
    refused,
)
from palpate.guidance.here import Here
from palpate.guidance.paths import Path, Tube
from palpate.values import Length, NotNegativeLength, Section


class Offset(Shape):
    """Everything within a margin of a geometry; below zero: it is shrunk."""

    key: ClassVar[str] = "offset"
    of: Geometry
    """what is grown"""
    margin: Length
    """by so much; above zero around what has no inside [m]"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """What is grown, or shrunk."""
        try:
            return _core.OffsetGeometry(self.of.make(here, X_WF), self.margin)
        except GuidanceError:
            raise
        except ValueError as error:
            raise refused(error, "offset") from None


class Combination(Shape):
    """Several geometries as one."""

    of: Annotated[tuple[Geometry, ...], Field(min_length=1, max_length=64)]
    """its parts"""
    blend: NotNegativeLength = 0.0
    """creases are filled over so much, so that the normal turns gradually; 0: it turns at once [m]"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The whole."""
        parts = [part.make(here, X_WF) for part in self.of]
        try:
            return _core.CombinedGeometry(self.key, parts, self.blend)  # type: ignore[arg-type]  # one of three
        except ValueError as error:
            raise refused(error, self.key) from None


class Union(Combination):
    """What is in any of the parts."""

    key: ClassVar[str] = "union"


class Intersection(Combination):
    """What is in all of the parts."""

    key: ClassVar[str] = "intersection"


class Difference(Combination):
    """What is in the first part and in none of the others."""

    key: ClassVar[str] = "difference"


class Geometry(Section):
    """One shape: a point, a curve, a solid, a surface from a file or of the scene, or one made of others."""

    point: Point | None = None
    """a place"""
    line: Line | None = None
    """from place to place, or endless"""
    plane: Plane | None = None
    """a half-space"""
    path: Path | None = None
    """a smooth curve"""
    tube: Tube | None = None
    """everything near a path"""
    cone: Cone | None = None
    """the way from an entry to a target"""
    sphere: Sphere | None = None
    """a ball"""
    box: Box | None = None
    """a box"""
    cylinder: Cylinder | None = None
    """a cylinder"""
    mesh: Mesh | None = None
    """triangles from a file"""
    cloud: Cloud | None = None
    """points from a file"""
    grid: Grid | None = None
    """a signed distance grid"""
    object: OfObject | None = None
    """the surface of an object of the scene"""
    offset: Offset | None = None
    """a geometry grown or shrunk"""
    union: Union | None = None
    """any of several"""
    intersection: Intersection | None = None
    """all of several"""
    difference: Difference | None = None
    """the first without the others"""

    @model_validator(mode="before")
    @classmethod
    def _of_shape(cls, value: Any) -> Any:
        return {value.key: value} if isinstance(value, Shape) else value

    @model_validator(mode="after")
    def _one(self) -> Self:
        given = [key for key in type(self).model_fields if getattr(self, key) is not None]
        if len(given) != 1:
            told = f"{' and '.join(given)} are given" if given else "none is given"
            keys = ", ".join(type(self).model_fields)
            raise ValueError(f"a geometry is one of {keys}; {told} | keep one of them, e.g. sphere: {{radius: 2 cm}}")
        return self

    @model_serializer(mode="wrap")
    def _given(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {key: value for key, value in handler(self).items() if value is not None}

    @property
    def shape(self) -> Shape:
        """What is given."""
        shape: Shape = next(filter(None, (getattr(self, key) for key in type(self).model_fields)))
        return shape

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """What the core asks.

        Raises:
            GuidanceError, MeshError, SurfaceError: what it names is not there, or cannot be.
        """
        return self.shape.make(here, X_WF)


for _model in (Offset, Union, Intersection, Difference, Geometry):
    _model.model_rebuild()
