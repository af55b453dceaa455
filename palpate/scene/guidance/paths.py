"""Paths and tubes, from waypoints, a file or a demonstration."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from palpate.base.arrays import Array
from palpate.base.values import NotNegative, Place, Positive
from palpate.base.values import Pose as PoseSection
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.guidance.geometry import Shape, Unit
from palpate.scene.guidance.sections import CROSSING

if TYPE_CHECKING:
    from palpate import _guidance


class Path(Shape):
    """A smooth curve through waypoints."""

    key: ClassVar[str] = "path"
    file: str | None = None
    """file (.csv) with x, y, z and optionally the attitude qw, qx, qy, qz in each row; relative to the scene file"""
    waypoints: Annotated[tuple[Place, ...], Field(max_length=10_000)] = ()
    """waypoints instead of a file [m]"""
    unit: Unit = "mm"
    """unit of the numbers in the file, unless its header names the unit (x_m, y_m, z_m)"""
    closed: bool = False
    """true: the end joins the beginning smoothly"""
    crossing: NotNegative = CROSSING
    """smallest distance allowed between two stretches of the path; 0 allows crossings [m]"""
    pose: PoseSection = PoseSection()
    """pose of the file's own frame; unused with waypoints"""

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if (self.file is None) == (not self.waypoints):
            count = "both are given" if self.waypoints else "none is given"
            raise ValueError(f"a path is a file or waypoints; {count} | keep one of them, e.g. file: suture.csv")
        return self

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The curve."""
        return self.curve(context, X_WF)

    def curve(self, context: FixtureContext, X_WF: Array) -> _guidance.PathGeometry:
        """The curve in F."""
        from palpate.scene.guidance import curve

        if self.file is None:
            points = np.array([context.place(p, X_WF) for p in self.waypoints])
            return curve.path(points, closed=self.closed, crossing=self.crossing, name="waypoints")
        file = context.file(self.file)
        from palpate.scene.guidance.files import read_rows

        points, R = read_rows(file, self.unit)
        X = self.pose.matrix()
        points, R = points @ X[:3, :3].T + X[:3, 3], None if R is None else X[:3, :3] @ R
        return curve.path(points, R, closed=self.closed, crossing=self.crossing, name=str(file))


class Tube(Path):
    """All points within a radius of a path."""

    key: ClassVar[str] = "tube"
    radius: Positive | None = None
    """radius of the tube; around a plan, the plan's clearance when left out [m]"""

    @model_validator(mode="after")
    def _has_radius(self) -> Self:
        from palpate.scene.guidance.files import is_plan

        if self.radius is None and not is_plan(self.file):
            raise ValueError("a tube needs a radius | e.g. radius: 2 mm; only a plan (.yaml) has one of its own")
        return self

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The tube."""
        from palpate import _guidance

        radius = self.radius
        if radius is None:
            from palpate.scene.guidance.files import clearance_of_plan

            assert self.file is not None
            radius = clearance_of_plan(context.file(self.file))
        return _guidance.OffsetGeometry(self.curve(context, X_WF), radius)
