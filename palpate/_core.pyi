# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""
Palpate's C++ core: the stages of the haptic cycle (see ARCHITECTURE.md).
"""

from collections.abc import Mapping as _Mapping, Sequence
from typing import Annotated, Any, Literal, overload

import numpy
import numpy.typing
from numpy.typing import NDArray


class Surface:
    """What can be touched: meshes, primitives, fields."""

    def nearest(
        self,
        points: Annotated[NDArray[numpy.float64], "(:, 3)"],
    ) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]]:
        """
        points (n, 3) [m] -> signed distance (n,) (unsigned when open), point (n, 3), outward normal (n, 3).
        """

class MeshReport:
    """What was found and done while a mesh was built."""

    @property
    def vertices(self) -> int:
        """after welding"""

    @property
    def triangles(self) -> int:
        """kept"""

    @property
    def degenerate(self) -> int:
        """dropped: a corner repeated, or three on a line"""

    @property
    def duplicate(self) -> int:
        """dropped: the same corners in the same turn"""

    @property
    def flat(self) -> int:
        """kept: three corners on a line, closing a gap"""

    @property
    def parts(self) -> int:
        """connected by vertices"""

    @property
    def boundary_edges(self) -> int:
        """of one triangle only"""

    @property
    def branching_edges(self) -> int:
        """of three triangles or more"""

    @property
    def inconsistent_edges(self) -> int:
        """whose triangles are wound against each other"""

    @property
    def turned(self) -> int:
        """triangles that faced the other way than their neighbours"""

    @property
    def inverted(self) -> int:
        """triangles of closed parts that were inside out: turned"""

    @property
    def two_sided(self) -> bool:
        """no part is a Moebius strip or alike"""

    @property
    def closed(self) -> bool:
        """no boundary, branching or inconsistent edges"""

    @property
    def volume(self) -> float:
        """of the closed parts [m^3]"""

    @property
    def lowest(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """corner of the bounding box [m]"""

    @property
    def highest(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """corner of the bounding box [m]"""

class Mesh(Surface):
    """
    Triangles ready to be touched: welded, with normals, adjacency and a BVH.
    """

    def __init__(
        self,
        vertices: Annotated[NDArray[numpy.float64], "(:, 3)"],
        triangles: Annotated[NDArray[numpy.int32], "(:, 3)"],
    ) -> None:
        """
        vertices (n, 3) [m], triangles (m, 3) int32; ValueError when they are no mesh.
        """

    @property
    def triangle_count(self) -> int: ...

    @property
    def report(self) -> MeshReport: ...

    @property
    def vertices(self) -> Annotated[NDArray[numpy.float64], "read-only"]:
        """welded, (n, 3) [m], read-only"""

    @property
    def triangles(self) -> Annotated[NDArray[numpy.int32], "read-only"]:
        """of welded vertices, (m, 3), read-only"""

    def rims(self) -> NDArray[numpy.int32]:
        """edges of one triangle only: (k, 2) vertices, in the triangle's turn"""

    def closest(
        self,
        points: Annotated[NDArray[numpy.float64], "(:, 3)"],
        max_distance: float = float('inf'),
    ) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.int32]]:
        """
        points (n, 3) [m] -> distance (n,), point (n, 3), normal (n, 3), triangle (n,); inf and -1 beyond it.
        """

    def sweep(
        self,
        a: Annotated[NDArray[numpy.float64], "(3,)"],
        b: Annotated[NDArray[numpy.float64], "(3,)"],
        radius: float,
    ) -> float:
        """
        How far [m] a sphere goes from a towards b before a triangle is nearer than radius to its centre.
        """

    def closest_by_kernel(
        self,
        points: Annotated[NDArray[numpy.float64], "(:, 3)"],
        kernel: str,
    ) -> NDArray[numpy.float64]:
        """Distances (n,) by the kernel 'avx2' or 'portable' (tests)."""

    def contains(self, points: Annotated[NDArray[numpy.float64], "(:, 3)"]) -> NDArray[numpy.bool_]:
        """points (n, 3) -> inside of the closed mesh (n,); False if open."""

class Plane(Surface):
    """The half-space z <= 0."""

    def __init__(self) -> None: ...

class Sphere(Surface):
    """Around the origin."""

    def __init__(self, radius: float) -> None: ...

class Box(Surface):
    """Around the origin, along the axes."""

    def __init__(self, size: Annotated[NDArray[numpy.float64], "(3,)"]) -> None: ...

class Cylinder(Surface):
    """Around the z axis, flat ends, middle at the origin."""

    def __init__(self, radius: float, length: float) -> None: ...

class Capsule(Surface):
    """All points within radius of a segment of the z axis."""

    def __init__(self, radius: float, length: float) -> None: ...

class Cloud(Surface):
    """All places within radius of a point of a cloud."""

    def __init__(self, points: Annotated[NDArray[numpy.float64], "(:, 3)"], radius: float) -> None:
        """points (n, 3) [m], radius [m]."""

