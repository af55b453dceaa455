"""Geometries of fixtures, as scene sections and Python classes; the core evaluates them (geometry.hpp)."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import GuidanceError, SurfaceError
from palpate.base.values import Number, Place, Positive, Section, Vector
from palpate.base.values import Pose as PoseSection
from palpate.scene.guidance.context import FixtureContext

if TYPE_CHECKING:
    from palpate import _guidance

Unit = Literal["mm", "cm", "m", "in"]

MESHES = (".stl", ".obj", ".ply", ".off", ".glb", ".gltf", ".3mf", ".dae")
GRIDS = (".npz", ".nrrd", ".nhdr", ".nii", ".gz", ".mha", ".mhd")
"""Endings of grids and volumes, by which a shape in one line is recognised."""


class Shape(Section):
    """A geometry in the fixture's frame F."""

    key: ClassVar[str]
    """key in scene files"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The geometry for the core. X_WF (4, 4) is the pose of F at the start; it converts places given in W.

        Raises:
            GuidanceError, MeshError, SurfaceError: a file, object or place is missing, or a value is invalid.
        """
        raise NotImplementedError


#: Keys in messages of the core, and their names in scene files.
_KEYS = {
    "law.K ": "law.stiffness ",
    "law.B ": "law.damping ",
    "law.K_turn ": "law.turning_stiffness ",
    "law.B_turn ": "law.turning_damping ",
    "law.range_turn ": "law.turning_range ",
    "role.angle ": "role.angle ",
}


def as_guidance_error(error: ValueError, where: str) -> GuidanceError:
    """Convert an error of the core, `guidance: fixture 'x'.key = value: mend` or `what; mend`, to a GuidanceError."""
    text = re.sub(r"^guidance: (fixture '[^']*'[.:]? ?)?", "", str(error))
    what, _, mend = text.partition("; ") if "; " in text else text.partition(": ")
    for core_key, scene_key in _KEYS.items():
        what = what.replace(core_key, scene_key)
    what = re.sub(r"-?\d+\.\d{6}", lambda number: f"{float(number[0]):g}", what)
    return GuidanceError(what, where=where, mend=mend)


def placed(geometry: _guidance.Geometry, X: Array) -> _guidance.Geometry:
    """The geometry placed at a pose X (4, 4) in F."""
    from palpate import _guidance

    return geometry if np.array_equal(X, np.eye(4)) else _guidance.PlacedGeometry(geometry, X)


class Point(Shape):
    """A point, for example a target or a trocar."""

    key: ClassVar[str] = "point"
    at: Place
    """position [m]"""
    rpy_deg: Vector = (0.0, 0.0, 0.0)
    """target attitude of `orient`: roll, pitch, yaw [deg]"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The point."""
        from palpate import _guidance

        X = PoseSection(rpy_deg=self.rpy_deg).matrix()
        X[:3, 3] = context.place(self.at, X_WF)
        return _guidance.PlacedGeometry(_guidance.PointGeometry(), X)


class Line(Shape):
    """A straight line between two places, or through both without end."""

    key: ClassVar[str] = "line"
    start: Place
    """one end [m]"""
    end: Place
    """the other end [m]"""
    endless: bool = False
    """true: the line continues beyond both ends"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The line."""
        from palpate import _guidance

        try:
            return _guidance.LineGeometry(context.place(self.start, X_WF), context.place(self.end, X_WF), self.endless)
        except ValueError as error:
            raise as_guidance_error(error, "line") from None


class Plane(Shape):
    """A plane; the inside is behind it, opposite to the normal."""

    key: ClassVar[str] = "plane"
    at: Place = (0.0, 0.0, 0.0)
    """a point on the plane [m]"""
    normal: Vector = (0.0, 0.0, 1.0)
    """outward normal of any length [-]"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The half-space."""
        from palpate import _guidance

        X = np.eye(4)
        X[:3, :3] = _rotation_z_to(self.normal, "normal of a plane")
        X[:3, 3] = context.place(self.at, X_WF)
        return _guidance.PlacedGeometry(_guidance.SurfaceGeometry(_core.Plane()), X)


class Cone(Shape):
    """A cone with its apex at the target; it opens towards the entry and continues beyond the entry."""

    key: ClassVar[str] = "cone"
    entry: Place
    """entry, a point on the axis [m]"""
    target: Place
    """apex [m]"""
    half_angle_deg: Annotated[Number, Field(gt=0.0, le=90.0)] = float(np.degrees(_core.CONE_HALF_ANGLE))
    """angle between axis and side [deg]"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The cone."""
        from palpate import _guidance

        target, entry = context.place(self.target, X_WF), context.place(self.entry, X_WF)
        try:
            return _guidance.ConeGeometry(target, entry - target, float(np.radians(self.half_angle_deg)))
        except ValueError as error:
            raise as_guidance_error(error, "cone") from None


class Sphere(Shape):
    """A solid sphere."""

    key: ClassVar[str] = "sphere"
    radius: Positive
    """radius [m]"""
    at: Place = (0.0, 0.0, 0.0)
    """centre [m]"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The sphere."""
        from palpate import _guidance

        X = np.eye(4)
        X[:3, 3] = context.place(self.at, X_WF)
        return placed(_guidance.SurfaceGeometry(_core.Sphere(self.radius)), X)


