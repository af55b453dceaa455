"""What a fixture is made of, as scene files name it and Python makes it; the core answers (geometry.hpp)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from palpate import _core
from palpate.arrays import Array
from palpate.errors import GuidanceError, SurfaceError
from palpate.guidance.here import Here
from palpate.values import Number, Place, PositiveLength, Section, Vector
from palpate.values import Pose as PoseSection

Unit = Literal["mm", "cm", "m", "in"]

MESHES = (".stl", ".obj", ".ply", ".off", ".glb", ".gltf", ".3mf", ".dae")
GRIDS = (".npz", ".nrrd")


class Shape(Section):
    """A geometry in the fixture's frame F."""

    key: ClassVar[str]
    """how scene files call it"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """What the core asks; X_WF (4, 4): F at the start, for places that are named in W.

        Raises:
            GuidanceError, MeshError, SurfaceError: what it names is not there, or cannot be.
        """
        raise NotImplementedError


#: How scene files call what the core calls otherwise.
_KEYS = {
    "law.K ": "law.stiffness ",
    "law.B ": "law.damping ",
    "law.K_turn ": "law.turning_stiffness ",
    "law.B_turn ": "law.turning_damping ",
    "law.range_turn ": "law.turning_range ",
    "role.angle ": "role.angle ",
}


def refused(error: ValueError, where: str) -> GuidanceError:
    """The core's words as an error of ours: `guidance: fixture 'x'.key = value: mend`, or `what; mend`."""
    text = re.sub(r"^guidance: (fixture '[^']*'[.:]? ?)?", "", str(error))
    what, _, mend = text.partition("; ") if "; " in text else text.partition(": ")
    for core, ours in _KEYS.items():
        what = what.replace(core, ours)
    what = re.sub(r"-?\d+\.\d{6}", lambda number: f"{float(number[0]):g}", what)
    return GuidanceError(what, where=where, mend=mend)


def placed(geometry: _core.Geometry, X: Array) -> _core.Geometry:
    """The geometry at a pose in F."""
    return geometry if np.array_equal(X, np.eye(4)) else _core.PlacedGeometry(geometry, X)


class Point(Shape):
    """A place: a target, a trocar."""

    key: ClassVar[str] = "point"
    at: Place
    """where [m]"""
    rpy_deg: Vector = (0.0, 0.0, 0.0)
    """the attitude that `orient` turns the tool to: roll, pitch, yaw [deg]"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The place."""
        X = PoseSection(rpy_deg=self.rpy_deg).matrix()
        X[:3, 3] = here.place(self.at, X_WF)
        return _core.PlacedGeometry(_core.PointGeometry(), X)


class Line(Shape):
    """A straight line between two places, or endless through both."""

    key: ClassVar[str] = "line"
    start: Place
    """one end [m]"""
    end: Place
    """the other [m]"""
    endless: bool = False
    """it goes on through both"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The line."""
        try:
            return _core.LineGeometry(here.place(self.start, X_WF), here.place(self.end, X_WF), self.endless)
        except ValueError as error:
            raise refused(error, "line") from None


class Plane(Shape):
    """A plane; inside is behind it."""

    key: ClassVar[str] = "plane"
    at: Place = (0.0, 0.0, 0.0)
    """a place on it [m]"""
    normal: Vector = (0.0, 0.0, 1.0)
    """points outwards, any length [-]"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The half-space."""
        X = np.eye(4)
        X[:3, :3] = _turned_to(self.normal, "normal of a plane")
        X[:3, 3] = here.place(self.at, X_WF)
        return _core.PlacedGeometry(_core.SurfaceGeometry(_core.Plane()), X)


class Cone(Shape):
    """The way from an entry to a target: a cone with its apex at the target, open at the entry and beyond."""

    key: ClassVar[str] = "cone"
    entry: Place
    """where it is entered [m]"""
    target: Place
    """its apex [m]"""
    half_angle_deg: Annotated[Number, Field(gt=0.0, le=90.0)] = float(np.degrees(_core.CONE_HALF_ANGLE))
    """between its axis and its side [deg]"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The cone."""
        target, entry = here.place(self.target, X_WF), here.place(self.entry, X_WF)
        try:
            return _core.ConeGeometry(target, entry - target, float(np.radians(self.half_angle_deg)))
        except ValueError as error:
            raise refused(error, "cone") from None


class Sphere(Shape):
    """A ball."""

    key: ClassVar[str] = "sphere"
    radius: PositiveLength
    """of the ball [m]"""
    at: Place = (0.0, 0.0, 0.0)
    """its centre [m]"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The ball."""
        X = np.eye(4)
        X[:3, 3] = here.place(self.at, X_WF)
        return placed(_core.SurfaceGeometry(_core.Sphere(self.radius)), X)