class ImplicitSurface(Surface):
    """a x^m + b y^n + c z^o = level (Eq 14)."""

    def __init__(
        self,
        coefficients: Annotated[NDArray[numpy.float64], "(3,)"],
        exponents: Sequence[int],
        level: float,
    ) -> None: ...

    def value(self, p: Annotated[NDArray[numpy.float64], "(3,)"]) -> float:
        """U(p) - level."""

    def gradient(self, p: Annotated[NDArray[numpy.float64], "(3,)"]) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """grad U (3,) (Eq 15) [1/m]."""

    @property
    def half(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """half of its size along each axis (3,) [m]"""

class DistanceGrid(Surface):
    """A sampled signed distance, tricubic."""

    def __init__(
        self,
        origin: Annotated[NDArray[numpy.float64], "(3,)"],
        spacing: Annotated[NDArray[numpy.float64], "(3,)"],
        values: Annotated[NDArray[numpy.float32], "(:, :, :)"],
    ) -> None:
        """
        origin, spacing (3,) [m]; values (nx, ny, nz) float32 [m]; ValueError when they are no distance.
        """

    def value(
        self,
        p: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> tuple[float, Annotated[NDArray[numpy.float64], "(3,)"]]:
        """The sampled function and its gradient at p (3,)."""

    @property
    def values(self) -> Annotated[NDArray[numpy.float32], "read-only"]:
        """(nx, ny, nz) float32 [m], read-only"""

def sample_distance(
    mesh: Mesh,
    origin: Annotated[NDArray[numpy.float64], "(3,)"],
    spacing: Annotated[NDArray[numpy.float64], "(3,)"],
    values: Annotated[NDArray[numpy.float32], "(:, :, :)"],
) -> None:
    """
    Fills values (nx, ny, nz) float32 with a mesh's signed distance at origin + (i, j, k) * spacing, both (3,) [m].
    """

CREASE_ANGLE: float = 0.52

def bvh_has_avx2() -> bool:
    """This machine runs the AVX2 kernel."""

class Material:
    """How an object feels: diagonal K and B along the axes of W, friction."""

    def __init__(
        self,
        K: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        B: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        mu: float = 0.0,
        mu_static: float = 0.0,
    ) -> None: ...

    @property
    def K(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """stiffness [N/m]"""

    @K.setter
    def K(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def B(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """damping [N s/m]"""

    @B.setter
    def B(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def mu(self) -> float:
        """Coulomb friction coefficient while it slips [-]"""

    @mu.setter
    def mu(self, arg: float, /) -> None: ...

    @property
    def mu_static(self) -> float:
        """while it sticks; below mu: as mu [-]"""

    @mu_static.setter
    def mu_static(self, arg: float, /) -> None: ...

class Region:
    """
    Part of an object that feels otherwise: a box with round edges, or a ball.
    """

    def __init__(
        self,
        centre: Annotated[NDArray[numpy.float64], "(3,)"],
        half: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        radius: float = 0.0,
        blend: float = 0.001,
        material: Material = ...,
    ) -> None: ...

    @property
    def centre(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """in O [m]"""

    @property
    def half(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """half the lengths of the box; zero: a ball [m]"""

    @property
    def radius(self) -> float:
        """of the ball, or of the round edges [m]"""

    @property
    def blend(self) -> float:
        """fades over [m]"""

    @property
    def material(self) -> Material: ...

    def weight(self, p_O: Annotated[NDArray[numpy.float64], "(3,)"]) -> float:
        """1 inside, 0 further away than `blend`."""

class Wave:
    """A sinusoid of a Motion."""

    def __init__(
        self,
        shift: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        turn: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        period: float = 1.0,
        phase: float = 0.0,
    ) -> None: ...

class Motion:
    """
    How an object moves: a steady velocity plus sinusoids, from where it rests.
    """

    def __init__(
        self,
        v: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        w: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        waves: Sequence[Wave] = [],
        about: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
    ) -> None: ...

class Object:
    """
    A surface at a pose, made of a material, with regions that feel otherwise.
    """

    def __init__(
        self,
        name: str,
        surface: Surface,
        X_WO: Annotated[NDArray[numpy.float64], "(4, 4)"] = ...,
        material: Material = ...,
        regions: Sequence[Region] = [],
        motion: Motion = ...,
        is_virtual: bool = True,
        is_real: bool = True,
    ) -> None:
        """
        is_virtual: the contact stage feels it; is_real: the tool of a driven follower bumps into it.
        """

    @property
    def name(self) -> str: ...

    @property
    def surface(self) -> Surface: ...

    @property
    def X_WO(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """pose in W at rest, 4x4"""

    @X_WO.setter
    def X_WO(self, arg: Annotated[NDArray[numpy.float64], "(4, 4)"], /) -> None: ...

    @property
    def material(self) -> Material: ...

    @material.setter
    def material(self, arg: Material, /) -> None: ...

    def pose(self, t: float) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """X_WO at t [s], 4x4."""

    def velocity(
        self,
        p_W: Annotated[NDArray[numpy.float64], "(3,)"],
        t: float,
    ) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Of its material point that is at p_W at t [m/s]."""

    def feel(
        self,
        p_O: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> tuple[Material, Annotated[NDArray[numpy.float64], "(3, 3)"]]:
        """(material, gradients of K by row [N/m^2]) at p_O, in its frame."""

class Snapshot:
    """The world at one instant."""

    def __init__(self, objects: Sequence[Object]) -> None: ...

    @property
    def objects(self) -> list[Object]: ...

class ToolSphere:
    """A sphere of the tool beside the SPR on its tip."""

    def __init__(
        self,
        p: Annotated[NDArray[numpy.float64], "(3,)"],
        radius: float,
        link: int = -1,
        hinge: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        turn: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
    ) -> None: ...

    @property
    def p(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """centre in the link's frame, jaws closed [m]"""

    @property
    def radius(self) -> float:
        """[m]"""

    @property
    def link(self) -> int:
        """of the follower, by number; below zero the tool tip T"""

    def centre(self, jaw: float) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """In the link's frame with the jaws open by `jaw` [rad]."""

class ContactOptions:
    """The spherical proxy region on the tool tip."""

    def __init__(self) -> None: ...

    @property
    def radius(self) -> float:
        """of the SPR [m]"""

    @radius.setter
    def radius(self, arg: float, /) -> None: ...

    @property
    def release(self) -> float:
        """
        `proxy`: deflection at which a tool that went through a closed object is free [m]
        """

    @release.setter
    def release(self, arg: float, /) -> None: ...

    @property
    def collision_rate(self) -> float:
        """of the collision thread of the paper's methods [Hz]"""

    @collision_rate.setter
    def collision_rate(self, arg: float, /) -> None: ...

    @property
    def real(self) -> bool:
        """touches the objects that are real, in place of the virtual ones"""

    @real.setter
    def real(self, arg: bool, /) -> None: ...

    @property
    def spheres(self) -> list[ToolSphere]:
        """of the tool beside the SPR; a copy: assign it whole"""

    @spheres.setter
    def spheres(self, arg: Sequence[ToolSphere], /) -> None: ...

class Friction:
    """Coulomb friction of one proxy, which sticks and slips."""

    def __init__(self) -> None: ...

    def step(
        self,
        p: Annotated[NDArray[numpy.float64], "(3,)"],
        normal: Annotated[NDArray[numpy.float64], "(3,)"],
        depth: float,
        mu: float,
        mu_static: float,
    ) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """
        Proxy without friction, unit normal, depth [m], coefficients -> lag (3,) [m].
        """

    @property
    def slipping(self) -> bool: ...

MAX_SPHERES: int = 16

def contact_methods() -> list[str]:
    """Names of the contact methods there are; the default first."""

def contact_check(method: str, options: ContactOptions, snapshot: Snapshot) -> None:
    """
    ValueError when there is no such method, or it cannot feel an object of the scene.
    """

def grow_plane(
    points: Annotated[NDArray[numpy.float64], "(:, 3)"],
    n_last: Annotated[NDArray[numpy.float64], "(3,)"],
    baseline: float,
) -> Annotated[NDArray[numpy.float64], "(3,)"]:
    """
    Normal (3,) of the plane that `paper-plane` grows through points (n, 3) [m]; zero where it refuses.
    """

def contact_render(
    snapshot: Snapshot,
    tips: Annotated[NDArray[numpy.float64], "(:, 3)"],
    method: str,
    options: ContactOptions,
    rate: float,
    poses: Annotated[NDArray[numpy.float64], "(:, 4, 4)"] | None = None,
) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], bool, NDArray[numpy.float64]]:
    """
    A tool path p_WT (n, 3) [m] at `rate` [Hz] through contact and force -> force, normal, depth, proxy, latency,
    started_inside, torque. poses: X_WO (n, 4, 4) of the only object.
    """

def trace_algorithm1(
    snapshot: Snapshot,
    p_WT: Annotated[NDArray[numpy.float64], "(3,)"],
    v_WT: Annotated[NDArray[numpy.float64], "(3,)"],
    radius: float,
    n_last: Annotated[NDArray[numpy.float64], "(3,)"],
) -> dict[str, Any]:
    """Every line of Algorithm 1 for one tool position; all in W, SI units."""

class SoakRange:
    """What the passes are drawn from."""

    def __init__(self) -> None: ...

    @property
    def radius_min(self) -> float:
        """SPR [m]"""

    @radius_min.setter
    def radius_min(self, arg: float, /) -> None: ...

    @property
    def radius_max(self) -> float:
        """SPR [m]"""

    @radius_max.setter
    def radius_max(self, arg: float, /) -> None: ...

    @property
    def speed_min(self) -> float:
        """of the tool [m/s]"""

    @speed_min.setter
    def speed_min(self, arg: float, /) -> None: ...

    @property
    def speed_max(self) -> float:
        """of the tool [m/s]"""

    @speed_max.setter
    def speed_max(self, arg: float, /) -> None: ...

    @property
    def depth(self) -> float:
        """beyond the surface, at most [m]"""

    @depth.setter
    def depth(self, arg: float, /) -> None: ...

    @property
    def drag(self) -> float:
        """afterwards, in any direction, at most [m]"""

    @drag.setter
    def drag(self, arg: float, /) -> None: ...

    @property
    def angle(self) -> float:
        """from the normal, at most [rad]"""

    @angle.setter
    def angle(self, arg: float, /) -> None: ...

    @property
    def object_speed(self) -> float:
        """of the object, at most [m/s]"""

    @object_speed.setter
    def object_speed(self, arg: float, /) -> None: ...

class SoakPass:
    """One pass, as it was drawn."""

    @property
    def index(self) -> int: ...

    @property
    def radius(self) -> float:
        """[m]"""

    @property
    def speed(self) -> float:
        """[m/s]"""

    @property
    def depth(self) -> float:
        """[m]"""

    @property
    def object_moves(self) -> bool: ...

class SoakReport:
    """What many passes at one mesh gave."""

    @property
    def passes(self) -> int:
        """that found free space to begin in"""

    @property
    def ticks(self) -> int: ...

    @property
    def touched(self) -> int:
        """passes with a force"""

    @property
    def popped(self) -> int:
        """passes whose proxy crossed the surface"""

    @property
    def first_popped(self) -> SoakPass: ...

def soak(mesh: Mesh, method: str, passes: int, seed: int, range: SoakRange) -> SoakReport:
    """
    Random pokes at a mesh at 1 kHz, judged triangle by triangle; without the interpreter lock.
    """

class Geometry:
    """What a fixture is made of (core/palpate/guidance/geometry.hpp)."""

    @property
    def solid(self) -> bool:
        """it has an inside"""

    @property
    def has_axis(self) -> bool:
        """it has an axis to name: no point, ball or cloud"""

    def query(
        self,
        X_WT: Annotated[NDArray[numpy.float64], "(:, 4, 4)"],
        t: Annotated[NDArray[numpy.float64], "(:,)"],
    ) -> dict[str, Any]:
        """
        Poses (n, 4, 4) of a tool, times (n,) [s] -> arrays by the names of Query's fields, n of each.
        """

class Frame:
    """Where a geometry is attached."""

    def at(
        self,
        t: float,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(4, 4)"], Annotated[NDArray[numpy.float64], "(6,)"]]:
        """
        (X_WF 4x4, V_WF (6,): of its origin [m/s] over angular [rad/s]) at t [s].
        """

class MotionFrame(Frame):
    """Moves as an object of the scene does."""

    def __init__(self, X_WF: Annotated[NDArray[numpy.float64], "(4, 4)"] = ..., motion: Motion = ...) -> None: ...

class LiveFrame(Frame):
    """Is where it was last told to be."""

    def __init__(self) -> None: ...

    @overload
    def set(self, X_WF: Annotated[NDArray[numpy.float64], "(4, 4)"]) -> None:
        """Its velocity is found from pose to pose. One thread tells."""

    @overload
    def set(self, X_WF: Annotated[NDArray[numpy.float64], "(4, 4)"], V_WF: numpy.typing.ArrayLike) -> None: ...

    @property
    def told(self) -> bool:
        """it was told where it is"""

class PointGeometry(Geometry):
    """The origin of its frame."""

    def __init__(self) -> None: ...

class LineGeometry(Geometry):
    """From a to b, or endless through both."""

    def __init__(
        self,
        a: Annotated[NDArray[numpy.float64], "(3,)"],
        b: Annotated[NDArray[numpy.float64], "(3,)"],
        endless: bool = False,
    ) -> None: ...

class SurfaceGeometry(Geometry):
    """Whatever the scene can touch, in its own frame."""

    def __init__(self, surface: Surface) -> None: ...

class PathGeometry(Geometry):
    """A curve of cubic Bezier pieces."""

    def __init__(
        self,
        controls: Annotated[NDArray[numpy.float64], "(:, 4, 3)"],
        attitudes: Annotated[NDArray[numpy.float64], "(:, 3, 3)"],
        tangential: bool,
        closed: bool,
    ) -> None:
        """
        controls (n, 4, 3) [m]; attitudes (n + 1, 3, 3) at the pieces' ends, turning with the tangent or as given.
        """

    @property
    def length(self) -> float:
        """[m]"""

CONE_HALF_ANGLE: float = 0.2617993877991494

class ConeGeometry(Geometry):
    """A cone without an end."""

    def __init__(
        self,
        apex: Annotated[NDArray[numpy.float64], "(3,)"],
        axis: Annotated[NDArray[numpy.float64], "(3,)"],
        half_angle: float,
    ) -> None:
        """axis: from the apex into the cone; half_angle [rad]."""

class OffsetGeometry(Geometry):
    """Everything within a margin of a geometry."""

    def __init__(self, geometry: Geometry, margin: float) -> None: ...

class CombinedGeometry(Geometry):
    """A union, an intersection or a difference."""

    def __init__(
        self,
        kind: Literal['union', 'intersection', 'difference'],
        parts: Sequence[Geometry],
        blend: float = 0.0,
    ) -> None:
        """
        kind: union, intersection, or difference (the first without the others); blend: of the crease [m].
        """

class PlacedGeometry(Geometry):
    """A geometry at X_FG in a frame; in W when left out."""

    def __init__(
        self,
        geometry: Geometry,
        X_FG: Annotated[NDArray[numpy.float64], "(4, 4)"] = ...,
        frame: Frame = ...,
    ) -> None: ...

class GuidanceRoleOptions:
    """Of all roles of guidance; each reads what concerns it."""

    def __init__(self) -> None: ...

    @property
    def margin(self) -> float:
        """guide: free play; forbid, keep-in: kept clear [m]"""

    @margin.setter
    def margin(self, arg: float, /) -> None: ...

    @property
    def angle(self) -> float:
        """orient: free tilt [rad]"""

    @angle.setter
    def angle(self, arg: float, /) -> None: ...

    @property
    def axis(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """orient, rcm: of the tool, in T, what points or slides (3,)"""

    @axis.setter
    def axis(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def target(self) -> Literal['axis', 'normal', 'frame']:
        """orient: 'axis', 'normal' or 'frame' of the geometry"""

    @target.setter
    def target(self, name: Literal['axis', 'normal', 'frame'], /) -> None: ...

    @property
    def speed(self) -> float:
        """limit: of the tool, 0: none [m/s]"""

    @speed.setter
    def speed(self, arg: float, /) -> None: ...

    @property
    def force(self) -> float:
        """limit: of what it touches on the tool, 0: none [N]"""

    @force.setter
    def force(self, arg: float, /) -> None: ...

class GuidanceLawOptions:
    """Of all laws of guidance; each reads what concerns it."""

    def __init__(self) -> None: ...

    @property
    def K(self) -> float:
        """stiffness, on the tool's side [N/m]"""

    @K.setter
    def K(self, arg: float, /) -> None: ...

    @property
    def B(self) -> float:
        """damping [N s/m]"""

    @B.setter
    def B(self, arg: float, /) -> None: ...

    @property
    def K_turn(self) -> float:
        """of an angle [N m/rad]"""

    @K_turn.setter
    def K_turn(self, arg: float, /) -> None: ...

    @property
    def B_turn(self) -> float:
        """of an angle [N m s/rad]"""

    @B_turn.setter
    def B_turn(self, arg: float, /) -> None: ...

    @property
    def force(self) -> float:
        """potential, optimise: most that it pulls [N]"""

    @force.setter
    def force(self, arg: float, /) -> None: ...

    @property
    def moment(self) -> float:
        """the same of an angle [N m]"""

    @moment.setter
    def moment(self, arg: float, /) -> None: ...

    @property
    def range(self) -> float:
        """potential: attracts or repels from so far [m]"""

    @range.setter
    def range(self, arg: float, /) -> None: ...

    @property
    def range_turn(self) -> float:
        """the same of an angle [rad]"""

    @range_turn.setter
    def range_turn(self, arg: float, /) -> None: ...

    @property
    def ratio(self) -> float:
        """admittance: speed across what is free per speed along it, 0.01-1"""

    @ratio.setter
    def ratio(self, arg: float, /) -> None: ...

class Ramp:
    """Fades with what is measured: 0 at `start`, 1 at `end`."""

    def __init__(self, by: str = 'pedal', start: float = 0.0, end: float = 1.0) -> None: ...

    @property
    def by(self) -> str:
        """
        'pedal' [0-1], 'distance' [m, rad], 'time' since it was engaged [s], 'force' of the operator [N]
        """

    @property
    def start(self) -> float: ...

    @property
    def end(self) -> float: ...

class Policy:
    """How much of a fixture counts."""

    def __init__(self) -> None: ...

    @property
    def hard(self) -> bool:
        """the tool's goal is corrected as well"""

    @hard.setter
    def hard(self, arg: bool, /) -> None: ...

    @property
    def authority(self) -> float:
        """0-1, times the ramps"""

    @authority.setter
    def authority(self, arg: float, /) -> None: ...

    @property
    def priority(self) -> int:
        """a lower one never pulls against a higher one"""

    @priority.setter
    def priority(self, arg: int, /) -> None: ...

    @property
    def engage(self) -> float:
        """takes part once |gap| is below [m, rad]"""

    @engage.setter
    def engage(self, arg: float, /) -> None: ...

    @property
    def release(self) -> float:
        """until it is above [m, rad]"""

    @release.setter
    def release(self, arg: float, /) -> None: ...

    @property
    def rise(self) -> float:
        """shortest time for its authority from 0 to 1 [s]"""

    @rise.setter
    def rise(self, arg: float, /) -> None: ...

    @property
    def fall(self) -> float:
        """and back [s]"""

    @fall.setter
    def fall(self, arg: float, /) -> None: ...

    @property
    def ramps(self) -> list[Ramp]:
        """a copy; assign it whole"""

    @ramps.setter
    def ramps(self, arg: Sequence[Ramp], /) -> None: ...

def guidance_roles() -> list[str]:
    """Names of the roles there are."""

def guidance_laws() -> list[str]:
    """Names of the laws there are."""

class Fixture:
    """
    A geometry, a role, a law and a policy (core/palpate/guidance/fixture.hpp).
    """

    def __init__(
        self,
        name: str,
        geometry: Geometry,
        role: str,
        role_options: GuidanceRoleOptions = ...,
        law: str = 'spring',
        law_options: GuidanceLawOptions = ...,
        policy: Policy = ...,
        on: bool = True,
        patience: float = float('inf'),
    ) -> None:
        """
        patience: a live frame that it is attached to told no longer ago than this, or it fades out [s].
        """

    @property
    def name(self) -> str: ...

    @property
    def role(self) -> str: ...

    @property
    def law(self) -> str: ...

    @property
    def policy(self) -> Policy: ...

    @property
    def on(self) -> bool: ...

    @property
    def stiffness(self) -> float:
        """the steepest of its law [N/m]"""

    @property
    def damping(self) -> float:
        """the most of its law [N s/m]"""

    @property
    def turning_stiffness(self) -> float:
        """[N m/rad]"""

    @property
    def turning_damping(self) -> float:
        """[N m s/rad]"""

    def ask(
        self,
        X_WT: Annotated[NDArray[numpy.float64], "(4, 4)"],
        t: float = 0.0,
        V_WT: numpy.typing.ArrayLike = ...,
        F_T_W: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        stiffness: float = 0.0,
    ) -> dict[str, Any]:
        """
        What its role wants of a tool at X_WT (4, 4) (gap, along (6,), drift, free (3, 3), attracts, turns, speed), and
        its law's answer to a motion V_WT (6,): wrench F (6,), energy U [J], damping B (3, 3) and the part F_of_B of F.
        Authority and other fixtures left aside.
        """

class Fixtures:
    """A list of fixtures: immutable, swapped whole."""

    def __init__(self, fixtures: Sequence[Fixture] = [], tool: LiveFrame | None = None) -> None:
        """tool: a frame that is told at every tick where the tool is."""

    def __len__(self) -> int: ...

    def list(self) -> list[Fixture]:
        """The fixtures, in their order."""

class GuidanceOptions:
    """Of the stage `guidance`."""

    def __init__(self) -> None: ...

    @property
    def force_rate(self) -> float:
        """of what no motion explains: a switch, an edit [N/s]"""

    @force_rate.setter
    def force_rate(self, arg: float, /) -> None: ...

    @property
    def moment_rate(self) -> float:
        """the same of moments [N m/s]"""

    @moment_rate.setter
    def moment_rate(self, arg: float, /) -> None: ...

    @property
    def return_speed(self) -> float:
        """of a goal that has to leave a region just forbidden [m/s]"""

    @return_speed.setter
    def return_speed(self, arg: float, /) -> None: ...

    @property
    def reserve(self) -> float:
        """hard fixtures keep the goal so far from the border [m]"""

    @reserve.setter
    def reserve(self, arg: float, /) -> None: ...

    @property
    def servo_bandwidth(self) -> float:
        """
        of the follower behind its goal; 0: at once; below zero: as simulated [Hz]
        """

    @servo_bandwidth.setter
    def servo_bandwidth(self, arg: float, /) -> None: ...

    @property
    def servo_damping(self) -> float:
        """of the same [-]"""

    @servo_damping.setter
    def servo_damping(self, arg: float, /) -> None: ...

class Guidance:
    """The stage `guidance` by itself."""

    def __init__(self, options: GuidanceOptions = ..., dt: float = 0.001) -> None: ...

    def take(self, fixtures: Fixtures) -> None:
        """From now on these."""

    def step(
        self,
        t: float,
        X_WT_goal: Annotated[NDArray[numpy.float64], "(4, 4)"],
        V_WT: numpy.typing.ArrayLike,
        X_WT: Annotated[NDArray[numpy.float64], "(4, 4)"],
        engaged: bool = True,
        F_T_W: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        stiffness: float = 0.0,
        F_hand: float = -1.0,
        pedal: float = 1.0,
        takes_damping: bool = False,
    ) -> dict[str, Any]:
        """
        One tick: X_WT_goal (4, 4), F_T_W (6,), B_W (3, 3), strongest, gap, correction (3,), status.
        """

    def authority(self, i: int) -> float:
        """Of fixture i, ramped."""

    def wrench(self, i: int) -> Annotated[NDArray[numpy.float64], "(6,)"]:
        """Of fixture i (6,)."""

    def gap(self, i: int) -> float:
        """Of fixture i [m, rad]."""

class Qp:
    """
    min |y - y0|^2 / 2 subject to A y >= b, in six variables (core/palpate/guidance/qp.hpp).
    """

    def __init__(self) -> None: ...

    def solve(
        self,
        A: Annotated[NDArray[numpy.float64], "(:, :)"],
        b: numpy.typing.ArrayLike,
        y0: numpy.typing.ArrayLike,
        ranks: Sequence[int] = [],
    ) -> dict[str, Any]:
        """
        y (6,), multipliers (m,), status 'solved', 'relaxed' or 'stopped', gave_way (m,), steps, and the index of each
        row (below zero: refused).
        """

def run_guidance(
    stage: Guidance,
    t: Sequence[float],
    X_WT_goal: Annotated[NDArray[numpy.float64], "(:, 4, 4)"],
    V_WT: Annotated[NDArray[numpy.float64], "(:, 6)"],
    X_WT: Annotated[NDArray[numpy.float64], "(4, 4)"],
    normal: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
    height: Sequence[float] = [],
    stiffness: float = 0.0,
    F_hand: float = -1.0,
    pedal: float = 1.0,
    takes_damping: bool = False,
) -> dict[str, NDArray[numpy.float64]]:
    """
    A Guidance along a motion, (n,) [s], (n, 4, 4), (n, 6): F_T_W (n, 6), X_WT_goal (n, 16), B_W (n, 9), gap (n,). The
    tool is where the last goal was, at first at X_WT (4, 4); below normal . p = height (n,) it touches a spring of
    stiffness [N/m].
    """

def time_query(
    geometry: Geometry,
    X_WT: Annotated[NDArray[numpy.float64], "(:, 4, 4)"],
) -> Annotated[NDArray[numpy.float64], "(:,)"]:
    """Each of n queries at poses (n, 4, 4) [us]."""

def time_guidance(
    fixtures: Fixtures,
    X_WT: Annotated[NDArray[numpy.float64], "(:, 4, 4)"],
    dt: float = 0.001,
) -> Annotated[NDArray[numpy.float64], "(:,)"]:
    """
    Each tick of the stage while the hand sends the tool along poses (n, 4, 4) [us].
    """

def time_qp(
    A: Annotated[NDArray[numpy.float64], "(:, :, 6)"],
    b: Annotated[NDArray[numpy.float64], "(:, :)"],
    y0: Annotated[NDArray[numpy.float64], "(:, :)"],
) -> Annotated[NDArray[numpy.float64], "(:,)"]:
    """
    Each of n programs of m rows: A (n, m, 6), b (n, m), y0 (n, 6), filling included [us].
    """

class MappingOptions:
    """From hand to tool and back."""

    def __init__(self) -> None: ...

    @property
    def scale(self) -> float:
        """tool motion per hand motion; felt stiffness = force_scale * scale * K"""

    @scale.setter
    def scale(self, arg: float, /) -> None: ...

    @property
    def force_scale(self) -> float:
        """force on the hand per force on the tool"""

    @force_scale.setter
    def force_scale(self, arg: float, /) -> None: ...

    @property
    def align_rate(self) -> float:
        """decay of an orientation offset [rad/s]; 0 keeps it"""

    @align_rate.setter
    def align_rate(self, arg: float, /) -> None: ...

    @property
    def gripper_min(self) -> float:
        """pinch of a closed jaw [rad]"""

    @gripper_min.setter
    def gripper_min(self, arg: float, /) -> None: ...

    @property
    def gripper_max(self) -> float:
        """pinch of an open jaw [rad]"""

    @gripper_max.setter
    def gripper_max(self, arg: float, /) -> None: ...

    @property
    def jaw_min(self) -> float:
        """closed [rad]"""

    @jaw_min.setter
    def jaw_min(self, arg: float, /) -> None: ...

    @property
    def jaw_max(self) -> float:
        """open [rad]"""

    @jaw_max.setter
    def jaw_max(self, arg: float, /) -> None: ...

    @property
    def jaw_rate(self) -> float:
        """how fast the jaw catches up with the pinch [rad/s]"""

    @jaw_rate.setter
    def jaw_rate(self, arg: float, /) -> None: ...

class Mapping:
    """
    Stage `mapping`: relative scaled position, absolute orientation, clutch, jaw.
    """

    def __init__(
        self,
        options: MappingOptions,
        R_WL: Annotated[NDArray[numpy.float64], "(3, 3)"],
        dt: float,
    ) -> None: ...

    def step(
        self,
        X_WH: Annotated[NDArray[numpy.float64], "(4, 4)"],
        v_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        gripper: float,
        X_WT: Annotated[NDArray[numpy.float64], "(4, 4)"],
        jaw: float = 0.0,
        following: bool = True,
        clutch: bool = False,
        reached: bool = True,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(4, 4)"], float, Annotated[NDArray[numpy.float64], "(3,)"], bool]:
        """One tick: (X_WT_goal, jaw, v_WT, engaged)."""

    def force_on_hand(
        self,
        F_T_W: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """F_H_L that renders F_T_W [N]."""

    def hand_position(
        self,
        p_WT: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """p_WH at which the tool goes to p_WT [m]."""

    @property
    def anchorings(self) -> int:
        """How often the map was caught anew."""

class MomentumObserver:
    """External joint torques from drive torques; see estimate.hpp."""

    def __init__(
        self,
        model: Arm,
        drive_inertia: Annotated[NDArray[numpy.float64], "(:, :)"],
        bandwidth: float,
    ) -> None:
        """drive_inertia (n,n) at the joints; bandwidth of r [Hz]."""

    def reset(self) -> None:
        """The next step starts at r = 0."""

    def run(
        self,
        q: Annotated[NDArray[numpy.float64], "(:, :)"],
        v: Annotated[NDArray[numpy.float64], "(:, :)"],
        tau: Annotated[NDArray[numpy.float64], "(:, :)"],
        rate: float,
    ) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """
        r (k, n) [N m, N] of k samples, `rate` a second; tau (k, n) without friction.
        """

class EstimateOptions:
    """Force on the tool from its drive torques."""

    def __init__(self) -> None: ...

    @property
    def bandwidth(self) -> float:
        """of the momentum observer [Hz]"""

    @bandwidth.setter
    def bandwidth(self, arg: float, /) -> None: ...

    @property
    def dead_band(self) -> float:
        """forces below it are not told [N]"""

    @dead_band.setter
    def dead_band(self, arg: float, /) -> None: ...

    @property
    def slip_speed(self) -> float:
        """of the speed limits: dry friction is full above it [-]"""

    @slip_speed.setter
    def slip_speed(self, arg: float, /) -> None: ...

    @property
    def rotor_inertia(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) [kg m^2, kg]"""

    @rotor_inertia.setter
    def rotor_inertia(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) [N m, N]"""

    @coulomb.setter
    def coulomb(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) [N m s/rad, N s/m]"""

    @viscous.setter
    def viscous(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def offset(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) constant torque of the drives [N m, N]"""

    @offset.setter
    def offset(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def spring(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) torque per position [N m/rad, N/m]"""

    @spring.setter
    def spring(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def links(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(10n,) identified inertial parameters; empty: the model's own"""

    @links.setter
    def links(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class Estimate:
    """Force of the environment on the tool tip, from the drives' torques."""

    def __init__(self, model: Arm, options: EstimateOptions) -> None: ...

    def reset(self) -> None: ...

    def step(
        self,
        t: float,
        q: Annotated[NDArray[numpy.float64], "(:,)"],
        v: Annotated[NDArray[numpy.float64], "(:,)"],
        tau: Annotated[NDArray[numpy.float64], "(:,)"],
    ) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """A state stamped t [s]: F_T_B (3,) [N]."""

def force(
    K: Annotated[NDArray[numpy.float64], "(:, 3)"],
    B: Annotated[NDArray[numpy.float64], "(:, 3)"],
    normal: Annotated[NDArray[numpy.float64], "(:, 3)"],
    delta_x: Annotated[NDArray[numpy.float64], "(:, 3)"],
    v_WT: Annotated[NDArray[numpy.float64], "(3,)"],
    v_surface: Annotated[NDArray[numpy.float64], "(:, 3)"],
    stiffness_scale: float = 1.0,
    damping_scale: float = 1.0,
    w_WT: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
    p_TS: Annotated[NDArray[numpy.float64], "(:, 3)"] | None = None,
) -> tuple[Annotated[NDArray[numpy.float64], "(3,)"], Annotated[NDArray[numpy.float64], "(3,)"], Annotated[NDArray[numpy.float64], "(3,)"], Annotated[NDArray[numpy.float64], "(3,)"]]:
    """
    Stage `force` on n contacts given as (n, 3) arrays: (F, F_spring, F_damping) [N], torque about T [N m], in W.
    """

class CertainFriction:
    """The part of a device's friction that is certain, per joint."""

    def __init__(self) -> None: ...

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """[N m, N]"""

    @coulomb.setter
    def coulomb(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """[N m s/rad, N s/m]"""

    @viscous.setter
    def viscous(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def quantum(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """resolution of the joint's position [rad, m]"""

    @quantum.setter
    def quantum(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class StabilityOptions:
    """What may reach the hand."""

    def __init__(self) -> None: ...

    @property
    def force_cap(self) -> float:
        """largest force on the hand [N]"""

    @force_cap.setter
    def force_cap(self, arg: float, /) -> None: ...

    @property
    def rate_cap(self) -> float:
        """largest change of it, and the ramp to zero [N/s]"""

    @rate_cap.setter
    def rate_cap(self, arg: float, /) -> None: ...

    @property
    def moment_cap(self) -> float:
        """largest moment on the hand [N m]; 0: forces only"""

    @moment_cap.setter
    def moment_cap(self, arg: float, /) -> None: ...

    @property
    def moment_rate_cap(self) -> float:
        """largest change of it [N m/s]"""

    @moment_rate_cap.setter
    def moment_rate_cap(self, arg: float, /) -> None: ...

    @property
    def stale_after(self) -> float:
        """states older than this are not trusted [s]"""

    @stale_after.setter
    def stale_after(self, arg: float, /) -> None: ...

    @property
    def passivity(self) -> Literal['observer', 'tank', 'off']: ...

    @passivity.setter
    def passivity(self, mode: Literal['observer', 'tank', 'off'], /) -> None: ...

    @property
    def friction(self) -> CertainFriction:
        """of the device; a copy, assign it whole"""

    @friction.setter
    def friction(self, arg: CertainFriction, /) -> None: ...

    @property
    def low_pass(self) -> float:
        """of the wanted force [Hz]; 0: none"""

    @low_pass.setter
    def low_pass(self, arg: float, /) -> None: ...

    @property
    def coupling_stiffness(self) -> float:
        """of the virtual coupling [N/m]; 0: none"""

    @coupling_stiffness.setter
    def coupling_stiffness(self, arg: float, /) -> None: ...

    @property
    def coupling_damping(self) -> float:
        """beside its spring [N s/m]"""

    @coupling_damping.setter
    def coupling_damping(self, arg: float, /) -> None: ...

    @property
    def delay(self) -> float:
        """known, of the loop [s]"""

    @delay.setter
    def delay(self, arg: float, /) -> None: ...

    @property
    def quantum(self) -> float:
        """resolution of the handle's position [m]"""

    @quantum.setter
    def quantum(self, arg: float, /) -> None: ...

    @property
    def allowance(self) -> float:
        """may be given beyond what came in [J]"""

    @allowance.setter
    def allowance(self, arg: float, /) -> None: ...

    @property
    def tank_capacity(self) -> float:
        """of the tank [J]"""

    @tank_capacity.setter
    def tank_capacity(self, arg: float, /) -> None: ...

    @property
    def acceleration(self) -> float:
        """nobody snatches the handle away faster [m/s^2]"""

    @acceleration.setter
    def acceleration(self, arg: float, /) -> None: ...

    @property
    def angular_acceleration(self) -> float:
        """nor turns it [rad/s^2]"""

    @angular_acceleration.setter
    def angular_acceleration(self, arg: float, /) -> None: ...

class StabilityOutput:
    """One tick of the stage; wrenches (6,) on the hand in L."""

    @property
    def F_H_L(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """rendered"""

    @property
    def F_capped(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """what the limiter was asked for"""

    @property
    def F_coupling(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """what the virtual coupling kept"""

    @property
    def F_low_pass(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """what the low-pass kept"""

    @property
    def F_passivity(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """what the passivity controller kept"""

    @property
    def lag(self) -> list[float]:
        """of coupling, low-pass, passivity controller, caps [s]"""

    @property
    def status(self) -> int:
        """bits of Status"""

class Stability:
    """Stage `stability`: coupling, low-pass, passivity controller, limiter."""

    def __init__(self, options: StabilityOptions, dt: float) -> None: ...

    def step(
        self,
        F_H_L: numpy.typing.ArrayLike,
        p_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        v_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        q: Annotated[NDArray[numpy.float64], "(:,)"] = ...,
        stiffness: float = 0.0,
        t: float = 0.0,
        t_leader: float = 0.0,
        engaged: bool = True,
    ) -> StabilityOutput:
        """One tick; rendered() has to follow."""

    def rendered(self, F_H_L: numpy.typing.ArrayLike) -> None:
        """What the drives left of it."""

    @property
    def stored(self) -> float:
        """may be given back [J]"""

    @property
    def reserved(self) -> float:
        """of it, most that what is on its way may cost [J]"""

class Limiter:
    """
    The end of stage `stability`: finite, below its cap, no faster than its rate cap.
    """

    def __init__(self, options: StabilityOptions, dt: float) -> None: ...

    def step(
        self,
        F_H_L: numpy.typing.ArrayLike,
        t: float = 0.0,
        t_leader: float = 0.0,
        t_follower: float = 0.0,
        leader_valid: bool = True,
        follower_valid: bool = True,
        engaged: bool = True,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(:,)"], Annotated[NDArray[numpy.float64], "(:,)"], int]:
        """
        One tick, a force (3,) or a wrench (6,): (F_H_L rendered, F_cut, status bits).
        """

class Energy:
    """Entries of the ledger [J]."""

    @property
    def port(self) -> float: ...

    @property
    def spring(self) -> float: ...

    @property
    def damping(self) -> float: ...

    @property
    def cut(self) -> float: ...

    @property
    def passivity(self) -> float: ...

    @property
    def source(self) -> list[float]: ...

class Ledger:
    """Energy at the hand's port: each force times the motion while it acted."""

    def __init__(self, delay: float = 0.0, dt: float = 0.001) -> None: ...

    def step(
        self,
        p_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        F_H_L: numpy.typing.ArrayLike,
        F_damping: numpy.typing.ArrayLike,
        F_cut: numpy.typing.ArrayLike,
        spring: float,
        R_LH: Annotated[NDArray[numpy.float64], "(3, 3)"] = ...,
        F_source: Annotated[NDArray[numpy.float64], "(:, :)"] | None = None,
    ) -> Energy:
        """
        One tick, forces (3,) or wrenches (6,) in L, of each source a row: the energies [J].
        """

class PassivityObserver:
    """What the hand has surely put into the port; a force on one point."""

    def __init__(self, options: StabilityOptions, dt: float) -> None: ...

    def step(
        self,
        p_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        v_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        F_H_L: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> float:
        """One tick, the force sent at its end: what may be given back [J]."""

    @property
    def in_flight(self) -> float:
        """most that what was sent may still give [J]"""

class Dissipation:
    """What a device surely turns into heat."""

    def __init__(self, friction: CertainFriction, dt: float) -> None: ...

    def step(self, q: Annotated[NDArray[numpy.float64], "(:,)"]) -> float:
        """Measured joints of a tick: heat since the last one, at least [J]."""

def held_cost(F: float, u: float, a: float, begin: float, end: float) -> float:
    """F times the integral of max(0, u + a t) over [begin, end] [J]."""

def ramp_cost(F: float, u: float, a: float, begin: float, rate: float) -> float:
    """The same of a force that falls from F at begin by rate [N/s]."""

def low_pass_share(cutoff: float, dt: float) -> float:
    """a of y_k = y_k-1 + a (u_k - y_k-1); cutoff [Hz], 0: none; dt [s]."""

class AllTerms:
    """Pinocchio's dynamics of the same URDF: a judge and a control."""

    def __init__(self, xml: str, base_frame: str, tip_frame: str) -> None: ...

    def compute(
        self,
        q: numpy.typing.ArrayLike,
        v: numpy.typing.ArrayLike,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(:, :)"], Annotated[NDArray[numpy.float64], "(:,)"], Annotated[NDArray[numpy.float64], "(:,)"], Annotated[NDArray[numpy.float64], "(:, :)"]]:
        """
        (M (n,n), C v + G (n,), G (n,), J (6,n) at the tip in base axes) by computeAllTerms.
        """

class IkOptions:
    """Inverse kinematics: when to stop."""

    def __init__(self) -> None: ...

    @property
    def max_iterations(self) -> int: ...

    @max_iterations.setter
    def max_iterations(self, arg: int, /) -> None: ...

    @property
    def position_tolerance(self) -> float:
        """[m]"""

    @position_tolerance.setter
    def position_tolerance(self, arg: float, /) -> None: ...

    @property
    def orientation_tolerance(self) -> float:
        """[rad]"""

    @orientation_tolerance.setter
    def orientation_tolerance(self, arg: float, /) -> None: ...

    @property
    def damping(self) -> float:
        """floor of the damping, which grows with the remaining error"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...

class IkResult:
    """How an inverse kinematics ended."""

    @property
    def converged(self) -> bool: ...

    @property
    def iterations(self) -> int: ...

    @property
    def position_error(self) -> float:
        """[m]"""

    @property
    def orientation_error(self) -> float:
        """[rad]"""

    @property
    def damping(self) -> float:
        """of the last step; large near singularities and out of reach"""

class Field:
    """
    A smooth potential of some joints: sum_c w_c exp(-|(q_J - z_c) / l|^2 / 2).
    """

    def __init__(
        self,
        joints: Sequence[int],
        centres: Annotated[NDArray[numpy.float64], "(:, :)"],
        length: numpy.typing.ArrayLike,
    ) -> None:
        """Joints J from zero (d); centres z (c, d), lengths l (d) [rad, m]."""

    @property
    def joints(self) -> list[int]: ...

    @property
    def centres(self) -> Annotated[NDArray[numpy.float64], "(:, :)"]: ...

    @property
    def length(self) -> Annotated[NDArray[numpy.float64], "(:,)"]: ...

class GravityTerms:
    """The columns of a gravity model: masses, powers of joints, fields."""

    def __init__(self, masses: bool = True, degree: int = -1, fields: Sequence[Field] = []) -> None: ...

    @property
    def masses(self) -> bool:
        """4 columns per link"""

    @property
    def degree(self) -> int:
        """of a polynomial per joint; -1: none"""

    @property
    def fields(self) -> list[Field]:
        """a column per centre"""

class Arm:
    """An arm: kinematics and dynamics in its base frame. See palpate.Arm."""

    @overload
    def __init__(self, xml: str, base_frame: str, tip_frame: str) -> None:
        """From a URDF's text; the arm is the chain from base to tip."""

    @overload
    def __init__(self, kind: str, parameters: _Mapping[str, Sequence[float]]) -> None:
        """
        A device with a closed form of its own, e.g. 'delta', from its numbers by name.
        """

    @property
    def n(self) -> int:
        """Number of joints."""

    @property
    def joint_names(self) -> list[str]: ...

    @property
    def link_names(self) -> list[str]: ...

    @property
    def q_min(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) lower limits [rad, m]"""

    @property
    def q_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) upper limits [rad, m]"""

    @property
    def tau_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) drive limits [N m, N]"""

    @property
    def v_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) speed limits [rad/s, m/s]"""

    @property
    def orients(self) -> bool:
        """Can its tip be turned at will? Otherwise it is placed only."""

    @property
    def segments(self) -> list[tuple[str, Annotated[NDArray[numpy.float64], "(3,)"]]]:
        """The arm as sticks: (link, end in the link's axes (3,) [m]) each."""

    def fk(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """X_0T (4,4): the tip in the base at q (n,) [rad, m]."""

    def jacobian(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """(6,n) at the tip in base axes, linear rows over angular rows."""

    def gravity(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """G(q) = dP/dq (n,) that holds the masses up [N m, N]."""

    def elastic(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """What of holding (n,) is not of the masses: spring, cables [N m, N]."""

    def holding(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """
        What holds the arm still (n,): the identified model, or gravity and counterbalance [N m, N].
        """

    def bias(self, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """C(q, v) v + G(q) (n,) [N m, N]."""

    def inverse_dynamics(
        self,
        q: numpy.typing.ArrayLike,
        v: numpy.typing.ArrayLike,
        a: numpy.typing.ArrayLike,
    ) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """M a + C v + G (n,) [N m, N]."""

    def mass_matrix(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """M(q) (n,n), symmetric; rotor inertias are not in it."""

    def dynamics(
        self,
        q: numpy.typing.ArrayLike,
        v: numpy.typing.ArrayLike,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(:, :)"], Annotated[NDArray[numpy.float64], "(:,)"], Annotated[NDArray[numpy.float64], "(4, 4)"], Annotated[NDArray[numpy.float64], "(:, :)"], Annotated[NDArray[numpy.float64], "(:,)"]]:
        """
        (M (n,n), C v + G (n,), X_0T (4,4), J (6,n), dJ/dt v (6,)) in one go, as the plant uses them.
        """

    def potential_energy(self, q: numpy.typing.ArrayLike) -> float:
        """P(q) of the masses [J]."""

    def elastic_energy(self, q: numpy.typing.ArrayLike) -> float:
        """P(q) of spring and cables [J]."""

    def set_counterbalance(self, torque: float, along: numpy.typing.ArrayLike) -> None:
        """
        A spring P = -torque sin(along . q): torque [N m], along (n,). 0 takes it away.
        """

    def gravity_regressor(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """
        Y(q) (n,4n): gravity = Y Pi, Pi = (m, m c_x, m c_y, m c_z) of each link, c in its axes (Eqs 10-12).
        """

    @property
    def moments(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Pi of the model file (4n,) [kg, kg m]."""

    def gravity_columns(
        self,
        terms: GravityTerms,
        q: Annotated[NDArray[numpy.float64], "(:, :)"],
    ) -> Annotated[NDArray[numpy.float64], "(:, :, :)"]:
        """Phi (k, n, m) of the terms at the poses q (k, n): holding = Phi theta."""

    def set_gravity_model(self, terms: GravityTerms, theta: Annotated[NDArray[numpy.float64], "(:,)"]) -> None:
        """
        Hold the arm by an identified model, theta (m,), instead of masses and counterbalance.
        """

    def set_gravity(self, g_base: Annotated[NDArray[numpy.float64], "(3,)"]) -> None:
        """Gravity in base axes [m/s^2]; default (0, 0, -9.81)."""

    def with_scaled_masses(self, scale: numpy.typing.ArrayLike) -> Arm:
        """
        A copy whose link masses are multiplied by scale (n,): a controller's wrong model of the plant.
        """

    def torque_regressor(
        self,
        q: numpy.typing.ArrayLike,
        v: numpy.typing.ArrayLike,
        a: numpy.typing.ArrayLike,
    ) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """
        Y (n,10n) of M a + C v + G = Y pi, pi = (m, m c (3), I_xx, I_xy, I_yy, I_xz, I_yz, I_zz) per link.
        """

    @property
    def inertial_parameters(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """pi (10n,) of the links [kg, kg m, kg m^2]."""

    def with_inertial_parameters(self, pi: numpy.typing.ArrayLike) -> Arm:
        """
        A copy made of other links alone, no counterbalance: pi (10n,); refuses what is no body's.
        """

    def ik_from(
        self,
        X_0T: Annotated[NDArray[numpy.float64], "(4, 4)"],
        q0: numpy.typing.ArrayLike,
        options: IkOptions = ...,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(:,)"], IkResult]:
        """
        One damped Newton run from q0: (q, IkResult). palpate.Arm.ik restarts and raises.
        """

    def link_poses_array(self, q: numpy.typing.ArrayLike) -> list[Annotated[NDArray[numpy.float64], "(4, 4)"]]:
        """X_0link (4,4) of every link, in link_names order."""

class HandOptions:
    """
    The operator's hand: a mass on the handle, spring and damper to its path.
    """

    def __init__(self) -> None: ...

    @property
    def mass(self) -> float:
        """moves with the handle [kg]"""

    @mass.setter
    def mass(self, arg: float, /) -> None: ...

    @property
    def damping(self) -> float:
        """to the intended path [N s/m]"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...

    @property
    def stiffness(self) -> float:
        """to the intended path [N/m]"""

    @stiffness.setter
    def stiffness(self, arg: float, /) -> None: ...

    @property
    def inertia(self) -> float:
        """rotational, moves with the handle [kg m^2]"""

    @inertia.setter
    def inertia(self, arg: float, /) -> None: ...

    @property
    def rotational_damping(self) -> float:
        """[N m s/rad]"""

    @rotational_damping.setter
    def rotational_damping(self, arg: float, /) -> None: ...

    @property
    def rotational_stiffness(self) -> float:
        """[N m/rad]"""

    @rotational_stiffness.setter
    def rotational_stiffness(self, arg: float, /) -> None: ...

    @property
    def grip_force_max(self) -> float:
        """the hand slips above it [N]"""

    @grip_force_max.setter
    def grip_force_max(self, arg: float, /) -> None: ...

class LeaderOptions:
    """What a leader is made of; palpate.Arm.leader_options() fills it."""

    def __init__(self) -> None: ...

    @property
    def coupling(self) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """(n,n) A: q_joint = A q_motor"""

    @coupling.setter
    def coupling(self, arg: Annotated[NDArray[numpy.float64], "(:, :)"], /) -> None: ...

    @property
    def loop_delay(self) -> float:
        """from command to torque, force term only [s]"""

    @loop_delay.setter
    def loop_delay(self, arg: float, /) -> None: ...

    @property
    def loop_jitter(self) -> float:
        """on top of it: uniform from 0 to this, each command [s]"""

    @loop_jitter.setter
    def loop_jitter(self, arg: float, /) -> None: ...

    @property
    def drive_lag(self) -> float:
        """time constant of the drives' current loops, of all torque [s]"""

    @drive_lag.setter
    def drive_lag(self, arg: float, /) -> None: ...

    @property
    def velocity_window(self) -> float:
        """
        0: time between edges; else the difference of two positions so far apart [s]
        """

    @velocity_window.setter
    def velocity_window(self, arg: float, /) -> None: ...

    @property
    def velocity_cutoff(self) -> float:
        """first-order low-pass of velocities; 0 = none [Hz]"""

    @velocity_cutoff.setter
    def velocity_cutoff(self, arg: float, /) -> None: ...

    @property
    def hold_timeout(self) -> float:
        """without a fresh command the force ramps to zero [s]"""

    @hold_timeout.setter
    def hold_timeout(self, arg: float, /) -> None: ...

    @property
    def cell_noise(self) -> float:
        """of the load cell in the handle, rms per axis [N]"""

    @cell_noise.setter
    def cell_noise(self, arg: float, /) -> None: ...

    @property
    def seed(self) -> int:
        """of that noise and of the jitter; a simulation takes its own"""

    @seed.setter
    def seed(self, arg: int, /) -> None: ...

    @property
    def quantised(self) -> bool:
        """encoders as above, or the truth"""

    @quantised.setter
    def quantised(self, arg: bool, /) -> None: ...

    @property
    def encoder_step(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) motor side [rad/count]; 0 = ideal"""

    @encoder_step.setter
    def encoder_step(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) Fc [N m]"""

    @coulomb.setter
    def coulomb(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) Fv [N m s/rad]"""

    @viscous.setter
    def viscous(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def rotor_inertia(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) reflected to the joint [kg m^2]"""

    @rotor_inertia.setter
    def rotor_inertia(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def tau_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) drive limits, joint side [N m]"""

    @tau_max.setter
    def tau_max(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class DriveOptions:
    """The drives of a follower, at its joints."""

    def __init__(self) -> None: ...

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) Fc [N m, N]"""

    @coulomb.setter
    def coulomb(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) Fv [N m s/rad, N s/m]"""

    @viscous.setter
    def viscous(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def rotor_inertia(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) [kg m^2, kg]"""

    @rotor_inertia.setter
    def rotor_inertia(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class FollowerOptions:
    """Joint servos of a simulated follower."""

    def __init__(self) -> None: ...

    @property
    def bandwidth(self) -> float:
        """natural frequency of the joint servos [Hz]; 0 = ideal"""

    @bandwidth.setter
    def bandwidth(self, arg: float, /) -> None: ...

    @property
    def damping_ratio(self) -> float: ...

    @damping_ratio.setter
    def damping_ratio(self, arg: float, /) -> None: ...

    @property
    def jaw_v_max(self) -> float:
        """[rad/s]"""

    @jaw_v_max.setter
    def jaw_v_max(self, arg: float, /) -> None: ...

    @property
    def driven(self) -> bool:
        """joints moved by drives with torques, which contacts push against"""

    @driven.setter
    def driven(self, arg: bool, /) -> None: ...

    @property
    def drives(self) -> DriveOptions:
        """of a driven follower"""

    @drives.setter
    def drives(self, arg: DriveOptions, /) -> None: ...

    @property
    def v_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) [rad/s, m/s]"""

    @v_max.setter
    def v_max(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def encoder_step(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) [rad, m]; 0 = ideal"""

    @encoder_step.setter
    def encoder_step(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class Leader:
    """
    A simulated leader: dynamics, friction, drives, encoders, and a hand on it.
    """

    def __init__(self, arm: Arm, options: LeaderOptions, hand: HandOptions = ...) -> None: ...

    def reset(self, q: Annotated[NDArray[numpy.float64], "(:,)"]) -> None:
        """At rest at q (n,), within the limits; drives off, time zero."""

    def command(
        self,
        tau_force: Annotated[NDArray[numpy.float64], "(:,)"],
        tau_gravity: Annotated[NDArray[numpy.float64], "(:,)"],
        tau_platform: Annotated[NDArray[numpy.float64], "(:,)"],
    ) -> None:
        """The newest torques (n,) [N m]; held until the next."""

    def obey(self, command: LeaderCommand) -> None:
        """The newest command of a Torque stage, every term of it."""

    def pinch(self, gripper: float) -> None:
        """The hand closes the grips to this angle, 0 = closed [rad]."""

    def step(
        self,
        dt: float,
        X_LH_hand: Annotated[NDArray[numpy.float64], "(4, 4)"],
        V_LH_hand: Annotated[NDArray[numpy.float64], "(6,)"] = ...,
        n: int = 1,
    ) -> None:
        """
        n servo periods of dt [s] with the hand wanting the handle at X_LH_hand (4,4), moving with V (6,).
        """

    @property
    def t(self) -> float:
        """[s]"""

    @property
    def q_measured(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """encoders [rad]"""

    @property
    def v_measured(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """encoders [rad/s]"""

    @property
    def gripper(self) -> float:
        """[rad]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """truth [rad]"""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """truth [rad/s]"""

    @property
    def load_cell(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """force and torque of the arm on the hand, in L (6,), the truth [N, N m]"""

    @property
    def F_cell_L(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """what the load cell says (3,), noise included [N]"""

    @property
    def hand_slipped(self) -> bool:
        """the grip force limit was reached in the last step"""

    @property
    def energy(self) -> float:
        """kinetic + potential [J]; the hand carries its own weight"""

class Follower:
    """A simulated follower: position-servoed joints and a jaw."""

    def __init__(self, arm: Arm, options: FollowerOptions) -> None: ...

    def reset(self, q: Annotated[NDArray[numpy.float64], "(:,)"], jaw: float = 0.0) -> None: ...

    def command(self, q: Annotated[NDArray[numpy.float64], "(:,)"], jaw: float = 0.0) -> None:
        """Where the joints (n,) [rad, m] and the jaw [rad] shall go."""

    def step(self, dt: float, n: int = 1, F_T_B: Annotated[NDArray[numpy.float64], "(6,)"] = ...) -> None:
        """
        n servo periods of dt [s]; F_T_B (6,): environment on the tip, felt by a driven follower [N, N m].
        """

    @property
    def t(self) -> float:
        """[s]"""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """measured [rad, m]"""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """measured; empty unless driven"""

    @property
    def tau(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """of the drives [N m, N]; empty unless driven"""

    @property
    def jaw(self) -> float:
        """[rad]"""

AXIS_QUANTA: float = 8.0

AXIS_UNFELT: float = 1e-06

class AxisOptions:
    """
    One axis of a haptic device, its loop, a virtual wall at x > 0, a hand.
    """

    def __init__(self) -> None: ...

    @property
    def mass(self) -> float:
        """of the device [kg]"""

    @mass.setter
    def mass(self, arg: float, /) -> None: ...

    @property
    def damping(self) -> float:
        """viscous [N s/m]"""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...

    @property
    def coulomb(self) -> float:
        """dry friction [N]"""

    @coulomb.setter
    def coulomb(self, arg: float, /) -> None: ...

    @property
    def rate(self) -> float:
        """of the haptic cycle [Hz]"""

    @rate.setter
    def rate(self, arg: float, /) -> None: ...

    @property
    def delay(self) -> float:
        """from the measurement to the force [s]"""

    @delay.setter
    def delay(self, arg: float, /) -> None: ...

    @property
    def jitter(self) -> float:
        """added to it in each cycle, uniform in 0..jitter [s]"""

    @jitter.setter
    def jitter(self, arg: float, /) -> None: ...

    @property
    def quantum(self) -> float:
        """of the measured position; 0 = ideal [m]"""

    @quantum.setter
    def quantum(self, arg: float, /) -> None: ...

    @property
    def velocity_cutoff(self) -> float:
        """low pass of the difference; 0 = none [Hz]"""

    @velocity_cutoff.setter
    def velocity_cutoff(self, arg: float, /) -> None: ...

    @property
    def K(self) -> float:
        """stiffness of the wall [N/m]"""

    @K.setter
    def K(self, arg: float, /) -> None: ...

    @property
    def B(self) -> float:
        """its damping [N s/m]"""

    @B.setter
    def B(self, arg: float, /) -> None: ...

    @property
    def bilateral(self) -> bool:
        """a spring that pulls, too"""

    @bilateral.setter
    def bilateral(self, arg: bool, /) -> None: ...

    @property
    def force_max(self) -> float:
        """the force is cut there [N]"""

    @force_max.setter
    def force_max(self, arg: float, /) -> None: ...

    @property
    def rate_max(self) -> float:
        """it changes no faster [N/s]"""

    @rate_max.setter
    def rate_max(self, arg: float, /) -> None: ...

    @property
    def hand_mass(self) -> float:
        """moves with the device [kg]"""

    @hand_mass.setter
    def hand_mass(self, arg: float, /) -> None: ...

    @property
    def hand_damping(self) -> float:
        """to where the hand wants to be [N s/m]"""

    @hand_damping.setter
    def hand_damping(self, arg: float, /) -> None: ...

    @property
    def hand_stiffness(self) -> float:
        """the same [N/m]"""

    @hand_stiffness.setter
    def hand_stiffness(self, arg: float, /) -> None: ...

    @property
    def seed(self) -> int:
        """of the jitter"""

    @seed.setter
    def seed(self, arg: int, /) -> None: ...

class AxisResult:
    """What came of a run of an Axis."""

    @property
    def diverged(self) -> bool:
        """it left |x| < 1 m"""

    @property
    def oscillates(self) -> bool:
        """above max(8 quanta, 1 um) in the last quarter, and not decaying"""

    @property
    def amplitude(self) -> float:
        """half of peak to peak in the last quarter of the run [m]"""

    @property
    def frequency(self) -> float:
        """in the last quarter [Hz]"""

    @property
    def peak(self) -> float:
        """deepest [m]"""

    @property
    def rest(self) -> float:
        """mean of the last quarter [m]"""

    @property
    def overshoot(self) -> float:
        """(peak - rest) / rest [-]"""

    @property
    def settling(self) -> float:
        """from then on |x - rest| < 2 % of |rest| [s]"""

    @property
    def energy_port(self) -> float:
        """taken from the hand by the wall, true [J]"""

    @property
    def energy_min(self) -> float:
        """lowest that it was: below zero the wall had made energy [J]"""

class Axis:
    """
    Simulates it: exact between commands, cycles and reversals of dry friction.
    """

    def __init__(self, options: AxisOptions) -> None: ...

    def run(
        self,
        duration: float = 2.0,
        x0: float = 0.0,
        v0: float = 0.0,
        push: float = 0.0,
        path: Sequence[float] = [],
        stability: StabilityOptions | None = None,
    ) -> AxisResult:
        """
        duration [s] from (x0 [m], v0 [m/s]); push: constant force of the hand [N]; path: where it wants to be at each
        cycle [m], then rests; nowhere else than 0 when left out; stability: options of that stage, or none.
        """

    def trace(
        self,
        duration: float = 2.0,
        x0: float = 0.0,
        v0: float = 0.0,
        push: float = 0.0,
        path: Sequence[float] = [],
        stability: StabilityOptions | None = None,
    ) -> tuple[AxisResult, Annotated[NDArray[numpy.float64], "(:, :)"]]:
        """
        The same run, with its rows (n, 5), one per cycle: t [s], x [m], v [m/s], force commanded on the device along x
        [N], energy_port [J].
        """

class LeaderCommand:
    """Torque terms for the leader, kept apart."""

    @property
    def tau_force(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) J^T (F_H_L + F_law_L) [N m]"""

    @property
    def tau_gravity(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) holds the arm up [N m]"""

    @property
    def tau_platform(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) joint-4 controller [N m]"""

    @property
    def tau_friction(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) compensates friction [N m]"""

    @property
    def tau_limits(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) soft stops [N m]"""

    @property
    def tau(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) their sum [N m]"""

    @property
    def F_H_L(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(6,) truly rendered [N, N m]"""

    @property
    def F_law_L(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(6,) what the control law adds to it [N, N m]"""

    @property
    def F_neglected(self) -> float:
        """what it leaves to the hand of the arm's own dynamics [N]"""

class TorqueOptions:
    """Torques that render a force and hold the arm's own weight."""

    def __init__(self) -> None: ...

    @property
    def law(self) -> str:
        """'stiffness' (the paper's), 'impedance' or 'admittance'"""

    @law.setter
    def law(self, arg: str, /) -> None: ...

    @property
    def mode(self) -> str:
        """'full', or 'paper': first three joints, wrist torques zero"""

    @mode.setter
    def mode(self, arg: str, /) -> None: ...

    @property
    def force_gain(self) -> float:
        """0 switches tau_force off"""

    @force_gain.setter
    def force_gain(self, arg: float, /) -> None: ...

    @property
    def gravity_gain(self) -> float:
        """0 switches gravity compensation off"""

    @gravity_gain.setter
    def gravity_gain(self, arg: float, /) -> None: ...

    @property
    def platform_gain(self) -> float:
        """joint-4 controller, 0..1 (7-joint MTMs, full mode)"""

    @platform_gain.setter
    def platform_gain(self, arg: float, /) -> None: ...

    @property
    def friction(self) -> FrictionOptions: ...

    @friction.setter
    def friction(self, arg: FrictionOptions, /) -> None: ...

    @property
    def limits(self) -> LimitOptions: ...

    @limits.setter
    def limits(self, arg: LimitOptions, /) -> None: ...

    @property
    def laws(self) -> LawOptions: ...

    @laws.setter
    def laws(self, arg: LawOptions, /) -> None: ...

    @property
    def law_cap(self) -> float:
        """most that a law may add to the rendered force [N]"""

    @law_cap.setter
    def law_cap(self, arg: float, /) -> None: ...

    @property
    def fast_force(self) -> float:
        """more neglected inertia than this is told: too_fast [N]"""

    @fast_force.setter
    def fast_force(self, arg: float, /) -> None: ...

    @property
    def rotor_inertia(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) of the controller's model [kg m^2]"""

    @rotor_inertia.setter
    def rotor_inertia(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class FrictionOptions:
    """Friction compensation; it never drives the arm."""

    def __init__(self) -> None: ...

    @property
    def gain(self) -> float:
        """0 switches it off, 0..1"""

    @gain.setter
    def gain(self, arg: float, /) -> None: ...

    @property
    def dead_band(self) -> float:
        """none below this speed [rad/s, m/s]"""

    @dead_band.setter
    def dead_band(self, arg: float, /) -> None: ...

    @property
    def full_speed(self) -> float:
        """whole from this speed on [rad/s, m/s]"""

    @full_speed.setter
    def full_speed(self, arg: float, /) -> None: ...

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) of the controller's model [N m]"""

    @coulomb.setter
    def coulomb(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """(n,) of the controller's model [N m s/rad]"""

    @viscous.setter
    def viscous(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class LimitOptions:
    """Soft stops before the joint limits."""

    def __init__(self) -> None: ...

    @property
    def gain(self) -> float:
        """share of the drive's limit at the joint's limit; 0 switches it off"""

    @gain.setter
    def gain(self, arg: float, /) -> None: ...

    @property
    def margin(self) -> float:
        """share of the joint's range"""

    @margin.setter
    def margin(self, arg: float, /) -> None: ...

class LawOptions:
    """Of the control laws."""

    def __init__(self) -> None: ...

    @property
    def shape_inertia(self) -> bool:
        """impedance: the handle weighs virtual_mass"""

    @shape_inertia.setter
    def shape_inertia(self, arg: bool, /) -> None: ...

    @property
    def virtual_mass(self) -> float:
        """[kg]"""

    @virtual_mass.setter
    def virtual_mass(self, arg: float, /) -> None: ...

    @property
    def virtual_damping(self) -> float:
        """admittance [N s/m]"""

    @virtual_damping.setter
    def virtual_damping(self, arg: float, /) -> None: ...

    @property
    def servo_bandwidth(self) -> float:
        """of admittance's position loop [Hz]"""

    @servo_bandwidth.setter
    def servo_bandwidth(self, arg: float, /) -> None: ...

class Torque:
    """Joint torques of one control law, within the drive limits."""

    def __init__(self, options: TorqueOptions, tau_max: numpy.typing.ArrayLike, dt: float = 0.001) -> None: ...

    def step(
        self,
        model: Arm,
        q: numpy.typing.ArrayLike,
        v: numpy.typing.ArrayLike,
        F_H_L: Annotated[NDArray[numpy.float64], "(6,)"],
        F_cell_L: Annotated[NDArray[numpy.float64], "(3,)"] | None = None,
        fresh: bool = True,
    ) -> tuple[LeaderCommand, int]:
        """
        (LeaderCommand, status bits) that render F_H_L (6,); F_cell_L (3,): force of the arm on the hand.
        """

def cartesian_place(
    model: Arm,
    q: numpy.typing.ArrayLike,
    v: numpy.typing.ArrayLike,
    rotor_inertia: Annotated[NDArray[numpy.float64], "(:,)"] | None = None,
    heaviest: float = 20.0,
) -> tuple[Annotated[NDArray[numpy.float64], "(:, :)"], Annotated[NDArray[numpy.float64], "(:,)"], Annotated[NDArray[numpy.float64], "(:,)"], bool]:
    """
    (Lambda (3,3), Gamma v (3,), eta (3,), singular) of the tip's place (Eqs 2-5).
    """

def cartesian(
    model: Arm,
    q: numpy.typing.ArrayLike,
    v: numpy.typing.ArrayLike,
    rotor_inertia: Annotated[NDArray[numpy.float64], "(:,)"] | None = None,
    heaviest: float = 20.0,
) -> tuple[Annotated[NDArray[numpy.float64], "(:, :)"], Annotated[NDArray[numpy.float64], "(:,)"], Annotated[NDArray[numpy.float64], "(:,)"], bool]:
    """
    (Lambda (6,6), Gamma v (6,), eta (6,), singular) of the tip's place and orientation (Eqs 2-5).
    """

TICK_BYTES: int = 2288

def signals() -> list[tuple[str, int, int, str, str, str, bool, str]]:
    """
    The table of signals: (name, byte offset, doubles, unit, frame, doc, deterministic, stage) per row.
    """

def status_words() -> list[tuple[str, int, str]]:
    """
    The bits of the signal `status`, the gravest first: (name, bit, words) per row.
    """

class Controls:
    """What a person may change while it runs."""

    def __init__(self) -> None: ...

    @property
    def following(self) -> bool:
        """the tool follows the hand, the hand is given forces"""

    @following.setter
    def following(self, arg: bool, /) -> None: ...

    @property
    def clutch(self) -> bool:
        """pedal pressed: the hand moves freely, the tool stays"""

    @clutch.setter
    def clutch(self, arg: bool, /) -> None: ...

    @property
    def paused(self) -> bool:
        """simulated time stands still"""

    @paused.setter
    def paused(self, arg: bool, /) -> None: ...

    @property
    def hold(self) -> bool:
        """the simulated hand waits where its path is"""

    @hold.setter
    def hold(self, arg: bool, /) -> None: ...

    @property
    def stiffness_scale(self) -> float:
        """times every object's stiffness"""

    @stiffness_scale.setter
    def stiffness_scale(self, arg: float, /) -> None: ...

    @property
    def damping_scale(self) -> float:
        """times every object's damping"""

    @damping_scale.setter
    def damping_scale(self, arg: float, /) -> None: ...

    @property
    def guidance(self) -> float:
        """pedal of guidance, 0-1, for fixtures that fade with it"""

    @guidance.setter
    def guidance(self, arg: float, /) -> None: ...

    @property
    def p_hand_offset_W(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """added to the hand's intended position, (3,) [m]"""

    @p_hand_offset_W.setter
    def p_hand_offset_W(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

class RealTimeOptions:
    """What the real-time thread may ask of the system."""

    def __init__(self) -> None: ...

    @property
    def allow_priority(self) -> bool:
        """SCHED_FIFO and locked memory"""

    @allow_priority.setter
    def allow_priority(self, arg: bool, /) -> None: ...

    @property
    def allow_affinity(self) -> bool:
        """one core for the loop"""

    @allow_affinity.setter
    def allow_affinity(self, arg: bool, /) -> None: ...

    @property
    def priority(self) -> int:
        """of SCHED_FIFO, 1..99"""

    @priority.setter
    def priority(self, arg: int, /) -> None: ...

    @property
    def spin_us(self) -> float:
        """last stretch before a deadline awaited awake [us]"""

    @spin_us.setter
    def spin_us(self, arg: float, /) -> None: ...

class BareLoop:
    """A loop that only keeps time: what the machine itself can do."""

    def __init__(self, rate: float, options: RealTimeOptions = ...) -> None: ...

    def start(self) -> None: ...

    def stop(self) -> None: ...

    def timing(self) -> dict[str, Any]:
        """lateness_us, slack_us, ticks, missed_ticks, scheduler."""

class BareDynamics:
    """Times Pinocchio's computeAllTerms of both arms, once a column."""

    def __init__(self, leader: AllTerms, follower: AllTerms) -> None: ...

    def run(
        self,
        q_leader: Annotated[NDArray[numpy.float64], "(:, :)"],
        v_leader: Annotated[NDArray[numpy.float64], "(:, :)"],
        q_follower: Annotated[NDArray[numpy.float64], "(:, :)"],
    ) -> None:
        """A column per tick: (n, k), (n, k) and (m, k) [rad, m; rad/s, m/s]."""

    def timing(self) -> dict[str, Any]:
        """p50, p99, p999, max [us]."""

class CycleOptions:
    """The haptic cycle and its stages."""

    def __init__(self) -> None: ...

    @property
    def rate(self) -> float:
        """of the haptic cycle [Hz]"""

    @rate.setter
    def rate(self, arg: float, /) -> None: ...

    @property
    def method(self) -> str:
        """of contact"""

    @method.setter
    def method(self, arg: str, /) -> None: ...

    @property
    def contact(self) -> ContactOptions: ...

    @contact.setter
    def contact(self, arg: ContactOptions, /) -> None: ...

    @property
    def mapping(self) -> MappingOptions: ...

    @mapping.setter
    def mapping(self, arg: MappingOptions, /) -> None: ...

    @property
    def guidance(self) -> GuidanceOptions: ...

    @guidance.setter
    def guidance(self, arg: GuidanceOptions, /) -> None: ...

    @property
    def source(self) -> str:
        """of the force: 'contact', 'estimate' or 'both'"""

    @source.setter
    def source(self, arg: str, /) -> None: ...

    @property
    def estimate(self) -> EstimateOptions: ...

    @estimate.setter
    def estimate(self, arg: EstimateOptions, /) -> None: ...

    @property
    def stability(self) -> StabilityOptions: ...

    @stability.setter
    def stability(self, arg: StabilityOptions, /) -> None: ...

    @property
    def torque(self) -> TorqueOptions: ...

    @torque.setter
    def torque(self, arg: TorqueOptions, /) -> None: ...

    @property
    def X_WL(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """leader base in the world (4, 4)"""

    @X_WL.setter
    def X_WL(self, arg: Annotated[NDArray[numpy.float64], "(4, 4)"], /) -> None: ...

    @property
    def X_WB(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """follower base in the world (4, 4)"""

    @X_WB.setter
    def X_WB(self, arg: Annotated[NDArray[numpy.float64], "(4, 4)"], /) -> None: ...

class SimulationOptions(CycleOptions):
    """The cycle and the world around it."""

    def __init__(self) -> None: ...

    @property
    def plant_rate(self) -> float:
        """servo periods a second, at least [Hz]"""

    @plant_rate.setter
    def plant_rate(self, arg: float, /) -> None: ...

    @property
    def loop_delay(self) -> float:
        """from command to torque, force term only [s]"""

    @loop_delay.setter
    def loop_delay(self, arg: float, /) -> None: ...

    @property
    def loop_jitter(self) -> float:
        """on top of it: uniform from 0 to this, each command [s]"""

    @loop_jitter.setter
    def loop_jitter(self, arg: float, /) -> None: ...

    @property
    def seed(self) -> int:
        """of the hand's tremor, the load cell's noise and the jitter"""

    @seed.setter
    def seed(self, arg: int, /) -> None: ...

    @property
    def tremor(self) -> float:
        """8-12 Hz trembling of the hand, rms per axis [m]"""

    @tremor.setter
    def tremor(self, arg: float, /) -> None: ...

    @property
    def leader(self) -> LeaderOptions: ...

    @leader.setter
    def leader(self, arg: LeaderOptions, /) -> None: ...

    @property
    def hand(self) -> HandOptions: ...

    @hand.setter
    def hand(self, arg: HandOptions, /) -> None: ...

    @property
    def follower(self) -> FollowerOptions: ...

    @follower.setter
    def follower(self, arg: FollowerOptions, /) -> None: ...

    @property
    def realtime(self) -> RealTimeOptions: ...

    @realtime.setter
    def realtime(self, arg: RealTimeOptions, /) -> None: ...

    @property
    def q_leader0(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """where the leader starts [rad]"""

    @q_leader0.setter
    def q_leader0(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def q_follower0(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """where the follower starts [rad, m]"""

    @q_follower0.setter
    def q_follower0(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class Cycle:
    """One haptic cycle: states in, torques out."""

    def __init__(self, options: CycleOptions, leader_model: Arm, follower: Arm) -> None: ...

    def step(
        self,
        t: float,
        q: Annotated[NDArray[numpy.float64], "(:,)"],
        v: Annotated[NDArray[numpy.float64], "(:,)"],
        gripper: float,
        q_follower: Annotated[NDArray[numpy.float64], "(:,)"],
        jaw: float,
        scene: Snapshot,
        controls: Controls = ...,
        t_leader: float | None = None,
        t_follower: float | None = None,
        leader_valid: bool = True,
        follower_valid: bool = True,
        F_cell_L: Annotated[NDArray[numpy.float64], "(3,)"] | None = None,
        v_follower: Annotated[NDArray[numpy.float64], "(:,)"] | None = None,
        tau_follower: Annotated[NDArray[numpy.float64], "(:,)"] | None = None,
    ) -> tuple[NDArray[numpy.float64], Annotated[NDArray[numpy.float64], "(:,)"], float]:
        """
        One tick: (row, follower joints commanded, empty for none, jaw commanded). Stamps default to t.
        """

class HandPath:
    """
    Intended tool path in W through way points: no rest but at the ends and turns.
    """

    def __init__(
        self,
        times: Sequence[float],
        positions_W: Annotated[NDArray[numpy.float64], "(:, 3)"],
        grippers: Sequence[float] | None = None,
    ) -> None: ...

    def at(
        self,
        t: float,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(3,)"], Annotated[NDArray[numpy.float64], "(3,)"], float]:
        """(position [m], velocity [m/s], pinch [rad]) at t."""

class Simulation:
    """Hand, leader and follower simulated around the haptic cycle."""

    def __init__(
        self,
        options: SimulationOptions,
        leader_plant: Arm,
        leader_model: Arm,
        follower: Arm,
        snapshot: Snapshot,
        hand_path: HandPath,
    ) -> None: ...

    def drain(self) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """Rows since the last drain (real time)."""

    @property
    def dropped(self) -> int:
        """Rows lost because they were not drained in time."""

    def latest(self) -> NDArray[numpy.float64]:
        """The newest row."""

    @property
    def controls(self) -> Controls:
        """A copy; assign it whole. Taken at the next tick."""

    @controls.setter
    def controls(self, arg: Controls, /) -> None: ...

    def set_fixtures(self, fixtures: Fixtures) -> None:
        """
        Swaps the fixtures of guidance whole at the next tick; no force that the hand feels jumps.
        """

    def set_snapshot(self, snapshot: Snapshot) -> None:
        """Swaps the scene whole at the next tick."""

    def run(
        self,
        n_ticks: int,
        hand_W: Annotated[NDArray[numpy.float64], "(:, 3)"] | None = None,
    ) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """
        Lockstep: rows (n, TICK_BYTES/8); fewer when paused. hand_W (n, 3): where the hand is led, beside its path, to
        the end of each tick [m]; a call of some ticks lets an operator look at the rows and lead it on.
        """

    def start(self) -> None:
        """Real time, in a thread of its own."""

    def stop(self) -> None:
        """Ramps the force to zero, then ends the thread."""

    @property
    def running(self) -> bool: ...

    def watch_stages(self) -> None:
        """
        Time each stage of the cycle from now on: timing()['stages'][name] {p50, p99, p999, max} [us].
        """

    def timing(self) -> dict[str, Any]:
        """
        cycle_us, lateness_us {p50, p99, p999, max}, slack_us {p50, p01, p001}, ticks, missed_ticks, scheduler.
        """

    def fault(self) -> str | None:
        """
        The first fault in words, with the last states; None when there was none.
        """

class WatchOptions:
    """What a stream of stamped messages may do."""

    def __init__(self) -> None: ...

    @property
    def stale_after(self) -> float:
        """silence, age and jump of a clock beyond which it is a fault [s]"""

    @stale_after.setter
    def stale_after(self, arg: float, /) -> None: ...

    @property
    def v_max(self) -> float:
        """nothing moves faster [m/s]"""

    @v_max.setter
    def v_max(self, arg: float, /) -> None: ...

    @property
    def w_max(self) -> float:
        """nothing turns faster [rad/s]"""

    @w_max.setter
    def w_max(self, arg: float, /) -> None: ...

    @property
    def p_slack(self) -> float:
        """on top of it, for jitter of stamps [m]"""

    @p_slack.setter
    def p_slack(self, arg: float, /) -> None: ...

    @property
    def R_slack(self) -> float:
        """on top of it [rad]"""

    @R_slack.setter
    def R_slack(self, arg: float, /) -> None: ...

class CrtkOptions:
    """The haptic cycle of devices known by poses and wrenches (CRTK)."""

    def __init__(self, cycle: CycleOptions, q_follower0: Annotated[NDArray[numpy.float64], "(:,)"] = ...) -> None:
        """
        As the cycle of arms known by their joints is told: X_WL and X_WB are those of measured_cp here.
        """

    @property
    def rate(self) -> float: ...

    @property
    def stability(self) -> StabilityOptions: ...

    @stability.setter
    def stability(self, arg: StabilityOptions, /) -> None: ...

    @property
    def own_teleop(self) -> bool:
        """we move the follower"""

    @own_teleop.setter
    def own_teleop(self, arg: bool, /) -> None: ...

    @property
    def virtual_follower(self) -> bool:
        """there is none: the tool is where the map puts it"""

    @virtual_follower.setter
    def virtual_follower(self, arg: bool, /) -> None: ...

    @property
    def tip_frame(self) -> bool:
        """wrenches in the tip's frame, in place of that of measured_cp"""

    @tip_frame.setter
    def tip_frame(self, arg: bool, /) -> None: ...

    @property
    def needs_operator(self) -> bool:
        """of a teleoperation of ours: somebody is at the console"""

    @needs_operator.setter
    def needs_operator(self, arg: bool, /) -> None: ...

    @property
    def needs_state(self) -> bool:
        """operating states must be told"""

    @needs_state.setter
    def needs_state(self, arg: bool, /) -> None: ...

    @property
    def watch(self) -> WatchOptions: ...

    @watch.setter
    def watch(self, arg: WatchOptions, /) -> None: ...

    @property
    def release(self) -> float:
        """from a fault or a pedal to zero force [s]"""

    @release.setter
    def release(self, arg: float, /) -> None: ...

    @property
    def settle(self) -> float:
        """all must be well for so long after a fault [s]"""

    @settle.setter
    def settle(self, arg: float, /) -> None: ...

    @property
    def lag_most(self) -> float:
        """of a follower behind its goal [m]"""

    @lag_most.setter
    def lag_most(self, arg: float, /) -> None: ...

    @property
    def slowest(self) -> float:
        """periods of the cycle between two states of the leader, in the mean"""

    @slowest.setter
    def slowest(self, arg: float, /) -> None: ...

class CrtkGates:
    """What the console and the arms say about themselves; unknown is no."""

    def __init__(self) -> None: ...

    @property
    def following(self) -> bool: ...

    @following.setter
    def following(self, arg: bool, /) -> None: ...

    @property
    def operator_present(self) -> bool: ...

    @operator_present.setter
    def operator_present(self, arg: bool, /) -> None: ...

    @property
    def clutch(self) -> bool: ...

    @clutch.setter
    def clutch(self, arg: bool, /) -> None: ...

    @property
    def leader_enabled(self) -> bool: ...

    @leader_enabled.setter
    def leader_enabled(self, arg: bool, /) -> None: ...

    @property
    def follower_enabled(self) -> bool: ...

    @follower_enabled.setter
    def follower_enabled(self, arg: bool, /) -> None: ...

    @property
    def second_writer(self) -> bool: ...

    @second_writer.setter
    def second_writer(self, arg: bool, /) -> None: ...

    @property
    def other_teleop(self) -> bool: ...

    @other_teleop.setter
    def other_teleop(self, arg: bool, /) -> None: ...

    @property
    def frame_unsure(self) -> bool: ...

    @frame_unsure.setter
    def frame_unsure(self, arg: bool, /) -> None: ...

    @property
    def guarded(self) -> bool: ...

    @guarded.setter
    def guarded(self, arg: bool, /) -> None: ...

class CrtkCycle:
    """Stamped messages in, a wrench for the leader out; no network in it."""

    def __init__(self, options: CrtkOptions, follower: Arm | None = None) -> None: ...

    def leader_pose(
        self,
        stamp: float,
        p_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        quat_xyzw: Annotated[NDArray[numpy.float64], "(4,)"],
        t: float,
        wall: float,
    ) -> None: ...

    def leader_twist(
        self,
        stamp: float,
        v_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        w_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        t: float,
        wall: float,
    ) -> None: ...

    def leader_joints(self, stamp: float, q: Annotated[NDArray[numpy.float64], "(:,)"]) -> None: ...

    def gripper(self, stamp: float, q: Annotated[NDArray[numpy.float64], "(:,)"]) -> None: ...

    def follower_pose(
        self,
        stamp: float,
        p_BT: Annotated[NDArray[numpy.float64], "(3,)"],
        quat_xyzw: Annotated[NDArray[numpy.float64], "(4,)"],
        t: float,
        wall: float,
    ) -> None: ...

    def follower_joints(
        self,
        stamp: float,
        q: Annotated[NDArray[numpy.float64], "(:,)"],
        t: float,
        wall: float,
    ) -> None: ...

    def jaw(self, stamp: float, q: Annotated[NDArray[numpy.float64], "(:,)"]) -> None: ...

    def set_scale(self, scale: float) -> None:
        """Motion scale of somebody else's teleoperation."""

    def set_gates(self, gates: CrtkGates) -> None: ...

    def set_controls(self, controls: Controls) -> None: ...

    def set_scene(self, snapshot: Snapshot) -> None: ...

    def drop(self) -> None:
        """Somebody else has put the force to zero."""

    def step(
        self,
        t: float,
        wall: float,
    ) -> tuple[NDArray[numpy.float64], Annotated[NDArray[numpy.float64], "(6,)"] | None, Annotated[NDArray[numpy.float64], "(4, 4)"] | None, float]:
        """
        One tick: (row, wrench (6,) or None when nothing may be sent, goal (4, 4) or None, jaw).
        """