class Box(Shape):
    """A solid box."""

    key: ClassVar[str] = "box"
    size: tuple[Positive, Positive, Positive]
    """side lengths [m]"""
    pose: PoseSection = PoseSection()
    """pose of the centre and axes"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The box."""
        from palpate import _guidance

        return placed(_guidance.SurfaceGeometry(_core.Box(np.array(self.size))), self.pose.matrix())


class Cylinder(Shape):
    """A solid cylinder with flat ends; its axis is the z axis of its pose."""

    key: ClassVar[str] = "cylinder"
    radius: Positive
    """radius [m]"""
    length: Positive
    """length from end to end [m]"""
    pose: PoseSection = PoseSection()
    """pose of the centre and axis"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The cylinder."""
        from palpate import _guidance

        return placed(_guidance.SurfaceGeometry(_core.Cylinder(self.radius, self.length)), self.pose.matrix())


class Mesh(Shape):
    """A triangle mesh from a file; only a closed mesh has an inside."""

    key: ClassVar[str] = "mesh"
    file: str
    """STL, OBJ, PLY, ..., relative to the scene file; ${VARIABLE} is replaced"""
    unit: Unit | None = None
    """unit of the numbers in the file; when left out that of the file or its format, otherwise mm"""
    pose: PoseSection = PoseSection()
    """pose of the file's own frame"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The mesh, open or closed."""
        from palpate import _guidance
        from palpate.world.mesh import Mesh as Triangles

        triangles = Triangles.load(context.file(self.file), self.unit)
        return placed(_guidance.SurfaceGeometry(triangles.core), self.pose.matrix())


class Cloud(Shape):
    """Points from a file; each point is the centre of a ball."""

    key: ClassVar[str] = "cloud"
    file: str
    """file with x, y, z in each row (.csv, .xyz, .txt), or a mesh file (its vertices); relative to the scene file"""
    radius: Positive
    """radius of the balls; about the spacing of the points, which leaves no gaps [m]"""
    unit: Unit = "mm"
    """unit of the numbers in the file, unless a header names the unit (x_m, y_m, z_m)"""
    pose: PoseSection = PoseSection()
    """pose of the file's own frame"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The cloud."""
        from palpate import _guidance
        from palpate.base.values.units import FILE_UNITS
        from palpate.scene.guidance.files import read_rows
        from palpate.world.mesh import files as mesh_files

        file = context.file(self.file)
        if file.suffix.lower() in MESHES:
            points, _, stated = mesh_files.read_with_unit(file)
            unit = self.unit if "unit" in self.model_fields_set else stated or self.unit
            points = np.asarray(points, dtype=np.float64) * FILE_UNITS[unit]
        else:
            points = read_rows(file, self.unit)[0]
        try:
            core = _core.Cloud(np.ascontiguousarray(points), self.radius)
        except ValueError as error:
            raise as_guidance_error(error, str(file)) from None
        return placed(_guidance.SurfaceGeometry(core), self.pose.matrix())


class Grid(Shape):
    """A signed distance grid from a file, or computed from a closed mesh file."""

    key: ClassVar[str] = "grid"
    file: str
    """grid file, .npz or a volume of distances, or a mesh or segmentation; relative to the scene file"""
    spacing: Positive | None = None
    """spacing of the nodes of a grid made from a mesh; a hundredth of the mesh's size when left out [m]"""
    unit: Unit = "mm"
    """unit of the numbers in the file, unless the file names it"""
    pose: PoseSection = PoseSection()
    """pose of the file's own frame"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The grid."""
        from palpate import _guidance
        from palpate.world.mesh import Mesh as Triangles
        from palpate.world.mesh.volume_files import is_volume
        from palpate.world.surfaces import DistanceGrid, volume_grid

        file = context.file(self.file)
        if file.suffix.lower() == ".npz" or (is_volume(file) and volume_grid.holds_distances(file)):
            grid = DistanceGrid.load(file, self.unit)
        else:
            mesh = Triangles.load(file, self.unit if "unit" in self.model_fields_set else None)
            grid = DistanceGrid.from_mesh(mesh, self.spacing or float(np.ptp(mesh.bounds, axis=0).max()) / 100.0)
        return placed(_guidance.SurfaceGeometry(grid.core), self.pose.matrix())


class OfObject(Shape):
    """The surface of an object of the scene. Set the fixture's frame to the same object, so that both move together."""

    key: ClassVar[str] = "object"
    name: str
    """name of the object"""

    def make(self, context: FixtureContext, X_WF: Array) -> _guidance.Geometry:
        """The surface of the object, in the object's frame."""
        from palpate import _guidance

        return _guidance.SurfaceGeometry(context.body(self.name).core)


def _rotation_z_to(z: Any, name: str) -> Array:
    """A rotation (3, 3) whose z axis points along a vector (3,) of any length."""
    from palpate.scene.guidance.curve import frames_along

    vector = np.array(z, dtype=np.float64)
    if not np.linalg.norm(vector) > 1e-9:
        raise SurfaceError(f"{name} must be longer than zero, got {z}", mend="e.g. [0, 0, 1]")
    return np.asarray(frames_along(np.zeros((1, 3)), vector[None])[0])
