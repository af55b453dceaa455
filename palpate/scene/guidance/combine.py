"""Geometries combined from other geometries, and the scene section that accepts any geometry."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import (
    Field,
    ModelWrapValidatorHandler,
    PrivateAttr,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from palpate.base.arrays import Array
from palpate.base.arrays.plain import Content
from palpate.base.errors import GuidanceError
from palpate.base.values import NotNegative, Number, Section
from palpate.scene.guidance import geometry as shapes
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.guidance.geometry import Shape, as_guidance_error
from palpate.scene.guidance.paths import Path, Tube

if TYPE_CHECKING:
    from palpate import _guidance


class Offset(Shape):
    """All points within a margin of a geometry; a negative margin shrinks the geometry."""

    key: ClassVar[str] = "offset"
    of: Geometry
    """the geometry to grow"""
    margin: Number
    """distance to grow; must be positive for a geometry without an inside [m]"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The grown or shrunk geometry."""
        from palpate import _guidance

        try:
            return _guidance.OffsetGeometry(self.of.make(context, X_WF), self.margin)
        except GuidanceError:
            raise
        except ValueError as error:
            raise as_guidance_error(error, "offset") from None


class Combination(Shape):
    """Several geometries as one."""

    of: Annotated[tuple[Geometry, ...], Field(min_length=1, max_length=64)]
    """the geometries to combine"""
    blend: NotNegative = 0.0
    """width over which creases are rounded, so that the normal turns continuously; 0: sharp creases [m]"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The combined geometry."""
        from palpate import _guidance

        parts = [part.make(context, X_WF) for part in self.of]
        try:
            return _guidance.CombinedGeometry(self.key, parts, self.blend)  # type: ignore[arg-type]  # key is one of the three literals
        except ValueError as error:
            raise as_guidance_error(error, self.key) from None


class Union(Combination):
    """All points that lie in at least one part."""

    key: ClassVar[str] = "union"


class Intersection(Combination):
    """All points that lie in every part."""

    key: ClassVar[str] = "intersection"


class Difference(Combination):
    """All points that lie in the first part and in no other part."""

    key: ClassVar[str] = "difference"


class Geometry(Section):
    """One geometry: a point, a curve, a solid, a surface from a file or of a scene object, or a combination."""

    point: shapes.Point | None = None
    """a point"""
    line: shapes.Line | None = None
    """a straight line between two places, or through them without end"""
    plane: shapes.Plane | None = None
    """a half-space"""
    path: Path | None = None
    """a smooth curve"""
    tube: Tube | None = None
    """all points within a radius of a path"""
    cone: shapes.Cone | None = None
    """the region from an entry to a target"""
    sphere: shapes.Sphere | None = None
    """a ball"""
    box: shapes.Box | None = None
    """a box"""
    cylinder: shapes.Cylinder | None = None
    """a cylinder"""
    mesh: shapes.Mesh | None = None
    """triangles from a file"""
    cloud: shapes.Cloud | None = None
    """points from a file"""
    grid: shapes.Grid | None = None
    """a signed distance grid"""
    object: shapes.OfObject | None = None
    """the surface of an object of the scene"""
    offset: Offset | None = None
    """a grown or shrunk geometry"""
    union: Union | None = None
    """the union of several geometries"""
    intersection: Intersection | None = None
    """the intersection of several geometries"""
    difference: Difference | None = None
    """the first geometry without the others"""
    _other: Shape | None = PrivateAttr(None)  # of another distribution, whose key no field has

    @model_validator(mode="wrap")
    @classmethod
    def _take_shape(cls, value: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        other = _of_others(value)
        if other is not None:
            section = cls.model_construct()
            section._other = other
            return section
        return handler({value.key: value} if isinstance(value, Shape) else value)

    @model_validator(mode="after")
    def _require_one(self) -> Self:
        given = [key for key in type(self).model_fields if getattr(self, key) is not None]
        if len(given) != 1 and self._other is None:
            from palpate.base import plugins

            count = f"{' and '.join(given)} are given" if given else "none is given"
            keys = ", ".join([*type(self).model_fields, *plugins.names("palpate.shapes")])
            raise ValueError(f"a geometry is one of {keys}; {count} | keep one of them, e.g. sphere: {{radius: 2 cm}}")
        return self

    @model_serializer(mode="wrap")
    def _dump_given(self, handler: SerializerFunctionWrapHandler) -> Content:
        if self._other is not None:
            return {self._other.key: self._other.model_dump()}
        return {key: value for key, value in handler(self).items() if value is not None}

    @property
    def shape(self) -> Shape:
        """The shape that is given."""
        if self._other is not None:
            return self._other
        shape: Shape = next(filter(None, (getattr(self, key) for key in type(self).model_fields)))
        return shape

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The geometry for the core.

        Raises:
            GuidanceError, MeshError, SurfaceError: a file, object or place is missing, or a value is invalid.
        """
        return self.shape.make(context, X_WF)


for _model in (Offset, Union, Intersection, Difference, Geometry):
    _model.model_rebuild()


def _of_others(value: Any) -> Shape | None:
    """A shape that another distribution adds (group palpate.shapes of entry points), given as itself or by its key."""
    fields = Geometry.model_fields.keys()
    if isinstance(value, Shape):
        return None if value.key in fields else value
    if not isinstance(value, dict) or len(value) != 1 or value.keys() & fields:
        return None
    from palpate.base import plugins

    ((key, given),) = value.items()
    kind: type[Shape] | None = plugins.load("palpate.shapes", str(key))
    return None if kind is None else kind.model_validate(given)