class Box(Shape):
    """A box."""

    key: ClassVar[str] = "box"
    size: tuple[PositiveLength, PositiveLength, PositiveLength]
    """its sides [m]"""
    pose: PoseSection = PoseSection()
    """of its middle and axes"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The box."""
        return placed(_core.SurfaceGeometry(_core.Box(np.array(self.size))), self.pose.matrix())


class Cylinder(Shape):
    """A cylinder with flat ends, around the z axis of its pose."""

    key: ClassVar[str] = "cylinder"
    radius: PositiveLength
    """of the cylinder [m]"""
    length: PositiveLength
    """from end to end [m]"""
    pose: PoseSection = PoseSection()
    """of its middle and axis"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The cylinder."""
        return placed(_core.SurfaceGeometry(_core.Cylinder(self.radius, self.length)), self.pose.matrix())


class Mesh(Shape):
    """A surface of triangles from a file; inside and outside need it closed."""

    key: ClassVar[str] = "mesh"
    file: str
    """STL, OBJ, PLY, ..., relative to the scene file; ${VARIABLE} is replaced"""
    unit: Unit = "mm"
    """of the numbers in the file"""
    pose: PoseSection = PoseSection()
    """of the file's own frame"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The mesh, open or closed."""
        from palpate.mesh import Mesh as Triangles

        return placed(_core.SurfaceGeometry(Triangles.load(here.file(self.file), self.unit).core), self.pose.matrix())


class Cloud(Shape):
    """Points from a file, each with a ball around it."""

    key: ClassVar[str] = "cloud"
    file: str
    """x, y, z a row (.csv, .xyz, .txt), or the vertices of a mesh file; relative to the scene file"""
    radius: PositiveLength
    """of the balls: about the spacing of the points, so that no gap is left [m]"""
    unit: Unit = "mm"
    """of the numbers in the file, unless a header names it (x_m, y_m, z_m)"""
    pose: PoseSection = PoseSection()
    """of the file's own frame"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The cloud."""
        from palpate.guidance.files import read_rows
        from palpate.mesh import files as mesh_files
        from palpate.mesh.check import UNITS

        file = here.file(self.file)
        if file.suffix.lower() in MESHES:
            points = np.asarray(mesh_files.read(file)[0], dtype=np.float64) * UNITS[self.unit]
        else:
            points = read_rows(file, self.unit)[0]
        try:
            core = _core.Cloud(np.ascontiguousarray(points), self.radius)
        except ValueError as error:
            raise refused(error, str(file)) from None
        return placed(_core.SurfaceGeometry(core), self.pose.matrix())


class Grid(Shape):
    """A signed distance grid from a file, or made from a closed mesh file on the spot."""

    key: ClassVar[str] = "grid"
    file: str
    """.npz or .nrrd (`palpate grid MESH` makes one), or a mesh file; relative to the scene file"""
    spacing: PositiveLength | None = None
    """of the nodes, when it is made from a mesh; a hundredth of the mesh when left out [m]"""
    unit: Unit = "mm"
    """of the numbers in the file, unless the file says it"""
    pose: PoseSection = PoseSection()
    """of the file's own frame"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """The grid."""
        from palpate.mesh import Mesh as Triangles
        from palpate.surfaces import DistanceGrid

        file = here.file(self.file)
        if Path(self.file).suffix.lower() in GRIDS:
            grid = DistanceGrid.load(file, self.unit)
        else:
            mesh = Triangles.load(file, self.unit)
            grid = DistanceGrid.from_mesh(mesh, self.spacing or float(np.ptp(mesh.bounds, axis=0).max()) / 100.0)
        return placed(_core.SurfaceGeometry(grid.core), self.pose.matrix())


class OfObject(Shape):
    """The surface of an object of the scene, wherever it goes: set the fixture's frame to the object, too."""

    key: ClassVar[str] = "object"
    name: str
    """of the object"""

    def make(self, here: Here, X_WF: Array) -> _core.Geometry:
        """Its surface, in its own frame."""
        return _core.SurfaceGeometry(here.body(self.name).core)


def _turned_to(z: Any, name: str) -> Array:
    """A rotation with its z along a vector of any length."""
    from palpate.guidance.curve import frames_along

    vector = np.array(z, dtype=np.float64)
    if not np.linalg.norm(vector) > 1e-9:
        raise SurfaceError(f"{name} must be longer than zero, got {z}", mend="e.g. [0, 0, 1]")
    return np.asarray(frames_along(np.zeros((1, 3)), vector[None])[0])
