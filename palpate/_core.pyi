# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""
Palpate's C++ core: the stages of the haptic cycle (see ARCHITECTURE.md).
"""

from collections.abc import Mapping as _Mapping, Sequence
import enum
from typing import Annotated, Any, Literal, overload

import numpy
import numpy.typing
from numpy.typing import NDArray


class LiveOptions:
    """Limits of the motion of an object whose pose is set live."""

    def __init__(
        self,
        speed: float = 0.1,
        turn: float = 1.05,
        acceleration: float = 0.5,
        max_age: float = 0.2,
        fade: float = 0.5,
        p_OC: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        gain: float = 8.0,
    ) -> None:
        """
        speed [m/s], turn [rad/s], acceleration [m/s^2]; max_age: age of the target above which it is lost [s]; fade:
        time in which the force of a lost object falls to zero [s]; p_OC: centre of rotation (3,) [m]; gain: speed per
        remaining displacement near the target [1/s].
        """

    @property
    def speed(self) -> float:
        """Largest speed of the centre [m/s]."""

    @property
    def max_age(self) -> float:
        """Age of the target above which it is lost [s]."""

    @property
    def fade(self) -> float:
        """Time in which the force of a lost object falls to zero [s]."""

class Approach:
    """Rate-limited motion of a live object towards its target."""

    def __init__(self, X_WO: Annotated[NDArray[numpy.float64], "(4, 4)"], t: float = 0.0) -> None:
        """At rest at X_WO (4, 4) [m] at the time t [s]."""

    def step(
        self,
        t: float,
        options: LiveOptions,
        X_WO: Annotated[NDArray[numpy.float64], "(4, 4)"],
        V_WO: Annotated[NDArray[numpy.float64], "(6,)"] = ...,
        lost: bool = False,
        t_target: float = float('nan'),
    ) -> None:
        """
        Moves to the time t [s] towards the pose X_WO (4, 4) [m], valid at t_target [s]; at t when left out.
        """

    @property
    def X_WO(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose (4, 4) [m]."""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Velocity of the centre (3,) [m/s]."""

    @property
    def w(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Angular velocity (3,) [rad/s]."""

    @property
    def lost(self) -> bool:
        """True while the target is lost."""

    @property
    def share(self) -> float:
        """Share of its stiffness that the object renders [-]."""

class LiveTargets:
    """Poses that the live objects of a snapshot shall reach; tracked frames."""

    def __init__(self) -> None: ...

    def add(
        self,
        t: float,
        X_WO: Annotated[NDArray[numpy.float64], "(4, 4)"],
        V_WO: Annotated[NDArray[numpy.float64], "(6,)"] = ...,
        lost: bool = False,
    ) -> None:
        """
        Adds the target of the next live object: pose X_WO (4, 4) [m] at t [s], with the velocity V_WO (6,) of its
        origin and its angular velocity [m/s, rad/s]. lost: the pose is no longer trusted.
        """

    def add_frame(self, X_WF: Annotated[NDArray[numpy.float64], "(4, 4)"], t_seen: float, lost: bool) -> None:
        """
        Adds a tracked frame for the record: last good pose X_WF (4, 4) [m], its time [s], -inf if none was seen.
        """

MAX_LIVE: int = 8

class MeshReport:
    """
    Counts of the defects that were found and repaired while a mesh was built.
    """

    @property
    def vertices(self) -> int:
        """Number of vertices after welding."""

    @property
    def triangles(self) -> int:
        """Number of triangles kept."""

    @property
    def degenerate(self) -> int:
        """
        Triangles dropped because a corner is repeated or all three are on a line.
        """

    @property
    def duplicate(self) -> int:
        """
        Triangles dropped because another one has the same corners in the same winding.
        """

    @property
    def flat(self) -> int:
        """
        Triangles kept although their corners are on a line, because they close a gap.
        """

    @property
    def parts(self) -> int:
        """
        Number of connected parts; triangles that share a vertex belong to one part.
        """

    @property
    def boundary_edges(self) -> int:
        """Edges of only one triangle: holes and rims."""

    @property
    def branching_edges(self) -> int:
        """Edges of three triangles or more."""

    @property
    def inconsistent_edges(self) -> int:
        """Edges whose triangles have opposite windings."""

    @property
    def turned(self) -> int:
        """
        Triangles turned because they faced the other way than their neighbours.
        """

    @property
    def inverted(self) -> int:
        """Triangles turned because their closed part was inside out."""

    @property
    def two_sided(self) -> bool:
        """
        False if a part cannot be oriented, such as a Moebius strip; forces may point inwards there.
        """

    @property
    def closed(self) -> bool:
        """True without boundary, branching and inconsistent edges."""

    @property
    def volume(self) -> float:
        """Volume of the closed parts [m^3]."""

    @property
    def lowest(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Lowest corner of the bounding box (3,) [m]."""

    @property
    def highest(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Highest corner of the bounding box (3,) [m]."""

class Surface:
    """
    A surface that the tool can touch: a mesh, a primitive or a distance field.
    """

    def nearest(
        self,
        points: Annotated[NDArray[numpy.float64], "(:, 3)"],
    ) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]]:
        """
        Nearest points of the surface for points (n, 3) [m]: (signed distance (n,) [m], unsigned for an open surface;
        nearest point (n, 3) [m]; outward normal (n, 3)).
        """

    @property
    def deforms(self) -> bool:
        """True if the surface gives way to the tool as a soft body."""

class Welded:
    """Triangles whose equal vertices are one: a mesh in the making."""

    def __init__(
        self,
        vertices: Annotated[NDArray[numpy.float64], "(:, 3)"],
        triangles: Annotated[NDArray[numpy.int32], "(:, 3)"],
    ) -> None:
        """
        vertices (n, 3) [m], triangles (m, 3) int32, which are not needed any more. Raises ValueError as `Mesh`.
        """

    def mesh(self) -> Mesh:
        """
        Builds the mesh, which takes the triangles over. Raises ValueError as `Mesh`.
        """

class Mesh(Surface):
    """
    A triangle mesh for contact: welded, with normals, adjacency and a bounding volume hierarchy.
    """

    def __init__(
        self,
        vertices: Annotated[NDArray[numpy.float64], "(:, 3)"],
        triangles: Annotated[NDArray[numpy.int32], "(:, 3)"],
    ) -> None:
        """
        vertices (n, 3) [m], triangles (m, 3) int32. Raises ValueError, which names the defect, if they are no mesh.
        """

    @staticmethod
    def from_image(bytes: Annotated[NDArray[numpy.uint8], "(:,)"]) -> Mesh:
        """
        The mesh of `image()`, whose arrays stay in the bytes (n,): nothing may change them afterwards. Raises
        ValueError if the bytes are incomplete or damaged.
        """

    def image(self) -> NDArray[numpy.uint8]:
        """
        The mesh and its index as bytes (n,), valid on this machine and in this version.
        """

    def image_pieces(self) -> list[Annotated[NDArray[numpy.uint8], "read-only"]]:
        """
        The bytes of `image()` as arrays (n,) in their order, of which the long ones are those of the mesh.
        """

    @property
    def triangle_count(self) -> int:
        """Number of triangles."""

    @property
    def report(self) -> MeshReport:
        """Defects found and repaired while the mesh was built."""

    @property
    def vertices(self) -> Annotated[NDArray[numpy.float64], "read-only"]:
        """Welded vertices (n, 3) [m], read-only."""

    @property
    def triangles(self) -> Annotated[NDArray[numpy.int32], "read-only"]:
        """Triangles as indices of the welded vertices (m, 3), read-only."""

    def rims(self) -> NDArray[numpy.int32]:
        """
        Boundary edges (k, 2) as indices of vertices, in the winding of their triangle.
        """

    def closest(
        self,
        points: Annotated[NDArray[numpy.float64], "(:, 3)"],
        max_distance: float = float('inf'),
    ) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.int32]]:
        """
        Closest points on the triangles for points (n, 3) [m]: (distance (n,) [m], point (n, 3) [m], normal (n, 3),
        triangle (n,)). Beyond max_distance [m]: distance inf, triangle -1.
        """

    def sweep(
        self,
        a: Annotated[NDArray[numpy.float64], "(3,)"],
        b: Annotated[NDArray[numpy.float64], "(3,)"],
        radius: float,
    ) -> float:
        """
        Distance [m] that a sphere of this radius [m] moves from a (3,) towards b (3,) until it touches a triangle.
        """

    def closest_by_kernel(
        self,
        points: Annotated[NDArray[numpy.float64], "(:, 3)"],
        kernel: str,
        exact_within: float = float('inf'),
    ) -> NDArray[numpy.float64]:
        """Distances (n,) [m] by the kernel 'avx2' or 'portable', for tests."""

    def contains(self, points: Annotated[NDArray[numpy.float64], "(:, 3)"]) -> NDArray[numpy.bool_]:
        """
        True for each of the points (n, 3) [m] inside the mesh (n,); False for an open mesh.
        """

class Plane(Surface):
    """The half-space z <= 0."""

    def __init__(self) -> None: ...

class Sphere(Surface):
    """A sphere around the origin."""

    def __init__(self, radius: float) -> None:
        """radius [m]."""

class Box(Surface):
    """A box around the origin, with its edges along the axes."""

    def __init__(self, size: Annotated[NDArray[numpy.float64], "(3,)"]) -> None:
        """size: lengths of the edges (3,) [m]."""

class Cylinder(Surface):
    """
    A cylinder around the z axis with flat ends and its centre at the origin.
    """

    def __init__(self, radius: float, length: float) -> None:
        """radius, length [m]."""

class Capsule(Surface):
    """All points within a radius of a segment of the z axis."""

    def __init__(self, radius: float, length: float) -> None:
        """radius [m]; length of the segment [m], its centre at the origin."""

class Cloud(Surface):
    """All points within a radius of a point cloud."""

    def __init__(self, points: Annotated[NDArray[numpy.float64], "(:, 3)"], radius: float) -> None:
        """points (n, 3) [m], radius [m]."""

class ImplicitSurface(Surface):
    """The implicit surface a x^m + b y^n + c z^o = level (Eq 14)."""

    def __init__(
        self,
        coefficients: Annotated[NDArray[numpy.float64], "(3,)"],
        exponents: Sequence[int],
        level: float,
    ) -> None:
        """coefficients (a, b, c), exponents (m, n, o), level."""

    def value(self, p: Annotated[NDArray[numpy.float64], "(3,)"]) -> float:
        """U(p) - level at p (3,) [m]; negative inside."""

    def gradient(self, p: Annotated[NDArray[numpy.float64], "(3,)"]) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Gradient of U at p (3,) [m]: (3,) (Eq 15) [1/m]."""

    @property
    def half(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Half the extent along each axis (3,) [m]."""

class DistanceGrid(Surface):
    """A signed distance sampled on a grid and interpolated tricubically."""

    def __init__(
        self,
        origin: Annotated[NDArray[numpy.float64], "(3,)"],
        spacing: Annotated[NDArray[numpy.float64], "(3,)"],
        values: Annotated[NDArray[numpy.float32], "(:, :, :)"],
    ) -> None:
        """
        origin, spacing (3,) [m]; values (nx, ny, nz) float32 [m]. Raises ValueError if the values are no signed
        distance.
        """

    def value(
        self,
        p: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> tuple[float, Annotated[NDArray[numpy.float64], "(3,)"]]:
        """
        (distance [m], gradient (3,)) of the interpolated function at p (3,) [m].
        """

    @property
    def values(self) -> Annotated[NDArray[numpy.float32], "read-only"]:
        """Signed distances at the nodes (nx, ny, nz) float32 [m], read-only."""

def sample_distance(
    mesh: Mesh,
    origin: Annotated[NDArray[numpy.float64], "(3,)"],
    spacing: Annotated[NDArray[numpy.float64], "(3,)"],
    values: Annotated[NDArray[numpy.float32], "(:, :, :)"],
) -> None:
    """
    Fills values (nx, ny, nz) float32 with the signed distance of a mesh at origin + (i, j, k) * spacing [m]; origin,
    spacing (3,) [m].
    """

CREASE_ANGLE: float = 0.52

def bvh_has_avx2() -> bool:
    """True if the processor supports the AVX2 kernel."""

class Material:
    """
    Stiffness and damping of an object, diagonal along the axes of W, and its friction.
    """

    def __init__(
        self,
        K: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        B: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        mu: float = 0.0,
        mu_static: float = 0.0,
    ) -> None:
        """K (3,) [N/m], B (3,) [N s/m], mu and mu_static [-]."""

    @property
    def K(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Stiffness (3,) [N/m]."""

    @K.setter
    def K(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def B(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Damping (3,) [N s/m]."""

    @B.setter
    def B(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def mu(self) -> float:
        """Coulomb friction coefficient while slipping [-]."""

    @mu.setter
    def mu(self, arg: float, /) -> None: ...

    @property
    def mu_static(self) -> float:
        """
        Coulomb friction coefficient while sticking [-]; values below mu count as mu.
        """

    @mu_static.setter
    def mu_static(self, arg: float, /) -> None: ...

class Region:
    """
    A region of an object with another material: a box with rounded edges, or a ball.
    """

    def __init__(
        self,
        centre: Annotated[NDArray[numpy.float64], "(3,)"],
        half: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        radius: float = 0.0,
        blend: float = 0.001,
        material: Material = ...,
    ) -> None:
        """
        centre (3,), half (3,), radius, blend [m], in O. Raises ValueError if a length is negative or a value not
        finite.
        """

    @property
    def centre(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Centre in O (3,) [m]."""

    @property
    def half(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Half the lengths of the box (3,) [m]; zero: a ball."""

    @property
    def radius(self) -> float:
        """Radius of the ball or of the rounded edges [m]."""

    @property
    def blend(self) -> float:
        """Distance over which the material fades [m]."""

    @property
    def material(self) -> Material:
        """Material inside the region."""

    def weight(self, p_O: Annotated[NDArray[numpy.float64], "(3,)"]) -> float:
        """
        Weight of the region's material at p_O (3,) [m]: 1 inside, 0 farther away than `blend` [-].
        """

class Wave:
    """A sinusoidal component of a Motion."""

    def __init__(
        self,
        shift: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        turn: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        period: float = 1.0,
        phase: float = 0.0,
    ) -> None:
        """
        Amplitudes shift (3,) [m] and turn (3,), a rotation vector [rad]; period [s]; phase [rad].
        """

class Motion:
    """
    Motion of an object from its pose at rest: a constant velocity plus sinusoids.
    """

    def __init__(
        self,
        v: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        w: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        waves: Sequence[Wave] = [],
        about: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
    ) -> None:
        """
        Velocity v (3,) [m/s], angular velocity w (3,) [rad/s], sinusoids, and the centre of rotation about (3,) [m].
        """

    def pose(
        self,
        X_WO: Annotated[NDArray[numpy.float64], "(4, 4)"],
        t: float,
    ) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose (4, 4) [m] at t [s] of an object with the rest pose X_WO."""

class Object:
    """A surface with a pose, a material, and regions of other materials."""

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
        live: LiveOptions | None = None,
    ) -> None:
        """
        is_virtual: the contact stage renders it. is_real: it stops the tool of a driven follower. live: its pose is set
        while a loop runs (set_live).
        """

    @property
    def name(self) -> str:
        """Name of the object."""

    @property
    def surface(self) -> Surface:
        """Surface, in O."""

    @property
    def X_WO(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose in W at rest (4, 4)."""

    @X_WO.setter
    def X_WO(self, arg: Annotated[NDArray[numpy.float64], "(4, 4)"], /) -> None: ...

    @property
    def material(self) -> Material:
        """Material outside the regions."""

    @material.setter
    def material(self, arg: Material, /) -> None: ...

    @property
    def is_live(self) -> bool:
        """True if its pose is set while a loop runs."""

    def pose(self, t: float) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose X_WO (4, 4) at t [s]."""

    def velocity(
        self,
        p_W: Annotated[NDArray[numpy.float64], "(3,)"],
        t: float,
    ) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """
        Velocity (3,) [m/s] of the material point that is at p_W (3,) [m] at t [s].
        """

    def feel(
        self,
        p_O: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> tuple[Material, Annotated[NDArray[numpy.float64], "(3, 3)"]]:
        """
        Material at p_O (3,) [m], regions included: (material, gradients of K (3, 3), one row for each entry of K
        [N/m^2]).
        """

MAX_OBJECTS: int = 512

class Snapshot:
    """The objects of a scene; immutable during a tick, replaced as a whole."""

    def __init__(self, objects: Sequence[Object]) -> None:
        """
        Raises ValueError if there are too many objects; the message states the limit.
        """

    @property
    def objects(self) -> list[Object]:
        """The objects, in order."""

class ToolSphere:
    """A sphere of the tool, in addition to the SPR on its tip."""

    def __init__(
        self,
        p: Annotated[NDArray[numpy.float64], "(3,)"],
        radius: float,
        link: int = -1,
        hinge: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        turn: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
    ) -> None:
        """
        hinge, turn: of a sphere on a jaw, a point on the jaw's axis (3,) [m] and the axis times the rotation per jaw
        angle (3,) [-], in the link's frame.
        """

    @property
    def p(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Centre in the link's frame with the jaws closed (3,) [m]."""

    @property
    def radius(self) -> float:
        """Radius [m]."""

    @property
    def link(self) -> int:
        """
        Index of the follower's link that carries the sphere; negative: the tool tip T.
        """

    def centre(self, jaw: float) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Centre in the link's frame with the jaws open by `jaw` [rad] (3,) [m]."""

class ContactOptions:
    """Options of the contact stage."""

    def __init__(self) -> None: ...

    @property
    def radius(self) -> float:
        """Radius of the spherical proxy region (SPR) on the tool tip [m]."""

    @radius.setter
    def radius(self, arg: float, /) -> None: ...

    @property
    def release(self) -> float:
        """
        Deflection above which a tool that passed through a closed object is released, for the method `proxy` [m].
        """

    @release.setter
    def release(self, arg: float, /) -> None: ...

    @property
    def collision_rate(self) -> float:
        """Rate of the collision thread, for the paper's methods [Hz]."""

    @collision_rate.setter
    def collision_rate(self, arg: float, /) -> None: ...

    @property
    def real(self) -> bool:
        """True: the tool touches the real objects, not the virtual ones."""

    @real.setter
    def real(self, arg: bool, /) -> None: ...

    @property
    def objects(self) -> int:
        """Largest number of objects in a scene."""

    @objects.setter
    def objects(self, arg: int, /) -> None: ...

    @property
    def spheres(self) -> list[ToolSphere]:
        """
        Spheres of the tool in addition to the SPR. This is a copy: assign a whole list.
        """

    @spheres.setter
    def spheres(self, arg: Sequence[ToolSphere], /) -> None: ...

class Friction:
    """Coulomb friction of one proxy, with sticking and slipping."""

    def __init__(self) -> None: ...

    def step(
        self,
        x: Annotated[NDArray[numpy.float64], "(3,)"],
        normal: Annotated[NDArray[numpy.float64], "(3,)"],
        depth: float,
        mu: float,
        mu_static: float,
        k: float = 1.0,
        dt: float = 1000.0,
    ) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """
        Distance (3,) [m] by which friction holds the tool back; the force is k times that. x: tool (3,) [m]; normal:
        unit (3,); depth [m]; mu, mu_static [-]; k: stiffness [N/m]; dt: time since the last step [s], by default long
        enough to break away at once.
        """

    @property
    def slipping(self) -> bool:
        """True while the proxy slips."""

MAX_SPHERES: int = 16

def contact_methods() -> list[str]:
    """Names of the contact methods, the default first."""

def contact_check(method: str, options: ContactOptions, snapshot: Snapshot) -> None:
    """
    Raises ValueError if the method does not exist or cannot render an object of the scene.
    """

def region_pull(object: Object) -> tuple[int, str] | None:
    """
    Index of the region of an object that would pull the tool in the most, and what to change; None if none does.
    """

def contact_render(
    snapshot: Snapshot,
    tips: Annotated[NDArray[numpy.float64], "(:, 3)"],
    method: str,
    options: ContactOptions,
    rate: float,
    poses: Annotated[NDArray[numpy.float64], "(:, 4, 4)"] | None = None,
) -> tuple[
    NDArray[numpy.float64],
    NDArray[numpy.float64],
    NDArray[numpy.float64],
    NDArray[numpy.float64],
    NDArray[numpy.float64],
    bool,
    NDArray[numpy.float64],
]:
    """
    Runs the stages contact and force along a tool path p_WT (n, 3) [m], sampled at rate [Hz]. poses: X_WO (n, 4, 4) of
    the scene's only object. Returns force (n, 3) [N], normal (n, 3), depth (n,) [m], proxy (n, 3) [m], latency (n,)
    [s], started_inside, torque (n, 3) [N m]; all in W.
    """

CONE_HALF_ANGLE: float = 0.2617993877991494

class Frame:
    """A frame to which a geometry is attached."""

    def at(
        self,
        t: float,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(4, 4)"], Annotated[NDArray[numpy.float64], "(6,)"]]:
        """
        (X_WF (4, 4), V_WF (6,)) at t [s]: pose, and velocity of its origin [m/s] over angular velocity [rad/s].
        """

class MotionFrame(Frame):
    """A frame that moves like an object of the scene."""

    def __init__(self, X_WF: Annotated[NDArray[numpy.float64], "(4, 4)"] = ..., motion: Motion = ...) -> None:
        """X_WF (4, 4): pose at rest; motion: motion from that pose."""

class LiveFrame(Frame):
    """
    A frame whose poses come from outside the loop, such as from a tracker.
    """

    def __init__(self) -> None: ...

    @overload
    def set(self, X_WF: Annotated[NDArray[numpy.float64], "(4, 4)"]) -> None:
        """
        Sets the pose X_WF (4, 4); the velocity follows from successive poses. Call it from one thread only.
        """

    @overload
    def set(self, X_WF: Annotated[NDArray[numpy.float64], "(4, 4)"], V_WF: numpy.typing.ArrayLike) -> None:
        """
        Sets the pose X_WF (4, 4) and the velocity V_WF (6,): linear [m/s] over angular [rad/s].
        """

    @property
    def has_pose(self) -> bool:
        """True once a pose has been received."""

class GuidanceRoleOptions:
    """Options of all guidance roles; each role reads its own."""

    def __init__(self) -> None: ...

    @property
    def margin(self) -> float:
        """guide: free play; forbid, keep-in: clearance from the surface [m]."""

    @margin.setter
    def margin(self, arg: float, /) -> None: ...

    @property
    def angle(self) -> float:
        """orient: angle that the tool may tilt freely [rad]."""

    @angle.setter
    def angle(self, arg: float, /) -> None: ...

    @property
    def axis(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """
        orient, rcm: axis of the tool, in T, that is oriented or slides through the point (3,).
        """

    @axis.setter
    def axis(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def target(self) -> Literal['axis', 'normal', 'frame']:
        """
        orient: target, the 'axis', the 'normal' or the whole 'frame' of the geometry.
        """

    @target.setter
    def target(self, name: Literal['axis', 'normal', 'frame'], /) -> None: ...

    @property
    def speed(self) -> float:
        """limit: largest speed of the tool [m/s]; 0: no limit."""

    @speed.setter
    def speed(self, arg: float, /) -> None: ...

    @property
    def force(self) -> float:
        """limit: largest contact force on the tool [N]; 0: no limit."""

    @force.setter
    def force(self, arg: float, /) -> None: ...

class GuidanceLawOptions:
    """Options of all guidance laws; each law reads its own."""

    def __init__(self) -> None: ...

    @property
    def K(self) -> float:
        """Stiffness on the tool's side [N/m]."""

    @K.setter
    def K(self, arg: float, /) -> None: ...

    @property
    def B(self) -> float:
        """Damping [N s/m]."""

    @B.setter
    def B(self, arg: float, /) -> None: ...

    @property
    def K_turn(self) -> float:
        """Rotational stiffness [N m/rad]."""

    @K_turn.setter
    def K_turn(self, arg: float, /) -> None: ...

    @property
    def B_turn(self) -> float:
        """Rotational damping [N m s/rad]."""

    @B_turn.setter
    def B_turn(self, arg: float, /) -> None: ...

    @property
    def force(self) -> float:
        """potential, optimise: largest force [N]."""

    @force.setter
    def force(self, arg: float, /) -> None: ...

    @property
    def moment(self) -> float:
        """potential, optimise: largest moment [N m]."""

    @moment.setter
    def moment(self, arg: float, /) -> None: ...

    @property
    def range(self) -> float:
        """potential: distance from which it attracts or repels [m]."""

    @range.setter
    def range(self, arg: float, /) -> None: ...

    @property
    def range_turn(self) -> float:
        """potential: angle from which it attracts [rad]."""

    @range_turn.setter
    def range_turn(self, arg: float, /) -> None: ...

    @property
    def ratio(self) -> float:
        """
        admittance: speed in the constrained directions per speed in the free ones, 0.01-1 [-].
        """

    @ratio.setter
    def ratio(self, arg: float, /) -> None: ...

class Ramp:
    """
    Scales the authority of a fixture with a measured value: 0 at `start`, 1 at `end`, linear between.
    """

    def __init__(self, by: str = 'pedal', start: float = 0.0, end: float = 1.0) -> None:
        """start may be larger than end."""

    @property
    def by(self) -> str:
        """
        Measured value: 'pedal' [0-1], 'distance' [m, rad], 'time' since the fixture was engaged [s] or 'force' of the
        operator [N].
        """

    @property
    def start(self) -> float:
        """Value at which the authority is 0."""

    @property
    def end(self) -> float:
        """Value at which the authority is 1."""

class Policy:
    """When and with how much authority a fixture acts."""

    def __init__(self) -> None: ...

    @property
    def hard(self) -> bool:
        """True: the tool's goal is corrected as well."""

    @hard.setter
    def hard(self, arg: bool, /) -> None: ...

    @property
    def authority(self) -> float:
        """Authority, 0-1; the ramps multiply it [-]."""

    @authority.setter
    def authority(self, arg: float, /) -> None: ...

    @property
    def priority(self) -> int:
        """Priority; the force of a lower one never opposes that of a higher one."""

    @priority.setter
    def priority(self, arg: int, /) -> None: ...

    @property
    def engage(self) -> float:
        """|gap| below which the fixture engages [m, rad]."""

    @engage.setter
    def engage(self, arg: float, /) -> None: ...

    @property
    def release(self) -> float:
        """|gap| above which the fixture disengages [m, rad]."""

    @release.setter
    def release(self, arg: float, /) -> None: ...

    @property
    def rise(self) -> float:
        """Shortest time in which the authority rises from 0 to 1 [s]."""

    @rise.setter
    def rise(self, arg: float, /) -> None: ...

    @property
    def fall(self) -> float:
        """Shortest time in which the authority falls from 1 to 0 [s]."""

    @fall.setter
    def fall(self, arg: float, /) -> None: ...

    @property
    def ramps(self) -> list[Ramp]:
        """Ramps that scale the authority. This is a copy: assign a whole list."""

    @ramps.setter
    def ramps(self, arg: Sequence[Ramp], /) -> None: ...

class GuidanceOptions:
    """Options of the stage `guidance`."""

    def __init__(self) -> None: ...

    @property
    def force_rate(self) -> float:
        """
        Largest rate of the force change that no motion causes, such as after a switch or an edit [N/s].
        """

    @force_rate.setter
    def force_rate(self, arg: float, /) -> None: ...

    @property
    def moment_rate(self) -> float:
        """Largest rate of the moment change that no motion causes [N m/s]."""

    @moment_rate.setter
    def moment_rate(self, arg: float, /) -> None: ...

    @property
    def return_speed(self) -> float:
        """
        Speed at which the goal leaves a region that has just become forbidden [m/s].
        """

    @return_speed.setter
    def return_speed(self, arg: float, /) -> None: ...

    @property
    def reserve(self) -> float:
        """
        Distance that hard fixtures keep between the goal and their boundary [m].
        """

    @reserve.setter
    def reserve(self, arg: float, /) -> None: ...

    @property
    def servo_bandwidth(self) -> float:
        """
        Bandwidth of the follower's servos [Hz]; 0: ideal; negative: that of the simulated follower.
        """

    @servo_bandwidth.setter
    def servo_bandwidth(self, arg: float, /) -> None: ...

    @property
    def servo_damping(self) -> float:
        """Damping ratio of the follower's servos [-]."""

    @servo_damping.setter
    def servo_damping(self, arg: float, /) -> None: ...

class FixtureList:
    """Fixtures as a loop takes them; this base class has none."""

    def __init__(self, tool: LiveFrame | None = None) -> None:
        """tool: a frame that receives the tool's pose at every tick."""

    def __len__(self) -> int: ...

class MappingLaw(enum.Enum):
    """Motion of the tool in addition to that of the hand."""

    position = 0
    """None: the hand moves the tool."""

    rate = 1
    """Near the rim of the workspace the tool continues outwards by itself."""

    drift = 2
    """While the hand moves, the tool drifts outwards."""

class RecentringOptions:
    """Motion of the tool in addition to that of the hand."""

    def __init__(self) -> None: ...

    @property
    def law(self) -> MappingLaw:
        """The law."""

    @law.setter
    def law(self, arg: MappingLaw, /) -> None: ...

    @property
    def workspace(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Lengths (3,) of the workspace along the axes of L [m]."""

    @workspace.setter
    def workspace(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def centre(self) -> Annotated[NDArray[numpy.float64], "(3,)"] | None:
        """
        Centre (3,) of the workspace in L [m]; None: the first position of the handle.
        """

    @centre.setter
    def centre(self, arg: Annotated[NDArray[numpy.float64], "(3,)"] | None, /) -> None: ...

    @property
    def rim(self) -> float:
        """
        rate: distance from the centre at which it begins, 1 at the edge of the workspace [-].
        """

    @rim.setter
    def rim(self, arg: float, /) -> None: ...

    @property
    def rim_speed(self) -> float:
        """rate: speed of the tool at the edge, the largest [m/s]."""

    @rim_speed.setter
    def rim_speed(self, arg: float, /) -> None: ...

    @property
    def drift(self) -> float:
        """
        drift: its speed at the edge over the speed of the tool by the hand [-].
        """

    @drift.setter
    def drift(self, arg: float, /) -> None: ...

class MappingOptions:
    """Options of the stage `mapping` between hand and tool."""

    def __init__(self) -> None: ...

    @property
    def scale(self) -> float:
        """
        Tool motion per hand motion [-]; the hand feels the stiffness force_scale * scale * K.
        """

    @scale.setter
    def scale(self, arg: float, /) -> None: ...

    @property
    def force_scale(self) -> float:
        """Force on the hand per force on the tool [-]."""

    @force_scale.setter
    def force_scale(self, arg: float, /) -> None: ...

    @property
    def align_rate(self) -> float:
        """
        Rate at which an orientation offset decays [rad/s]; 0: the offset stays.
        """

    @align_rate.setter
    def align_rate(self, arg: float, /) -> None: ...

    @property
    def gripper_min(self) -> float:
        """Gripper angle that closes the jaw [rad]."""

    @gripper_min.setter
    def gripper_min(self, arg: float, /) -> None: ...

    @property
    def gripper_max(self) -> float:
        """Gripper angle that opens the jaw [rad]."""

    @gripper_max.setter
    def gripper_max(self, arg: float, /) -> None: ...

    @property
    def jaw_min(self) -> float:
        """Angle of the closed jaw [rad]."""

    @jaw_min.setter
    def jaw_min(self, arg: float, /) -> None: ...

    @property
    def jaw_max(self) -> float:
        """Angle of the open jaw [rad]."""

    @jaw_max.setter
    def jaw_max(self, arg: float, /) -> None: ...

    @property
    def jaw_start(self) -> float:
        """Jaw angle of a simulated follower at the start [rad]."""

    @jaw_start.setter
    def jaw_start(self, arg: float, /) -> None: ...

    @property
    def jaw_rate(self) -> float:
        """Rate at which the jaw approaches the gripper angle [rad/s]."""

    @jaw_rate.setter
    def jaw_rate(self, arg: float, /) -> None: ...

    @property
    def ratchet(self) -> bool:
        """
        True: on engaging, the jaw does not open before the pinch has closed to its angle.
        """

    @ratchet.setter
    def ratchet(self, arg: bool, /) -> None: ...

    @property
    def align_tolerance(self) -> float:
        """
        Orientation error up to which the handle counts as aligned; 0: any [rad].
        """

    @align_tolerance.setter
    def align_tolerance(self, arg: float, /) -> None: ...

    @property
    def recentring(self) -> RecentringOptions:
        """Motion of the tool in addition to that of the hand."""

    @recentring.setter
    def recentring(self, arg: RecentringOptions, /) -> None: ...

class Mapping:
    """
    Stage `mapping`: relative scaled position, absolute orientation, clutch, jaw.
    """

    def __init__(self, options: MappingOptions, R_WL: Annotated[NDArray[numpy.float64], "(3, 3)"], dt: float) -> None:
        """
        R_WL (3, 3): rotation of the leader base in W; dt: period of the cycle [s].
        """

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
        t: float = float('nan'),
        p_LH: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        F_T_W: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        correction_W: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
        lock_rotation: bool = False,
        lock_translation: bool = False,
        t_T_W: Annotated[NDArray[numpy.float64], "(3,)"] = ...,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(4, 4)"], float, Annotated[NDArray[numpy.float64], "(3,)"], bool]:
        """
        One tick: (X_WT_goal (4, 4), jaw [rad], v_WT (3,) [m/s], engaged). reached: the follower could take the last
        goal. t: time, NaN: one period later [s]. p_LH (3,): handle in L [m]; F_T_W (3,): force on the tool [N]; t_T_W
        (3,): moment on it [N m]; correction_W (3,): of the last goal by hard fixtures [m]. Locks: the tool keeps its
        orientation, its position.
        """

    def force_on_hand(
        self,
        F_T_W: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """
        Force F_H_L (3,) on the hand that renders the tool force F_T_W (3,) [N].
        """

    def hand_position(
        self,
        p_WT: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Hand position p_WH (3,) that maps to the tool position p_WT (3,) [m]."""

    @property
    def released(self) -> float:
        """Energy that the recentring released in the last step [J]."""

    @property
    def anchorings(self) -> int:
        """Number of times that the map was re-anchored at the hand and the tool."""

class MomentumObserver:
    """
    Estimates external joint torques r from the drive torques (core/palpate/force/estimate.hpp).
    """

    def __init__(
        self,
        model: Arm,
        drive_inertia: Annotated[NDArray[numpy.float64], "(:, :)"],
        bandwidth: float,
    ) -> None:
        """
        drive_inertia: inertia (n,n) of the drives at the joints [kg m^2, kg]; bandwidth of r [Hz].
        """

    def reset(self) -> None:
        """Resets the observer: the next sample starts at r = 0."""

    def run(
        self,
        q: Annotated[NDArray[numpy.float64], "(:, :)"],
        v: Annotated[NDArray[numpy.float64], "(:, :)"],
        tau: Annotated[NDArray[numpy.float64], "(:, :)"],
        rate: float,
    ) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """
        External joint torques r (k, n) [N m, N] for k samples at rate [Hz]; tau (k, n): drive torques without friction.
        """

class EstimateOptions:
    """Options of the force estimate from the follower's drive torques."""

    def __init__(self) -> None: ...

    @property
    def bandwidth(self) -> float:
        """Bandwidth of the momentum observer [Hz]."""

    @bandwidth.setter
    def bandwidth(self, arg: float, /) -> None: ...

    @property
    def dead_band(self) -> float:
        """
        Dead band of the estimated force: smaller forces are reported as zero [N].
        """

    @dead_band.setter
    def dead_band(self, arg: float, /) -> None: ...

    @property
    def slip_speed(self) -> float:
        """
        Fraction of the drives' speed limits above which dry friction has its full value [-].
        """

    @slip_speed.setter
    def slip_speed(self, arg: float, /) -> None: ...

    @property
    def rotor_inertia(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Rotor inertias at the joints (n,) [kg m^2, kg]."""

    @rotor_inertia.setter
    def rotor_inertia(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Dry friction of the drives (n,) [N m, N]."""

    @coulomb.setter
    def coulomb(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Viscous friction of the drives (n,) [N m s/rad, N s/m]."""

    @viscous.setter
    def viscous(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def offset(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Constant torques of the drives (n,) [N m, N]."""

    @offset.setter
    def offset(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def spring(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Spring constants at the joints (n,) [N m/rad, N/m]."""

    @spring.setter
    def spring(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def links(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Identified inertial parameters (10n,); empty: those of the model."""

    @links.setter
    def links(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class Estimate:
    """
    Estimates the force of the environment on the tool tip from the drive torques.
    """

    def __init__(self, model: Arm, options: EstimateOptions) -> None: ...

    def reset(self) -> None:
        """Resets the momentum observer."""

    def step(
        self,
        t: float,
        q: Annotated[NDArray[numpy.float64], "(:,)"],
        v: Annotated[NDArray[numpy.float64], "(:,)"],
        tau: Annotated[NDArray[numpy.float64], "(:,)"],
    ) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Estimated force F_T_B (3,) [N] for the follower's state at t [s]."""

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
) -> tuple[
    Annotated[NDArray[numpy.float64], "(3,)"],
    Annotated[NDArray[numpy.float64], "(3,)"],
    Annotated[NDArray[numpy.float64], "(3,)"],
    Annotated[NDArray[numpy.float64], "(3,)"],
]:
    """
    Stage `force` for n contacts, given as (n, 3) arrays in W: (F, F_spring, F_damping, torque), each (3,) in W; forces
    [N], torque about T [N m].
    """

class CertainFriction:
    """Certified lower bounds of a device's friction."""

    def __init__(self) -> None: ...

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Coulomb friction (n,) [N m, N]."""

    @coulomb.setter
    def coulomb(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Viscous friction (n,) [N m s/rad, N s/m]."""

    @viscous.setter
    def viscous(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def quantum(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Resolution of the joint positions (n,) [rad, m]."""

    @quantum.setter
    def quantum(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def at_handle(self) -> bool:
        """
        True: the entries (3,) belong to the position of the handle in L, not to joints.
        """

    @at_handle.setter
    def at_handle(self, arg: bool, /) -> None: ...

class StabilityOptions:
    """Options of the stage `stability`, which limits what the hand receives."""

    def __init__(self) -> None: ...

    @property
    def force_cap(self) -> float:
        """Largest force on the hand [N]."""

    @force_cap.setter
    def force_cap(self, arg: float, /) -> None: ...

    @property
    def rate_cap(self) -> float:
        """
        Largest rate of change of the force, also that of the ramp to zero [N/s].
        """

    @rate_cap.setter
    def rate_cap(self, arg: float, /) -> None: ...

    @property
    def moment_cap(self) -> float:
        """Largest moment on the hand [N m]; 0: forces only."""

    @moment_cap.setter
    def moment_cap(self, arg: float, /) -> None: ...

    @property
    def moment_rate_cap(self) -> float:
        """Largest rate of change of the moment [N m/s]."""

    @moment_rate_cap.setter
    def moment_rate_cap(self, arg: float, /) -> None: ...

    @property
    def gripper_cap(self) -> float:
        """
        Largest torque on the operator's fingers; 0: the gripper has no motor [N m].
        """

    @gripper_cap.setter
    def gripper_cap(self, arg: float, /) -> None: ...

    @property
    def stale_after(self) -> float:
        """Age above which measured states are not trusted [s]."""

    @stale_after.setter
    def stale_after(self, arg: float, /) -> None: ...

    @property
    def passivity(self) -> Literal['observer', 'tank', 'off']:
        """Mode of the passivity controller: 'observer', 'tank' or 'off'."""

    @passivity.setter
    def passivity(self, mode: Literal['observer', 'tank', 'off'], /) -> None: ...

    @property
    def friction(self) -> CertainFriction:
        """Certified friction of the device. This is a copy: assign a whole one."""

    @friction.setter
    def friction(self, arg: CertainFriction, /) -> None: ...

    @property
    def low_pass(self) -> float:
        """
        Cutoff of the low-pass on the force to be rendered [Hz]; 0: no low-pass.
        """

    @low_pass.setter
    def low_pass(self, arg: float, /) -> None: ...

    @property
    def coupling_stiffness(self) -> float:
        """Stiffness of the virtual coupling [N/m]; 0: no coupling."""

    @coupling_stiffness.setter
    def coupling_stiffness(self, arg: float, /) -> None: ...

    @property
    def coupling_damping(self) -> float:
        """Damping of the virtual coupling, in parallel with its spring [N s/m]."""

    @coupling_damping.setter
    def coupling_damping(self, arg: float, /) -> None: ...

    @property
    def delay(self) -> float:
        """Known delay of the loop [s]."""

    @delay.setter
    def delay(self, arg: float, /) -> None: ...

    @property
    def quantum(self) -> float:
        """Resolution of the handle's position [m]."""

    @quantum.setter
    def quantum(self, arg: float, /) -> None: ...

    @property
    def allowance(self) -> float:
        """
        Energy that may be returned in excess of the certified input energy [J].
        """

    @allowance.setter
    def allowance(self, arg: float, /) -> None: ...

    @property
    def acceleration(self) -> float:
        """Largest assumed acceleration of the handle [m/s^2]."""

    @acceleration.setter
    def acceleration(self, arg: float, /) -> None: ...

    @property
    def angular_acceleration(self) -> float:
        """Largest assumed angular acceleration of the handle [rad/s^2]."""

    @angular_acceleration.setter
    def angular_acceleration(self, arg: float, /) -> None: ...

    @property
    def delay_doubt(self) -> float:
        """The true delay may exceed `delay` by up to this time [s]."""

    @delay_doubt.setter
    def delay_doubt(self, arg: float, /) -> None: ...

    @property
    def tank_capacity(self) -> float:
        """
        Capacity of the energy tank, and bound of the outstanding credit in all modes [J].
        """

    @tank_capacity.setter
    def tank_capacity(self, arg: float, /) -> None: ...

    @property
    def moving_share(self) -> float:
        """
        Fraction of the work of moving surfaces and other instruments that the hand may receive.
        """

    @moving_share.setter
    def moving_share(self, arg: float, /) -> None: ...

    @property
    def speed(self) -> float:
        """
        Fastest motion along the largest force for which the account keeps a reserve [m/s].
        """

    @speed.setter
    def speed(self, arg: float, /) -> None: ...

    @property
    def angular_speed(self) -> float:
        """
        Fastest rotation along the largest moment for which the account keeps a reserve [rad/s].
        """

    @angular_speed.setter
    def angular_speed(self, arg: float, /) -> None: ...

def low_pass_share(cutoff: float, dt: float) -> float:
    """
    Coefficient a of the low-pass y_k = y_k-1 + a (u_k - y_k-1). cutoff [Hz], 0: no low-pass; dt [s].
    """

def recursion_by_kernel(
    xml: str,
    base_frame: str,
    tip_frame: str,
    q: numpy.typing.ArrayLike,
    v: numpy.typing.ArrayLike,
    kernel: str,
) -> bytes:
    """
    All results of the recursion at (q, v, a = v) as bytes, by the build 'avx512', 'avx2' or 'portable' (tests).
    """

class IkOptions:
    """When the inverse kinematics stops."""

    def __init__(self) -> None: ...

    @property
    def max_iterations(self) -> int:
        """Largest number of iterations."""

    @max_iterations.setter
    def max_iterations(self, arg: int, /) -> None: ...

    @property
    def position_tolerance(self) -> float:
        """Position error accepted as converged [m]."""

    @position_tolerance.setter
    def position_tolerance(self, arg: float, /) -> None: ...

    @property
    def orientation_tolerance(self) -> float:
        """Orientation error accepted as converged [rad]."""

    @orientation_tolerance.setter
    def orientation_tolerance(self, arg: float, /) -> None: ...

    @property
    def damping(self) -> float:
        """Smallest damping; the damping grows with the remaining error."""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...

class IkResult:
    """Outcome of an inverse kinematics run."""

    @property
    def converged(self) -> bool:
        """True if both errors are within their tolerances."""

    @property
    def iterations(self) -> int:
        """Number of iterations."""

    @property
    def position_error(self) -> float:
        """Remaining position error [m]."""

    @property
    def orientation_error(self) -> float:
        """Remaining orientation error [rad]."""

    @property
    def damping(self) -> float:
        """Damping of the last step; large near singularities and out of reach."""

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
        """
        Indices of the joints J (d,), from zero; centres z (c, d) and lengths l (d,) [rad, m].
        """

    @property
    def joints(self) -> list[int]:
        """Indices of the joints (d,), from zero."""

    @property
    def centres(self) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """Centres of the Gaussians (c, d) [rad, m]."""

    @property
    def length(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Length scales of the Gaussians (d,) [rad, m]."""

class GravityTerms:
    """The columns of a gravity model: masses, powers of joints, fields."""

    def __init__(self, masses: bool = True, degree: int = -1, fields: Sequence[Field] = []) -> None:
        """
        masses: four columns per link; degree: of the polynomials, -1: none; fields: one column per centre.
        """

    @property
    def masses(self) -> bool:
        """True: four columns per link, for its mass and its first moments."""

    @property
    def degree(self) -> int:
        """Degree of the polynomial in each joint; -1: no polynomials."""

    @property
    def fields(self) -> list[Field]:
        """Gaussian fields; each has one column per centre."""

class Arm:
    """Kinematics and dynamics of an arm in its base frame. See palpate.Arm."""

    @overload
    def __init__(self, xml: str, base_frame: str, tip_frame: str) -> None:
        """
        Makes an arm from the text of a URDF: the chain from base_frame to tip_frame.
        """

    @overload
    def __init__(self, kind: str, parameters: _Mapping[str, Sequence[float]]) -> None:
        """
        Makes a device that has closed-form kinematics, such as 'delta', from its parameters by name.
        """

    @property
    def n(self) -> int:
        """Number of joints."""

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints."""

    @property
    def link_names(self) -> list[str]:
        """Names of the links."""

    @property
    def q_min(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Lower joint limits (n,) [rad, m]."""

    @property
    def q_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Upper joint limits (n,) [rad, m]."""

    @property
    def tau_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Torque limits of the drives (n,) [N m, N]."""

    @property
    def v_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Speed limits of the joints (n,) [rad/s, m/s]."""

    @property
    def orients(self) -> bool:
        """True if the joints can orient the tip; False if they only position it."""

    @property
    def segments(self) -> list[tuple[str, Annotated[NDArray[numpy.float64], "(3,)"]]]:
        """
        Line segments for drawing the arm: (name of the link, end of the segment in the link's axes (3,) [m]).
        """

    def fk(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose X_0T (4,4) of the tip in the base frame at q (n,) [rad, m]."""

    def jacobian(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """Jacobian (6,n) at the tip in base axes, linear rows over angular rows."""

    def ik_from(
        self,
        X_0T: Annotated[NDArray[numpy.float64], "(4, 4)"],
        q0: numpy.typing.ArrayLike,
        options: IkOptions = ...,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(:,)"], IkResult]:
        """
        One damped Newton run from q0 (n,): (q (n,), IkResult). palpate.Arm.ik restarts it and raises an error.
        """

    def link_poses_array(
        self,
        q: Annotated[NDArray[numpy.float64], "(:, :)"],
    ) -> Annotated[NDArray[numpy.float64], "(:, :, :, :)"]:
        """
        Poses (k, links, 4, 4) in the base frame at each row of q (k, n), in the order of link_names.
        """

    def gravity(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """
        Torques G(q) = dP/dq (n,) that balance the weight of the links [N m, N].
        """

    def elastic(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """
        Torques (n,) that balance the counterbalance spring and the cables [N m, N].
        """

    def holding(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """
        Torques (n,) that hold the arm still, by the identified gravity model or by gravity and counterbalance [N m, N].
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
        """Mass matrix M(q) (n,n), symmetric, without the rotor inertias."""

    def dynamics(
        self,
        q: numpy.typing.ArrayLike,
        v: numpy.typing.ArrayLike,
    ) -> tuple[
        Annotated[NDArray[numpy.float64], "(:, :)"],
        Annotated[NDArray[numpy.float64], "(:,)"],
        Annotated[NDArray[numpy.float64], "(4, 4)"],
        Annotated[NDArray[numpy.float64], "(:, :)"],
        Annotated[NDArray[numpy.float64], "(:,)"],
    ]:
        """
        All terms that a simulated arm needs: (M (n,n), C v + G (n,), X_0T (4,4), J (6,n), dJ/dt v (6,)).
        """

    def potential_energy(self, q: numpy.typing.ArrayLike) -> float:
        """Potential energy P(q) of the links' weight [J]."""

    def elastic_energy(self, q: numpy.typing.ArrayLike) -> float:
        """Potential energy P(q) of the counterbalance spring and the cables [J]."""

    def set_counterbalance(self, torque: float, along: numpy.typing.ArrayLike) -> None:
        """
        Sets a spring with potential P = -torque sin(along . q): torque [N m], along (n,). Torque 0 removes the spring.
        """

    def gravity_regressor(self, q: numpy.typing.ArrayLike) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """
        Regressor Y(q) (n,4n): gravity = Y Pi, Pi = (m, m c_x, m c_y, m c_z) of each link, c in the link's axes (Eqs
        10-12).
        """

    @property
    def moments(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """
        Masses and first moments Pi of the links in the model file (4n,) [kg, kg m].
        """

    def gravity_columns(
        self,
        terms: GravityTerms,
        q: Annotated[NDArray[numpy.float64], "(:, :)"],
    ) -> Annotated[NDArray[numpy.float64], "(:, :, :)"]:
        """
        Columns Phi (k, n, m) of the terms at the joint positions q (k, n): holding = Phi theta.
        """

    def set_gravity_model(self, terms: GravityTerms, theta: Annotated[NDArray[numpy.float64], "(:,)"]) -> None:
        """
        Replaces masses and counterbalance in holding() by an identified gravity model with parameters theta (m,).
        """

    def set_gravity(self, g_base: Annotated[NDArray[numpy.float64], "(3,)"]) -> None:
        """
        Sets the gravitational acceleration in base axes (3,) [m/s^2]; default (0, 0, -9.81).
        """

    def with_scaled_masses(self, scale: numpy.typing.ArrayLike) -> Arm:
        """
        Copy whose link masses are multiplied by scale (n,), as an inexact model for a controller.
        """

    def torque_regressor(
        self,
        q: numpy.typing.ArrayLike,
        v: numpy.typing.ArrayLike,
        a: numpy.typing.ArrayLike,
    ) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """
        Regressor Y (n,10n): M a + C v + G = Y pi, pi = (m, m c (3), I_xx, I_xy, I_yy, I_xz, I_yz, I_zz) of each link.
        """

    @property
    def inertial_parameters(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Inertial parameters pi of the links (10n,) [kg, kg m, kg m^2]."""

    def with_inertial_parameters(self, pi: numpy.typing.ArrayLike) -> Arm:
        """
        Copy with the inertial parameters pi (10n,) and without a counterbalance. Parameters that no rigid body can have
        raise ValueError.
        """

class HandOptions:
    """
    Impedance of the operator's hand: a mass on the handle, with a spring and a damper to its intended path.
    """

    def __init__(self) -> None: ...

    @property
    def mass(self) -> float:
        """Mass that moves with the handle [kg]."""

    @mass.setter
    def mass(self, arg: float, /) -> None: ...

    @property
    def damping(self) -> float:
        """Damping to the intended path [N s/m]."""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...

    @property
    def stiffness(self) -> float:
        """Stiffness to the intended path [N/m]."""

    @stiffness.setter
    def stiffness(self, arg: float, /) -> None: ...

    @property
    def inertia(self) -> float:
        """Rotational inertia that moves with the handle [kg m^2]."""

    @inertia.setter
    def inertia(self, arg: float, /) -> None: ...

    @property
    def rotational_damping(self) -> float:
        """Rotational damping [N m s/rad]."""

    @rotational_damping.setter
    def rotational_damping(self, arg: float, /) -> None: ...

    @property
    def rotational_stiffness(self) -> float:
        """Rotational stiffness [N m/rad]."""

    @rotational_stiffness.setter
    def rotational_stiffness(self, arg: float, /) -> None: ...

    @property
    def grip_force_max(self) -> float:
        """Largest force of the grip; the hand slips above it [N]."""

    @grip_force_max.setter
    def grip_force_max(self, arg: float, /) -> None: ...

class LeaderOptions:
    """
    Parameters of a simulated leader; palpate.Arm.leader_options() fills them.
    """

    def __init__(self) -> None: ...

    @property
    def coupling(self) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """Coupling matrix A (n,n): q_joint = A q_motor."""

    @coupling.setter
    def coupling(self, arg: Annotated[NDArray[numpy.float64], "(:, :)"], /) -> None: ...

    @property
    def loop_delay(self) -> float:
        """Delay from the command to the torque, of the force term only [s]."""

    @loop_delay.setter
    def loop_delay(self, arg: float, /) -> None: ...

    @property
    def loop_jitter(self) -> float:
        """
        Additional random delay of each command, uniform in 0..loop_jitter [s].
        """

    @loop_jitter.setter
    def loop_jitter(self, arg: float, /) -> None: ...

    @property
    def drive_lag(self) -> float:
        """
        Time constant of the drives' current loops, which all torque terms pass [s].
        """

    @drive_lag.setter
    def drive_lag(self, arg: float, /) -> None: ...

    @property
    def velocity_window(self) -> float:
        """
        Time between the two positions whose difference gives a velocity [s]; 0: velocities come from the time between
        encoder edges.
        """

    @velocity_window.setter
    def velocity_window(self, arg: float, /) -> None: ...

    @property
    def velocity_cutoff(self) -> float:
        """Cutoff of the first-order low-pass on velocities [Hz]; 0: no low-pass."""

    @velocity_cutoff.setter
    def velocity_cutoff(self, arg: float, /) -> None: ...

    @property
    def hold_timeout(self) -> float:
        """
        Time without a new command after which the force term ramps to zero [s].
        """

    @hold_timeout.setter
    def hold_timeout(self, arg: float, /) -> None: ...

    @property
    def cell_noise(self) -> float:
        """Noise of the load cell in the handle, rms per axis [N]."""

    @cell_noise.setter
    def cell_noise(self, arg: float, /) -> None: ...

    @property
    def seed(self) -> int:
        """
        Seed of the load cell's noise and of the jitter; a Simulation replaces it by its own.
        """

    @seed.setter
    def seed(self, arg: int, /) -> None: ...

    @property
    def quantised(self) -> bool:
        """
        True: positions and velocities come from the encoders; False: they are exact.
        """

    @quantised.setter
    def quantised(self, arg: bool, /) -> None: ...

    @property
    def encoder_step(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """
        Resolution of the encoders on the motor side (n,) [rad/count]; 0: exact.
        """

    @encoder_step.setter
    def encoder_step(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Coulomb friction of the joints (n,) [N m]."""

    @coulomb.setter
    def coulomb(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Viscous friction of the joints (n,) [N m s/rad]."""

    @viscous.setter
    def viscous(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def rotor_inertia(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Rotor inertias, reflected to the joints (n,) [kg m^2]."""

    @rotor_inertia.setter
    def rotor_inertia(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def tau_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Torque limits of the drives, joint side (n,) [N m]."""

    @tau_max.setter
    def tau_max(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class DriveOptions:
    """Parameters of a follower's drives, at its joints."""

    def __init__(self) -> None: ...

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Coulomb friction (n,) [N m, N]."""

    @coulomb.setter
    def coulomb(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Viscous friction (n,) [N m s/rad, N s/m]."""

    @viscous.setter
    def viscous(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def rotor_inertia(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Rotor inertias (n,) [kg m^2, kg]."""

    @rotor_inertia.setter
    def rotor_inertia(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class FollowerOptions:
    """Parameters of a simulated follower."""

    def __init__(self) -> None: ...

    @property
    def bandwidth(self) -> float:
        """Natural frequency of the joint servos [Hz]; 0: ideal."""

    @bandwidth.setter
    def bandwidth(self, arg: float, /) -> None: ...

    @property
    def damping_ratio(self) -> float:
        """Damping ratio of the joint servos [-]; 1: no overshoot."""

    @damping_ratio.setter
    def damping_ratio(self, arg: float, /) -> None: ...

    @property
    def jaw_v_max(self) -> float:
        """Speed limit of the jaw [rad/s]."""

    @jaw_v_max.setter
    def jaw_v_max(self, arg: float, /) -> None: ...

    @property
    def driven(self) -> bool:
        """
        True: drives move the joints by torques, and contact forces push against them; False: position servos move the
        joints.
        """

    @driven.setter
    def driven(self, arg: bool, /) -> None: ...

    @property
    def drives(self) -> DriveOptions:
        """Drives of a driven follower."""

    @drives.setter
    def drives(self, arg: DriveOptions, /) -> None: ...

    @property
    def v_max(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Speed limits of the joints (n,) [rad/s, m/s]."""

    @v_max.setter
    def v_max(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def encoder_step(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Resolution of the encoders (n,) [rad, m]; 0: exact."""

    @encoder_step.setter
    def encoder_step(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class Leader:
    """
    A simulated leader: dynamics, friction, drives and encoders, and the hand that holds it.
    """

    def __init__(self, arm: Arm, options: LeaderOptions, hand: HandOptions = ...) -> None: ...

    def reset(self, q: Annotated[NDArray[numpy.float64], "(:,)"]) -> None:
        """
        Places the arm at rest at q (n,), clipped to the limits, with drives off, and sets the time to zero.
        """

    def command(
        self,
        tau_force: Annotated[NDArray[numpy.float64], "(:,)"],
        tau_gravity: Annotated[NDArray[numpy.float64], "(:,)"],
        tau_platform: Annotated[NDArray[numpy.float64], "(:,)"],
    ) -> None:
        """
        Commands torques (n,) [N m]; the drives hold them until the next command.
        """

    def obey(self, command: LeaderCommand) -> None:
        """Commands all terms of a command of the stage `torque`."""

    def pinch(self, gripper: float) -> None:
        """The hand closes the gripper to this angle [rad]; 0: closed."""

    def step(
        self,
        dt: float,
        X_LH_hand: Annotated[NDArray[numpy.float64], "(4, 4)"],
        V_LH_hand: Annotated[NDArray[numpy.float64], "(6,)"] = ...,
        n: int = 1,
    ) -> None:
        """
        Simulates n servo periods of dt [s]. The hand intends the handle at X_LH_hand (4,4), moving with V_LH_hand (6,).
        """

    @property
    def t(self) -> float:
        """Time [s]."""

    @property
    def q_measured(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Joint positions by the encoders (n,) [rad]."""

    @property
    def v_measured(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Joint velocities by the encoders (n,) [rad/s]."""

    @property
    def gripper(self) -> float:
        """Measured gripper angle [rad]."""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """True joint positions (n,) [rad]."""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """True joint velocities (n,) [rad/s]."""

    @property
    def load_cell(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """True wrench of the arm on the hand, in L (6,) [N, N m]."""

    @property
    def F_cell_L(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Force measured by the load cell, noise included (3,) [N]."""

    @property
    def hand_slipped(self) -> bool:
        """True if the force of the grip reached its limit in the last step."""

    @property
    def energy(self) -> float:
        """
        Kinetic plus potential energy [J]; the weight of the hand is not included.
        """

class Follower:
    """A simulated follower: joints under position control, and a jaw."""

    def __init__(self, arm: Arm, options: FollowerOptions) -> None: ...

    def reset(self, q: Annotated[NDArray[numpy.float64], "(:,)"], jaw: float = 0.0) -> None:
        """Places the arm at rest at q (n,) [rad, m] with this jaw angle [rad]."""

    def command(self, q: Annotated[NDArray[numpy.float64], "(:,)"], jaw: float = 0.0) -> None:
        """Commands joint positions q (n,) [rad, m] and a jaw angle [rad]."""

    def step(self, dt: float, n: int = 1, F_T_B: Annotated[NDArray[numpy.float64], "(6,)"] = ...) -> None:
        """
        Simulates n servo periods of dt [s]. F_T_B (6,): wrench of the environment on the tip, which moves a driven
        follower only [N, N m].
        """

    @property
    def t(self) -> float:
        """Time [s]."""

    @property
    def q(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Measured joint positions (n,) [rad, m]."""

    @property
    def v(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """
        Measured joint velocities (n,) [rad/s, m/s]; empty unless the follower is driven.
        """

    @property
    def tau(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """
        Torques of the drives (n,) [N m, N]; empty unless the follower is driven.
        """

    @property
    def jaw(self) -> float:
        """Measured jaw angle [rad]."""

class DepthImage:
    """
    The nearest surface in every pixel of a pinhole camera with the optical frame C of ROS (z forward, x right, y down).
    Pixel (0, 0) has its centre at the image coordinates (0, 0).
    """

    def __init__(self, columns: int, rows: int, fx: float, fy: float, cx: float, cy: float, near: float) -> None:
        """
        Focal lengths and principal point [pixel], smallest depth that is drawn [m].
        """

    def clear(self) -> None:
        """Remove everything that was drawn."""

    def draw(
        self,
        vertices_O: Annotated[NDArray[numpy.float64], "(:, 3)"],
        triangles: Annotated[NDArray[numpy.int32], "(:, 3)"],
        X_CO: Annotated[NDArray[numpy.float64], "(4, 4)"],
        id: int,
    ) -> None:
        """
        Draw a mesh with vertices (n,3) [m] and triangles (m,3) at the pose X_CO (4,4), as object `id`.
        """

    def inverse_depth(self) -> NDArray[numpy.float32]:
        """Inverse depth 1/z (rows, columns); 0 where nothing was drawn [1/m]."""

    def cosine(self) -> NDArray[numpy.float32]:
        """
        Cosine of the angle between ray and normal (rows, columns); 0 where nothing was drawn [-].
        """

    def object(self) -> NDArray[numpy.int16]:
        """
        Object drawn in every pixel (rows, columns); -1 where nothing was drawn.
        """

class LeaderCommand:
    """Torques for the leader, as separate terms."""

    @property
    def tau_force(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """J^T (F_H_L + F_law_L) (n,) [N m]."""

    @property
    def tau_gravity(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Gravity compensation (n,) [N m]."""

    @property
    def tau_platform(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Torque of the controller of joint 4, the platform (n,) [N m]."""

    @property
    def tau_friction(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Friction compensation (n,) [N m]."""

    @property
    def tau_limits(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Torque of the soft stops (n,) [N m]."""

    @property
    def tau(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Sum of all terms (n,) [N m]."""

    @property
    def F_H_L(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Wrench rendered on the hand within the drive limits (6,) [N, N m]."""

    @property
    def F_law_L(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Wrench that the control law adds to F_H_L (6,) [N, N m]."""

    @property
    def F_neglected(self) -> float:
        """
        Force of the arm's inertia and Coriolis terms that the law does not compensate [N].
        """

class TorqueOptions:
    """Options of the stage `torque`."""

    def __init__(self) -> None: ...

    @property
    def law(self) -> str:
        """Control law: 'stiffness' (the paper's), 'impedance' or 'admittance'."""

    @law.setter
    def law(self, arg: str, /) -> None: ...

    @property
    def mode(self) -> str:
        """'full', or 'paper': torques on the first three joints only."""

    @mode.setter
    def mode(self, arg: str, /) -> None: ...

    @property
    def force_gain(self) -> float:
        """Gain of tau_force [-]; 0 switches it off."""

    @force_gain.setter
    def force_gain(self, arg: float, /) -> None: ...

    @property
    def gravity_gain(self) -> float:
        """Gain of the gravity compensation [-]; 0 switches it off."""

    @gravity_gain.setter
    def gravity_gain(self, arg: float, /) -> None: ...

    @property
    def platform_gain(self) -> float:
        """
        Gain of the controller of joint 4, 0..1 [-], for MTMs with seven joints in mode 'full'.
        """

    @platform_gain.setter
    def platform_gain(self, arg: float, /) -> None: ...

    @property
    def friction(self) -> FrictionOptions:
        """Options of the friction compensation."""

    @friction.setter
    def friction(self, arg: FrictionOptions, /) -> None: ...

    @property
    def limits(self) -> LimitOptions:
        """Options of the soft stops."""

    @limits.setter
    def limits(self, arg: LimitOptions, /) -> None: ...

    @property
    def laws(self) -> ControlLawOptions:
        """Options of the control laws."""

    @laws.setter
    def laws(self, arg: ControlLawOptions, /) -> None: ...

    @property
    def law_cap(self) -> float:
        """Largest force that a law may add to the rendered force [N]."""

    @law_cap.setter
    def law_cap(self, arg: float, /) -> None: ...

    @property
    def fast_force(self) -> float:
        """F_neglected above which the status bit too_fast is set [N]."""

    @fast_force.setter
    def fast_force(self, arg: float, /) -> None: ...

    @property
    def rotor_inertia(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Rotor inertias in the controller's model (n,) [kg m^2]."""

    @rotor_inertia.setter
    def rotor_inertia(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class FrictionOptions:
    """Options of the friction compensation, which never drives the arm."""

    def __init__(self) -> None: ...

    @property
    def gain(self) -> float:
        """
        Fraction of the friction that is compensated, 0..1 [-]; 0 switches it off.
        """

    @gain.setter
    def gain(self, arg: float, /) -> None: ...

    @property
    def dead_band(self) -> float:
        """Speed below which nothing is compensated [rad/s, m/s]."""

    @dead_band.setter
    def dead_band(self, arg: float, /) -> None: ...

    @property
    def full_speed(self) -> float:
        """Speed from which on the compensation is complete [rad/s, m/s]."""

    @full_speed.setter
    def full_speed(self, arg: float, /) -> None: ...

    @property
    def coulomb(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Coulomb friction in the controller's model (n,) [N m]."""

    @coulomb.setter
    def coulomb(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def viscous(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Viscous friction in the controller's model (n,) [N m s/rad]."""

    @viscous.setter
    def viscous(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class LimitOptions:
    """Options of the soft stops before the joint limits."""

    def __init__(self) -> None: ...

    @property
    def gain(self) -> float:
        """
        Torque at the joint limit, as a fraction of the drive's limit [-]; 0 switches the soft stops off.
        """

    @gain.setter
    def gain(self, arg: float, /) -> None: ...

    @property
    def margin(self) -> float:
        """Width of a soft stop, as a fraction of the joint's range [-]."""

    @margin.setter
    def margin(self, arg: float, /) -> None: ...

class ControlLawOptions:
    """Options of the control laws; each law reads its own."""

    def __init__(self) -> None: ...

    @property
    def shape_inertia(self) -> bool:
        """
        impedance: True gives the handle the inertia virtual_mass; this needs a load cell.
        """

    @shape_inertia.setter
    def shape_inertia(self, arg: bool, /) -> None: ...

    @property
    def virtual_mass(self) -> float:
        """
        Inertia of the handle that the hand feels [kg], for admittance, and for impedance with shape_inertia.
        """

    @virtual_mass.setter
    def virtual_mass(self, arg: float, /) -> None: ...

    @property
    def virtual_damping(self) -> float:
        """admittance: damping of the handle that the hand feels [N s/m]."""

    @virtual_damping.setter
    def virtual_damping(self, arg: float, /) -> None: ...

    @property
    def servo_bandwidth(self) -> float:
        """admittance: bandwidth of the position loop [Hz]."""

    @servo_bandwidth.setter
    def servo_bandwidth(self, arg: float, /) -> None: ...

class Torque:
    """
    The stage `torque`: joint torques of one control law, within the drive limits.
    """

    def __init__(self, options: TorqueOptions, tau_max: numpy.typing.ArrayLike, dt: float = 0.001) -> None:
        """
        tau_max (n,): torque limits of the drives [N m]; dt: period of the cycle [s].
        """

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
        One tick: (LeaderCommand that renders F_H_L (6,) [N, N m], status bits). F_cell_L (3,): measured force of the
        arm on the hand [N]. fresh: False resets the control law, because the state of the leader is not new.
        """

def removed_friction(options: TorqueOptions, dt: float) -> float:
    """
    Fraction of the arm's friction that friction compensation or the control law removes. dt: period [s].
    """

def cartesian_place(
    model: Arm,
    q: numpy.typing.ArrayLike,
    v: numpy.typing.ArrayLike,
    rotor_inertia: Annotated[NDArray[numpy.float64], "(:,)"] | None = None,
    heaviest: float = 20.0,
) -> tuple[
    Annotated[NDArray[numpy.float64], "(:, :)"],
    Annotated[NDArray[numpy.float64], "(:,)"],
    Annotated[NDArray[numpy.float64], "(:,)"],
    bool,
]:
    """
    Dynamics of the tip's position (Eqs 2-5): (Lambda (3,3) [kg], Gamma v (3,) [N], eta (3,) [N], singular). Eigenvalues
    of Lambda above heaviest [kg] are set to it, and singular is True.
    """

def cartesian(
    model: Arm,
    q: numpy.typing.ArrayLike,
    v: numpy.typing.ArrayLike,
    rotor_inertia: Annotated[NDArray[numpy.float64], "(:,)"] | None = None,
    heaviest: float = 20.0,
) -> tuple[
    Annotated[NDArray[numpy.float64], "(:, :)"],
    Annotated[NDArray[numpy.float64], "(:,)"],
    Annotated[NDArray[numpy.float64], "(:,)"],
    bool,
]:
    """
    Dynamics of the tip's position and orientation (Eqs 2-5): (Lambda (6,6), Gamma v (6,), eta (6,), singular), as for
    cartesian_place.
    """

TICK_BYTES: int = 3896

def signals() -> list[tuple[str, int, int, str, str, str, bool, str]]:
    """
    Table of signals, with one row (name, byte offset, number of doubles, unit, frame, doc, deterministic, stage) for
    each.
    """

def status_words() -> list[tuple[str, int, str]]:
    """
    Bits of the signal `status`, the gravest first, with one row (name, bit, description) for each.
    """

class Controls:
    """Values that the operator may change during a run."""

    def __init__(self) -> None: ...

    @property
    def following(self) -> bool:
        """True: the tool follows the hand, and the hand receives forces."""

    @following.setter
    def following(self, arg: bool, /) -> None: ...

    @property
    def clutch(self) -> bool:
        """
        True: the clutch pedal is pressed; the hand moves freely and the tool stays.
        """

    @clutch.setter
    def clutch(self, arg: bool, /) -> None: ...

    @property
    def camera(self) -> bool:
        """
        True: the camera pedal is pressed; the hands move the endoscope and the tool stays.
        """

    @camera.setter
    def camera(self, arg: bool, /) -> None: ...

    @property
    def power(self) -> bool:
        """True: the arms shall have power."""

    @power.setter
    def power(self, arg: bool, /) -> None: ...

    @property
    def home(self) -> bool:
        """True: the arms shall be homed."""

    @home.setter
    def home(self, arg: bool, /) -> None: ...

    @property
    def operator_present(self) -> bool:
        """True: an operator is at the console, with the head in the viewer."""

    @operator_present.setter
    def operator_present(self, arg: bool, /) -> None: ...

    @property
    def hold_all(self) -> bool:
        """True: everything holds where it is."""

    @hold_all.setter
    def hold_all(self, arg: bool, /) -> None: ...

    @property
    def recover_by_itself(self) -> bool:
        """True: a fault ends when its cause is gone."""

    @recover_by_itself.setter
    def recover_by_itself(self, arg: bool, /) -> None: ...

    @property
    def take_back_requests(self) -> int:
        """
        A new number takes the shift of the tool against the hand back, which pauses after faults have left.
        """

    @take_back_requests.setter
    def take_back_requests(self, arg: int, /) -> None: ...

    @property
    def recover_requests(self) -> int:
        """A new number leaves a fault whose cause is gone."""

    @recover_requests.setter
    def recover_requests(self, arg: int, /) -> None: ...

    @property
    def lock_rotation(self) -> bool:
        """True: the tool keeps its orientation while it follows."""

    @lock_rotation.setter
    def lock_rotation(self, arg: bool, /) -> None: ...

    @property
    def lock_translation(self) -> bool:
        """
        True: the tool keeps its position while it follows, and the hand feels no force.
        """

    @lock_translation.setter
    def lock_translation(self, arg: bool, /) -> None: ...

    @property
    def scale(self) -> float:
        """Tool motion per hand motion; 0: as in the scene [-]."""

    @scale.setter
    def scale(self, arg: float, /) -> None: ...

    @property
    def quat_WL(self) -> Annotated[NDArray[numpy.float64], "(4,)"]:
        """
        Orientation of the leader base in W (4,), w x y z; zeros: as in the scene.
        """

    @quat_WL.setter
    def quat_WL(self, arg: Annotated[NDArray[numpy.float64], "(4,)"], /) -> None: ...

    @property
    def paused(self) -> bool:
        """True: simulated time stands still."""

    @paused.setter
    def paused(self, arg: bool, /) -> None: ...

    @property
    def hold(self) -> bool:
        """True: the simulated hand stays where it is on its path."""

    @hold.setter
    def hold(self, arg: bool, /) -> None: ...

    @property
    def stiffness_scale(self) -> float:
        """Factor on the stiffness of every object [-]."""

    @stiffness_scale.setter
    def stiffness_scale(self, arg: float, /) -> None: ...

    @property
    def damping_scale(self) -> float:
        """Factor on the damping of every object [-]."""

    @damping_scale.setter
    def damping_scale(self, arg: float, /) -> None: ...

    @property
    def guidance(self) -> float:
        """
        Position of the guidance pedal, 0-1, for fixtures with a ramp by pedal [-].
        """

    @guidance.setter
    def guidance(self, arg: float, /) -> None: ...

    @property
    def hand_pinch(self) -> float:
        """
        Pinch angle of the simulated hand instead of its path's [rad]; NaN: as the path says.
        """

    @hand_pinch.setter
    def hand_pinch(self, arg: float, /) -> None: ...

    @property
    def p_hand_offset_W(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Offset added to the hand's intended position (3,) [m]."""

    @p_hand_offset_W.setter
    def p_hand_offset_W(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

def session_states() -> list[tuple[str, str, bool]]:
    """
    States of a session in the order of their numbers, with one row (name, description, False) for each.
    """

def session_causes() -> list[tuple[str, str, bool]]:
    """
    Causes of transitions, with one row (name, description, True for a request of a person) for each.
    """

def session_transitions() -> list[tuple[str, str, str]]:
    """
    Table of transitions (from, cause, to). In a state, the first row whose cause holds is taken.
    """

class SessionInput:
    """Levels that the state machine of a session reads in one tick."""

    def __init__(self) -> None: ...

    @property
    def power(self) -> bool:
        """Power is requested, and the arms have it."""

    @power.setter
    def power(self, arg: bool, /) -> None: ...

    @property
    def home(self) -> bool:
        """Homing is requested."""

    @home.setter
    def home(self, arg: bool, /) -> None: ...

    @property
    def at_home(self) -> bool:
        """Both arms report that they are homed."""

    @at_home.setter
    def at_home(self, arg: bool, /) -> None: ...

    @property
    def follow(self) -> bool:
        """Teleoperation is requested, and an operator is at the console."""

    @follow.setter
    def follow(self, arg: bool, /) -> None: ...

    @property
    def aligned(self) -> bool:
        """Handle and tool have the same orientation."""

    @aligned.setter
    def aligned(self, arg: bool, /) -> None: ...

    @property
    def clutch(self) -> bool:
        """The clutch pedal is pressed."""

    @clutch.setter
    def clutch(self, arg: bool, /) -> None: ...

    @property
    def camera(self) -> bool:
        """The camera pedal is pressed."""

    @camera.setter
    def camera(self, arg: bool, /) -> None: ...

    @property
    def hold(self) -> bool:
        """A hold is requested."""

    @hold.setter
    def hold(self, arg: bool, /) -> None: ...

    @property
    def execute(self) -> bool:
        """A planned motion waits, moves or pauses."""

    @execute.setter
    def execute(self, arg: bool, /) -> None: ...

    @property
    def moving(self) -> bool:
        """A planned motion is not yet at rest."""

    @moving.setter
    def moving(self, arg: bool, /) -> None: ...

    @property
    def fault(self) -> bool:
        """A state of an arm is missing or wrong."""

    @fault.setter
    def fault(self, arg: bool, /) -> None: ...

    @property
    def recover(self) -> bool:
        """A fault may be left once its cause is gone."""

    @recover.setter
    def recover(self, arg: bool, /) -> None: ...

    @property
    def settled(self) -> bool:
        """No fault for the time that the loop demands."""

    @settled.setter
    def settled(self, arg: bool, /) -> None: ...

class SessionMachine:
    """The state machine of a session, which every loop runs in its cycle."""

    def __init__(self) -> None: ...

    def step(self, levels: SessionInput) -> str:
        """
        Takes all transitions that the levels allow; returns the name of the new state.
        """

    @property
    def state(self) -> str:
        """Name of the present state."""

class Pace:
    """
    Speed along a planned motion relative to the plan, which changes by 1 in stop_time.
    """

    def __init__(self, stop_time: float) -> None:
        """stop_time: time in which a motion at full pace comes to rest [s]."""

    def step(self, wanted: float, dt: float) -> float:
        """
        One period dt [s] towards the wanted pace; returns the progress along the motion [s].
        """

    def reset(self) -> None:
        """Rests at once."""

    def limit(self, left: float) -> float:
        """
        The largest pace from which the motion rests within `left` [s] along it.
        """

    @property
    def value(self) -> float:
        """The present pace, 1: as planned [-]."""

STOP_TIME: float = 0.012

class RealTimeOptions:
    """What the real-time thread may request from the operating system."""

    def __init__(self) -> None: ...

    @property
    def allow_priority(self) -> bool:
        """True: the thread may request SCHED_FIFO and locked memory."""

    @allow_priority.setter
    def allow_priority(self, arg: bool, /) -> None: ...

    @property
    def allow_affinity(self) -> bool:
        """True: the thread may bind itself to one core."""

    @allow_affinity.setter
    def allow_affinity(self, arg: bool, /) -> None: ...

    @property
    def priority(self) -> int:
        """Priority of SCHED_FIFO, 1..99."""

    @priority.setter
    def priority(self, arg: int, /) -> None: ...

    @property
    def spin_us(self) -> float:
        """Time before a deadline that the thread spends in a busy wait [us]."""

    @spin_us.setter
    def spin_us(self, arg: float, /) -> None: ...

class BareLoop:
    """
    A loop that only keeps time, as a baseline for the punctuality of a machine.
    """

    def __init__(self, rate: float, options: RealTimeOptions = ...) -> None:
        """rate [Hz]."""

    def start(self) -> None:
        """Starts the thread."""

    def stop(self) -> None:
        """Ends the thread."""

    def timing(self) -> dict[str, Any]:
        """
        Punctuality so far: lateness_us, slack_us, ticks, missed_ticks, scheduler.
        """

class RodOptions:
    """A rigid rod that jaws can hold and hand over; see held_object.hpp."""

    def __init__(self) -> None: ...

    @property
    def a(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """One end of the axis in O (3,) [m]."""

    @a.setter
    def a(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def b(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Its other end (3,) [m]."""

    @b.setter
    def b(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def radius(self) -> float:
        """Radius [m]; 0: there is no rod."""

    @radius.setter
    def radius(self, arg: float, /) -> None: ...

    @property
    def stiffness(self) -> float:
        """Stiffness of the spring between two grips [N/m]."""

    @stiffness.setter
    def stiffness(self, arg: float, /) -> None: ...

    @property
    def hold(self) -> float:
        """Largest force of this spring [N]."""

    @hold.setter
    def hold(self, arg: float, /) -> None: ...

    @property
    def X_WO(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose in W at the start (4, 4)."""

    @X_WO.setter
    def X_WO(self, arg: Annotated[NDArray[numpy.float64], "(4, 4)"], /) -> None: ...

class ToolCapsule:
    """A capsule of an instrument, between two points of its links."""

    def __init__(self, a: ToolSphere, b: ToolSphere, radius: float) -> None:
        """a, b: ends of its axis; radius [m]."""

class Board:
    """The world in which the instruments of several loops meet."""

    def __init__(self, instruments: int, rod: RodOptions = ...) -> None: ...

class CycleOptions:
    """Options of the haptic cycle and its stages."""

    def __init__(self) -> None: ...

    @property
    def rate(self) -> float:
        """Rate of the haptic cycle [Hz]."""

    @rate.setter
    def rate(self, arg: float, /) -> None: ...

    @property
    def method(self) -> str:
        """Name of the contact method."""

    @method.setter
    def method(self, arg: str, /) -> None: ...

    @property
    def contact(self) -> ContactOptions:
        """Options of the stage `contact`."""

    @contact.setter
    def contact(self, arg: ContactOptions, /) -> None: ...

    @property
    def mapping(self) -> MappingOptions:
        """Options of the stage `mapping`."""

    @mapping.setter
    def mapping(self, arg: MappingOptions, /) -> None: ...

    @property
    def guidance(self) -> GuidanceOptions:
        """Options of the stage `guidance`."""

    @guidance.setter
    def guidance(self, arg: GuidanceOptions, /) -> None: ...

    @property
    def source(self) -> str:
        """Source of the force: 'contact', 'estimate' or 'both'."""

    @source.setter
    def source(self, arg: str, /) -> None: ...

    @property
    def estimate(self) -> EstimateOptions:
        """Options of the force estimate."""

    @estimate.setter
    def estimate(self, arg: EstimateOptions, /) -> None: ...

    @property
    def stability(self) -> StabilityOptions:
        """Options of the stage `stability`."""

    @stability.setter
    def stability(self, arg: StabilityOptions, /) -> None: ...

    @property
    def torque(self) -> TorqueOptions:
        """Options of the stage `torque`."""

    @torque.setter
    def torque(self, arg: TorqueOptions, /) -> None: ...

    @property
    def X_WL(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose of the leader base in the world (4, 4)."""

    @X_WL.setter
    def X_WL(self, arg: Annotated[NDArray[numpy.float64], "(4, 4)"], /) -> None: ...

    @property
    def X_WB(self) -> Annotated[NDArray[numpy.float64], "(4, 4)"]:
        """Pose of the follower base in the world (4, 4)."""

    @X_WB.setter
    def X_WB(self, arg: Annotated[NDArray[numpy.float64], "(4, 4)"], /) -> None: ...

class SimulationOptions(CycleOptions):
    """Options of the haptic cycle and of the simulated devices around it."""

    def __init__(self) -> None: ...

    @property
    def plant_rate(self) -> float:
        """Smallest rate of the simulated servos [Hz]."""

    @plant_rate.setter
    def plant_rate(self, arg: float, /) -> None: ...

    @property
    def loop_delay(self) -> float:
        """Delay from the command to the torque, of the force term only [s]."""

    @loop_delay.setter
    def loop_delay(self, arg: float, /) -> None: ...

    @property
    def loop_jitter(self) -> float:
        """
        Additional random delay of each command, uniform in 0..loop_jitter [s].
        """

    @loop_jitter.setter
    def loop_jitter(self, arg: float, /) -> None: ...

    @property
    def seed(self) -> int:
        """Seed of the hand's tremor, of the load cell's noise and of the jitter."""

    @seed.setter
    def seed(self, arg: int, /) -> None: ...

    @property
    def tremor(self) -> float:
        """Tremor of the hand at 8-12 Hz, rms per axis [m]."""

    @tremor.setter
    def tremor(self, arg: float, /) -> None: ...

    @property
    def leader(self) -> LeaderOptions:
        """Parameters of the simulated leader."""

    @leader.setter
    def leader(self, arg: LeaderOptions, /) -> None: ...

    @property
    def hand(self) -> HandOptions:
        """Impedance of the simulated hand."""

    @hand.setter
    def hand(self, arg: HandOptions, /) -> None: ...

    @property
    def follower(self) -> FollowerOptions:
        """Parameters of the simulated follower."""

    @follower.setter
    def follower(self, arg: FollowerOptions, /) -> None: ...

    @property
    def realtime(self) -> RealTimeOptions:
        """Options of the real-time thread."""

    @realtime.setter
    def realtime(self, arg: RealTimeOptions, /) -> None: ...

    @property
    def q_leader0(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Initial joint positions of the leader (n,) [rad]."""

    @q_leader0.setter
    def q_leader0(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

    @property
    def q_follower0(self) -> Annotated[NDArray[numpy.float64], "(:,)"]:
        """Initial joint positions of the follower (n,) [rad, m]."""

    @q_follower0.setter
    def q_follower0(self, arg: Annotated[NDArray[numpy.float64], "(:,)"], /) -> None: ...

class Cycle:
    """The haptic cycle, from measured states to commanded torques."""

    def __init__(self, options: CycleOptions, leader_model: Arm, follower: Arm) -> None:
        """
        leader_model: the controller's model of the leader; follower: the model of the follower.
        """

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
        One tick at t [s]: (row of signals, commanded joint positions of the follower (n,) [rad, m], empty for no
        command, commanded jaw angle [rad]). The stamps t_leader and t_follower default to t.
        """

class HandPath:
    """
    Intended tool path in W through way points; the hand rests only at the ends and where it reverses.
    """

    def __init__(
        self,
        times: Sequence[float],
        positions_W: Annotated[NDArray[numpy.float64], "(:, 3)"],
        grippers: Sequence[float] | None = None,
        grip_times: Sequence[float] | None = None,
    ) -> None:
        """
        times (n,) [s], positions_W (n, 3) [m], grippers (m,) [rad] or None, grip_times (m,) [s]; None: times.
        """

    def at(
        self,
        t: float,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(3,)"], Annotated[NDArray[numpy.float64], "(3,)"], float]:
        """
        (position (3,) [m], velocity (3,) [m/s], gripper angle [rad]) at t [s].
        """

class RemoteEnd:
    """The operator's end of a link, for Simulation.attach()."""

class Simulation:
    """A simulation of hand, leader and follower around the haptic cycle."""

    def __init__(
        self,
        options: SimulationOptions,
        leader_plant: Arm,
        leader_model: Arm,
        follower: Arm,
        snapshot: Snapshot,
        hand_path: HandPath,
    ) -> None:
        """
        leader_plant: the simulated leader; leader_model: the controller's model of the leader.
        """

    def drain(self) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """Rows since the last drain, in real time (n, TICK_BYTES/8)."""

    @property
    def dropped(self) -> int:
        """Number of rows lost because they were not drained in time."""

    def latest(self) -> NDArray[numpy.float64]:
        """The newest row (TICK_BYTES/8,)."""

    def soft_vertices(self, object: int) -> NDArray[numpy.float64]:
        """
        Deformed surface of a soft object: vertices (n, 3) in the object's frame O [m], in the order of
        TissueSurface.vertices. The loop publishes them every 16 ms. Raises ValueError if the object does not exist or
        is not soft.
        """

    @property
    def controls(self) -> Controls:
        """
        The operator's controls. This is a copy: assign a whole one, which applies from the next tick on.
        """

    @controls.setter
    def controls(self, arg: Controls, /) -> None: ...

    def set_fixtures(self, fixtures: FixtureList) -> None:
        """
        Replaces the fixtures of guidance at the next tick, without a step in the force.
        """

    def set_snapshot(self, snapshot: Snapshot) -> None:
        """
        Replaces the scene at the next tick. Contact goes on if the number, names and surfaces of the objects stay the
        same, and starts anew otherwise.
        """

    def set_live(self, targets: LiveTargets) -> None:
        """
        Sets the poses that the live objects of the newest snapshot shall reach, from the next tick on. Raises
        ValueError if their number differs.
        """

    def join(self, board: Board, index: int, capsules: Sequence[ToolCapsule], stiffness: float, damping: float) -> None:
        """
        Puts the instrument among those of other loops, which push it apart with a stiffness [N/m] and a damping [N
        s/m]. index: its number among them. Not while the loop runs.
        """

    def join_bodies(self, bodies: Bodies, tool: int) -> None:
        """
        Puts the tool among rigid bodies, as the tool of this number. A simulation that has the only tool advances them
        in lockstep. Not while the loop runs.
        """

    def run(
        self,
        n_ticks: int,
        hand_W: Annotated[NDArray[numpy.float64], "(:, 3)"] | None = None,
    ) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """
        Runs n_ticks in lockstep and returns their rows (n, TICK_BYTES/8); fewer rows while paused. hand_W (n_ticks, 3):
        offset of the hand from its path at the end of each tick, in W [m]. An operator model may run a few ticks, look
        at the rows and choose the next offsets.
        """

    def start(self) -> None:
        """Starts the loop in real time, in its own thread."""

    def stop(self) -> None:
        """Ramps the force to zero and ends the thread."""

    @property
    def running(self) -> bool:
        """True while the real-time thread runs."""

    def execute(
        self,
        q: Annotated[NDArray[numpy.float64], "(:, :)"],
        v: Annotated[NDArray[numpy.float64], "(:, :)"],
        dt: float,
        levers: Annotated[NDArray[numpy.float64], "(:,)"],
        pace: float = 1.0,
        until: float = 0.0,
        guard: float = 1.0,
    ) -> int:
        """
        Gives the follower a planned motion: positions q (K, n) [rad, m] and velocities v (K, n) at equal times dt [s];
        levers (n,): motion of the tip per motion of each joint. Returns its number. See order().
        """

    def order(self, motion: int, pace: float, until: float, stop: bool = False, guard: float = 1.0) -> None:
        """
        Orders about the motion of this number: pace 0..1, the time until which it is known to be free [s], stop for
        good, and the contact force that stops it [N].
        """

    def attach(self, remote: RemoteEnd | None) -> None:
        """
        Lets the hand feel what this end of a link renders; None: the objects of the loop.
        """

    def watch_stages(self) -> None:
        """
        Measures each stage of the cycle from now on; timing()['stages'][name] has p50, p99, p999 and max [us].
        """

    def stall(self, seconds: float) -> None:
        """
        For tests of isolation: the real-time loop sleeps once in its next tick [s].
        """

    def timing(self) -> dict[str, Any]:
        """
        Timing so far: cycle_us and lateness_us {p50, p99, p999, max}, slack_us {p50, p01, p001}, ticks, missed_ticks,
        scheduler.
        """

    def fault(self) -> str | None:
        """
        Description of the first fault, with the last states; None without a fault.
        """

MAX_INSTRUMENTS: int = 8

MAX_CAPSULES: int = 8

def run_in_turns(simulations: Sequence[Simulation], n_ticks: int) -> list[Annotated[NDArray[numpy.float64], "(:, :)"]]:
    """
    Runs several simulations in lockstep, tick by tick, in this thread; returns the rows of each.
    """

def nearest_points(
    p0: Annotated[NDArray[numpy.float64], "(3,)"],
    p1: Annotated[NDArray[numpy.float64], "(3,)"],
    q0: Annotated[NDArray[numpy.float64], "(3,)"],
    q1: Annotated[NDArray[numpy.float64], "(3,)"],
) -> tuple[Annotated[NDArray[numpy.float64], "(3,)"], Annotated[NDArray[numpy.float64], "(3,)"]]:
    """Nearest points (3,) [m] of the segments p0-p1 and q0-q1."""

class EngineBody:
    """Arrays of a free body inside an engine."""

    def __init__(
        self,
        pose: Annotated[NDArray[numpy.float64], "(:,)"],
        velocity: Annotated[NDArray[numpy.float64], "(:,)"],
        load: Annotated[NDArray[numpy.float64], "(:,)"],
        com: Annotated[NDArray[numpy.float64], "(3,)"],
    ) -> None:
        """
        pose (7,): position [m], quaternion w x y z, in W; velocity (6,): linear in W [m/s], angular in the body
        [rad/s]; load (6,): force [N], torque [N m] at the centre of mass, in W; com (3,) in the body [m].
        """

class EngineTool:
    """A virtual tool inside an engine."""

    def __init__(
        self,
        body: EngineBody,
        jaws: Sequence[Annotated[NDArray[numpy.float64], "(:,)"]],
        ratios: Sequence[float],
        grips: Sequence[Annotated[NDArray[numpy.float64], "(:,)"]],
        bodies: int,
    ) -> None:
        """
        jaws: goal (1,) of each jaw's drive [rad]; ratios: goal per jaw angle; grips: (4 * bodies,) contact of each jaw
        with each body, found and force (3,) [N].
        """

    def add_link(self, body: EngineBody, link: int, joints: Sequence[bool], share_w: float) -> None:
        """
        Adds its shaft or wrist: a body of its own, coupled to a link of the arm; joints: whether each joint moves this
        link; share_w: its stiffness and damping against rotation, over those of a tool [-].
        """

class MovingBody:
    """A body that moves, and the spheres with which it touches the objects."""

    def __init__(self, body: EngineBody, spheres: Sequence[ToolSphere]) -> None:
        """
        spheres: in the body's frame; none: the body passes through the objects.
        """

class BodiesOptions:
    """Engine and coupling of the rigid bodies."""

    def __init__(self) -> None: ...

    def set_engine(
        self,
        step: int,
        model: int,
        data: int,
        state: Sequence[Annotated[NDArray[numpy.float64], "(:,)"]],
        owner: object,
    ) -> None:
        """
        Addresses of the function step(model, data) and of its arguments; the arrays of the state, which return to their
        first values when one is not finite; the object that owns all this memory.
        """

    @property
    def period(self) -> float:
        """Step of the engine [s]."""

    @period.setter
    def period(self, arg: float, /) -> None: ...

    @property
    def stiffness(self) -> float:
        """Stiffness of the coupling [N/m]."""

    @stiffness.setter
    def stiffness(self, arg: float, /) -> None: ...

    @property
    def damping(self) -> float:
        """Damping of the coupling [N s/m]."""

    @damping.setter
    def damping(self, arg: float, /) -> None: ...

    @property
    def stiffness_w(self) -> float:
        """Stiffness against rotation [N m/rad]."""

    @stiffness_w.setter
    def stiffness_w(self, arg: float, /) -> None: ...

    @property
    def damping_w(self) -> float:
        """Damping against rotation [N m s/rad]."""

    @damping_w.setter
    def damping_w(self, arg: float, /) -> None: ...

    @property
    def force_max(self) -> float:
        """Largest force of the coupling's spring [N]."""

    @force_max.setter
    def force_max(self, arg: float, /) -> None: ...

    @property
    def release(self) -> float:
        """Distance at which a stuck virtual tool is put back [m]."""

    @release.setter
    def release(self, arg: float, /) -> None: ...

    @property
    def low(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Lowest corner of the field (3,) in W [m]."""

    @low.setter
    def low(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def high(self) -> Annotated[NDArray[numpy.float64], "(3,)"]:
        """Highest corner of the field (3,) in W [m]."""

    @high.setter
    def high(self, arg: Annotated[NDArray[numpy.float64], "(3,)"], /) -> None: ...

    @property
    def tools(self) -> list[EngineTool]:
        """The virtual tools; assign the whole list."""

    @tools.setter
    def tools(self, arg: Sequence[EngineTool], /) -> None: ...

    @property
    def bodies(self) -> list[MovingBody]:
        """The bodies that move; assign the whole list."""

    @bodies.setter
    def bodies(self, arg: Sequence[MovingBody], /) -> None: ...

class Bodies:
    """Rigid bodies beside the loops: see bodies.hpp."""

    def __init__(self, options: BodiesOptions, snapshot: Snapshot) -> None: ...

    def advance(self, dt: float) -> None:
        """Lockstep: advances the engine by dt [s]."""

    def drive(
        self,
        tool: int,
        X_WT: Annotated[NDArray[numpy.float64], "(4, 4)"],
        jaw: float,
    ) -> tuple[Annotated[NDArray[numpy.float64], "(3,)"], Annotated[NDArray[numpy.float64], "(3,)"]]:
        """
        For a tool without a loop: sets its pose (4, 4) and jaw angle [rad]; returns force (3,) [N] and torque (3,) [N
        m] of the coupling on it.
        """

    def start(self) -> None:
        """Steps the engine in a thread."""

    def stop(self) -> None:
        """Ends the thread."""

    @property
    def running(self) -> bool:
        """True while the thread runs."""

    def states(self) -> dict[str, Any]:
        """
        Newest states: t [s], poses (n, 7), lost (n,), grip (tools, n): force of the weaker jaw on each body [N],
        delivered: energy given to the engine by the couplings [J], restarts: how often its state was not finite,
        silences: how often a tool felt nothing since it stood still.
        """

    def step_time(self) -> dict[str, Any]:
        """Compute time of the engine's steps [us]: p50, p99, p999, max."""

BODY_VELOCITY_DELAY: float = 2.3333333333333335

MAX_BODIES: int = 48

MAX_BODY_LINKS: int = 2

class WatchOptions:
    """Limits within which a stream of stamped messages is trusted."""

    def __init__(self) -> None: ...

    @property
    def stale_after(self) -> float:
        """Silence, age of a message or clock jump that counts as a fault [s]."""

    @stale_after.setter
    def stale_after(self, arg: float, /) -> None: ...

    @property
    def v_max(self) -> float:
        """Largest plausible speed [m/s]."""

    @v_max.setter
    def v_max(self, arg: float, /) -> None: ...

    @property
    def w_max(self) -> float:
        """Largest plausible angular speed [rad/s]."""

    @w_max.setter
    def w_max(self, arg: float, /) -> None: ...

    @property
    def p_slack(self) -> float:
        """Displacement allowed in addition, for jitter of the stamps [m]."""

    @p_slack.setter
    def p_slack(self, arg: float, /) -> None: ...

    @property
    def R_slack(self) -> float:
        """Rotation allowed in addition, for jitter of the stamps [rad]."""

    @R_slack.setter
    def R_slack(self, arg: float, /) -> None: ...

class CrtkOptions:
    """
    Options of the haptic cycle for devices that exchange poses and wrenches (CRTK).
    """

    def __init__(self, cycle: CycleOptions, q_follower0: Annotated[NDArray[numpy.float64], "(:,)"] = ...) -> None:
        """
        Takes the common options from a joint-level cycle. X_WL and X_WB are the poses in W of the frames of
        measured_cp. q_follower0: initial joint positions of a virtual follower [rad, m].
        """

    @property
    def rate(self) -> float:
        """Rate of the haptic cycle [Hz]."""

    @property
    def stability(self) -> StabilityOptions:
        """Options of the stage `stability`. This is a copy: assign it whole."""

    @stability.setter
    def stability(self, arg: StabilityOptions, /) -> None: ...

    @property
    def own_teleop(self) -> bool:
        """
        True: this cycle teleoperates the follower; False: another program does.
        """

    @own_teleop.setter
    def own_teleop(self, arg: bool, /) -> None: ...

    @property
    def virtual_follower(self) -> bool:
        """True: no follower exists, and the tool is at the mapped goal."""

    @virtual_follower.setter
    def virtual_follower(self, arg: bool, /) -> None: ...

    @property
    def tip_frame(self) -> bool:
        """
        True: the leader takes wrenches in its tip frame; False: in the frame of measured_cp.
        """

    @tip_frame.setter
    def tip_frame(self, arg: bool, /) -> None: ...

    @property
    def needs_operator(self) -> bool:
        """True: teleoperation by this cycle requires an operator at the console."""

    @needs_operator.setter
    def needs_operator(self, arg: bool, /) -> None: ...

    @property
    def needs_state(self) -> bool:
        """True: the arms must have reported their operating states."""

    @needs_state.setter
    def needs_state(self, arg: bool, /) -> None: ...

    @property
    def watch(self) -> WatchOptions:
        """Limits for the incoming messages."""

    @watch.setter
    def watch(self, arg: WatchOptions, /) -> None: ...

    @property
    def release(self) -> float:
        """Time from a fault or a pedal event to zero force [s]."""

    @release.setter
    def release(self, arg: float, /) -> None: ...

    @property
    def settle(self) -> float:
        """Time without faults after which the force returns [s]."""

    @settle.setter
    def settle(self, arg: float, /) -> None: ...

    @property
    def lag_most(self) -> float:
        """Largest distance of the follower from its goal [m]."""

    @lag_most.setter
    def lag_most(self, arg: float, /) -> None: ...

    @property
    def slowest(self) -> float:
        """
        Largest mean interval between two states of the leader [periods of the cycle].
        """

    @slowest.setter
    def slowest(self, arg: float, /) -> None: ...

class CrtkGates:
    """States reported by the console and the arms; False until reported."""

    def __init__(self) -> None: ...

    @property
    def following(self) -> bool:
        """The teleoperation is active."""

    @following.setter
    def following(self, arg: bool, /) -> None: ...

    @property
    def operator_present(self) -> bool:
        """An operator is at the console."""

    @operator_present.setter
    def operator_present(self, arg: bool, /) -> None: ...

    @property
    def clutch(self) -> bool:
        """The clutch pedal is pressed."""

    @clutch.setter
    def clutch(self, arg: bool, /) -> None: ...

    @property
    def camera(self) -> bool:
        """The camera pedal is pressed."""

    @camera.setter
    def camera(self, arg: bool, /) -> None: ...

    @property
    def leader_enabled(self) -> bool:
        """The leader is enabled and homed."""

    @leader_enabled.setter
    def leader_enabled(self, arg: bool, /) -> None: ...

    @property
    def follower_enabled(self) -> bool:
        """The follower is enabled and homed."""

    @follower_enabled.setter
    def follower_enabled(self, arg: bool, /) -> None: ...

    @property
    def second_writer(self) -> bool:
        """Another program publishes wrenches to the leader."""

    @second_writer.setter
    def second_writer(self, arg: bool, /) -> None: ...

    @property
    def other_teleop(self) -> bool:
        """Another teleoperation is active although own_teleop is set."""

    @other_teleop.setter
    def other_teleop(self, arg: bool, /) -> None: ...

    @property
    def frame_unsure(self) -> bool:
        """
        The leader may take wrenches in another frame, or does not compensate its own weight.
        """

    @frame_unsure.setter
    def frame_unsure(self, arg: bool, /) -> None: ...

    @property
    def guarded(self) -> bool:
        """The guardian has latched or is missing."""

    @guarded.setter
    def guarded(self, arg: bool, /) -> None: ...

    @property
    def two_sources(self) -> bool:
        """Several nodes publish one of the inputs."""

    @two_sources.setter
    def two_sources(self, arg: bool, /) -> None: ...

    @property
    def no_listener(self) -> bool:
        """Nobody receives the wrenches."""

    @no_listener.setter
    def no_listener(self, arg: bool, /) -> None: ...

    @property
    def base_moved(self) -> bool:
        """An arm reports its pose in another frame than at the start."""

    @base_moved.setter
    def base_moved(self, arg: bool, /) -> None: ...

class CrtkCycle:
    """
    Haptic cycle from stamped messages to a wrench for the leader; it contains no network code. stamp: time of the
    sender since 1970 [s]; t: monotonic time [s]; wall: system time since 1970 [s].
    """

    def __init__(self, options: CrtkOptions, follower: Arm | None = None) -> None: ...

    def leader_pose(
        self,
        stamp: float,
        p_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        quat_xyzw: Annotated[NDArray[numpy.float64], "(4,)"],
        t: float,
        wall: float,
    ) -> None:
        """Receives measured_cp of the leader [m]."""

    def leader_twist(
        self,
        stamp: float,
        v_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        w_LH: Annotated[NDArray[numpy.float64], "(3,)"],
        t: float,
        wall: float,
    ) -> None:
        """Receives measured_cv of the leader [m/s, rad/s]."""

    def leader_joints(self, stamp: float, q: Annotated[NDArray[numpy.float64], "(:,)"]) -> None:
        """Receives measured_js of the leader (n,) [rad, m]."""

    def gripper(self, stamp: float, q: Annotated[NDArray[numpy.float64], "(:,)"]) -> None:
        """Receives gripper/measured_js of the leader (1,) [rad]."""

    def follower_pose(
        self,
        stamp: float,
        p_BT: Annotated[NDArray[numpy.float64], "(3,)"],
        quat_xyzw: Annotated[NDArray[numpy.float64], "(4,)"],
        t: float,
        wall: float,
    ) -> None:
        """Receives measured_cp of the follower [m]."""

    def follower_joints(
        self,
        stamp: float,
        q: Annotated[NDArray[numpy.float64], "(:,)"],
        t: float,
        wall: float,
    ) -> None:
        """Receives measured_js of the follower (n,) [rad, m]."""

    def jaw(self, stamp: float, q: Annotated[NDArray[numpy.float64], "(:,)"]) -> None:
        """Receives jaw/measured_js of the follower (1,) [rad]."""

    def set_scale(self, scale: float) -> None:
        """Sets the motion scale reported by another program's teleoperation [-]."""

    def set_gates(self, gates: CrtkGates) -> None:
        """Sets the states of console and arms."""

    def set_controls(self, controls: Controls) -> None:
        """Sets the operator's controls."""

    def set_scene(self, snapshot: Snapshot) -> None:
        """Replaces the scene; contact is reset."""

    def drop(self) -> None:
        """
        Resets the rendered force to zero, after another program has set it to zero.
        """

    def step(
        self,
        t: float,
        wall: float,
    ) -> tuple[
        NDArray[numpy.float64],
        Annotated[NDArray[numpy.float64], "(6,)"] | None,
        Annotated[NDArray[numpy.float64], "(4, 4)"] | None,
        float,
    ]:
        """
        One tick at time t [s]: (row of signals, wrench (6,) [N, N m] or None if no wrench may be sent, goal X_BT (4, 4)
        or None, jaw [rad]).
        """

class DeviceFault(enum.Enum):
    """Reason for which a state of the device was not used."""

    none = 0

    not_finite = 1

    not_rigid = 2

    left_handed = 3

    time_not_increasing = 4

    gap = 5

    too_often = 6

    driver_failed = 7

class DeviceCycle:
    """
    The haptic cycle for a device in anybody's loop: each step takes one state, returns a wrench.
    """

    def __init__(self, options: CrtkOptions, follower: Arm, snapshot: Snapshot) -> None: ...

    def start(self) -> None:
        """Allocates the queue of rows."""

    def stop(self) -> None:
        """Ends the collision queries."""

    def step(
        self,
        t: float,
        X_LH: Annotated[NDArray[numpy.float64], "(4, 4)"],
        V_LH: Annotated[NDArray[numpy.float64], "(6,)"] | None,
        gripper: float,
        clutch: bool,
        F: Annotated[NDArray[numpy.float64], "(6,)"],
    ) -> DeviceFault:
        """
        One step at time t [s]: pose X_LH (4, 4) [m], velocity V_LH (6,) [m/s, rad/s] or None, gripper [rad]. Writes the
        wrench on the hand, in L, to F (6,) [N, N m], and returns why the state was not used.
        """

    def report_failure(self, F: Annotated[NDArray[numpy.float64], "(6,)"]) -> None:
        """
        Sets the wrench to zero and records that the device cannot be read; writes zeros to F (6,).
        """

    def replay(
        self,
        t: Annotated[NDArray[numpy.float64], "(:,)"],
        X_LH: Annotated[NDArray[numpy.float64], "(:, 4, 4)"],
        F: Annotated[NDArray[numpy.float64], "(:, 6)"],
    ) -> None:
        """
        Steps at all times t (n,) [s] with poses X_LH (n, 4, 4) [m]; writes the wrenches to F (n, 6) [N, N m].
        """

    def attach(self, remote: RemoteEnd | None) -> None:
        """
        Lets the hand feel what this end of a link renders; None: the objects of the cycle. Not while it runs.
        """

    def allow_force(self, allowed: bool) -> None:
        """False: the wrench ramps to zero."""

    @property
    def gripper_torque(self) -> float:
        """
        Torque on the operator's fingers after the last step, positive when it opens them [N m].
        """

    @property
    def status(self) -> int:
        """Bits of Status of the last step."""

    @property
    def period(self) -> float:
        """Mean time between steps; 0: unknown [s]."""

    def timing(self) -> dict[str, Any]:
        """Compute times of the steps: p50, p99, p999 and max [us]."""

    def drain(self) -> Annotated[NDArray[numpy.float64], "(:, :)"]:
        """Rows since the last drain, in real time (n, TICK_BYTES/8)."""

    @property
    def dropped(self) -> int:
        """Number of rows lost because they were not drained in time."""

    def latest(self) -> NDArray[numpy.float64]:
        """The newest row (TICK_BYTES/8,)."""

    def soft_vertices(self, object: int) -> NDArray[numpy.float64]:
        """
        Deformed surface of a soft object: vertices (n, 3) in the object's frame O [m], in the order of
        TissueSurface.vertices. The loop publishes them every 16 ms. Raises ValueError if the object does not exist or
        is not soft.
        """

    @property
    def controls(self) -> Controls:
        """
        The operator's controls. This is a copy: assign a whole one, which applies from the next tick on.
        """

    @controls.setter
    def controls(self, arg: Controls, /) -> None: ...

    def set_fixtures(self, fixtures: FixtureList) -> None:
        """
        Replaces the fixtures of guidance at the next tick, without a step in the force.
        """

    def set_snapshot(self, snapshot: Snapshot) -> None:
        """
        Replaces the scene at the next tick. Contact goes on if the number, names and surfaces of the objects stay the
        same, and starts anew otherwise.
        """

    def set_live(self, targets: LiveTargets) -> None:
        """
        Sets the poses that the live objects of the newest snapshot shall reach, from the next tick on. Raises
        ValueError if their number differs.
        """

    def join(self, board: Board, index: int, capsules: Sequence[ToolCapsule], stiffness: float, damping: float) -> None:
        """
        Puts the instrument among those of other loops, which push it apart with a stiffness [N/m] and a damping [N
        s/m]. index: its number among them. Not while the loop runs.
        """

    def join_bodies(self, bodies: Bodies, tool: int) -> None:
        """
        Puts the tool among rigid bodies, as the tool of this number. A simulation that has the only tool advances them
        in lockstep. Not while the loop runs.
        """

def glide_together(
    cycles: Sequence[DeviceCycle],
    bodies: Sequence[Bodies],
    t: Annotated[NDArray[numpy.float64], "(:,)"],
    dt: float,
    steps: int,
    from_: Annotated[NDArray[numpy.float64], "(:, 7)"],
    to: Annotated[NDArray[numpy.float64], "(:, 7)"],
    rows: Annotated[NDArray[numpy.float64], "(:, 487)"],
    felt: Annotated[NDArray[numpy.float64], "(:,)"],
) -> None:
    """
    Steps the cycles of several worlds from their times t (worlds,) [s] by `steps` steps of dt [s], each along a
    straight path of the handle: displacement [m], rotation vector [rad] and pinch angle [rad], from_ (n, 7) to `to` (n,
    7). Each world has equally many of the n cycles, and its entry of `bodies` unless that is empty. Writes the newest
    row of each to rows (n, TICK_BYTES/8), and the largest force on its hand to felt (n,) [N].
    """

class Driver:
    """An opened device, which a thread of the core reads and commands."""

    @property
    def name(self) -> str:
        """Name of the device."""

    @property
    def rate(self) -> float:
        """Rate of read and write [Hz]."""

    @property
    def force_max(self) -> float:
        """Largest force [N]."""

    @property
    def moment_max(self) -> float:
        """Largest moment [N m]."""

    @property
    def workspace(self) -> tuple[float, float, float]:
        """Lengths of the workspace (3) [m]."""

    @property
    def resolution(self) -> float:
        """Step of the measured position; 0: unknown [m]."""

    @property
    def mass(self) -> float:
        """Moving mass at the handle; 0: unknown [kg]."""

    @property
    def delay(self) -> float:
        """Time from a measurement to the force on the hand; 0: unknown [s]."""

    @property
    def friction(self) -> float:
        """Dry friction that certainly resists the handle [N]."""

    @property
    def damping(self) -> float:
        """Viscous friction that certainly resists the handle [N s/m]."""

    @property
    def notices(self) -> list[str]:
        """What has happened to the device since it was opened: cause; mend."""

class SharedObject(Driver):
    """
    A driver in C: a shared object with the functions of palpate/loop/driver.h.
    """

    def __init__(self, file: str, argument: str = '') -> None:
        """Loads the shared object and opens the device."""

class DriverThread:
    """Reads a driver, steps the cycle and writes, in real time."""

    def __init__(self, driver: Driver, cycle: DeviceCycle) -> None: ...

    def start(self) -> None:
        """Starts the real-time thread."""

    def stop(self) -> None:
        """
        Ramps the force to zero and ends the threads, within a second even if the driver hangs.
        """

    def fault(self) -> str:
        """Why the loop ended by itself or hangs; empty if neither."""

    @property
    def buttons(self) -> int:
        """Buttons of the newest measurement, as `Reading.buttons`."""

    @property
    def stalls(self) -> int:
        """Number of calls for which the watchdog wrote zero force."""

    def timing(self) -> dict[str, Any]:
        """
        Punctuality so far: lateness_us, slack_us, ticks, missed_ticks, scheduler.
        """

def schedule(priority: bool = True) -> str:
    """
    Requests SCHED_FIFO, locked memory and short timer slack for the calling thread, not for those that it begins, or
    normal scheduling again (False). Returns what was granted.
    """
