"""Data that the viewer draws, independent of session and browser."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.record.snapshots import BodyTrack, Track
from palpate.record.ticks import Ticks
from palpate.scene.graspable import GraspableSection
from palpate.scene.placed_ecm import PlacedEcm
from palpate.scene.remote import UNKNOWN
from palpate.scene.tool import LinkSphere
from palpate.world.bodies.shapes import Solid


@dataclass(frozen=True)
class ArmPlace:
    """An arm and the pose of its base."""

    name: str
    """First part of the node names: `leader` or `follower`."""
    arm: Arm
    """Separate instance for the viewer: an arm has a workspace and cannot be shared between threads."""
    X_WA: Array
    """(4, 4) pose of the base in W [m]."""


@dataclass(frozen=True)
class RegionMark:
    """A region of different stiffness in an object: a box with rounded edges, or a ball."""

    name: str
    centre: Array
    """(3,) centre in the object's frame O [m]."""
    half: Array
    """(3,) half lengths of the box; zero for a ball [m]."""
    radius: float
    """Radius of the ball, or of the rounded edges [m]."""
    triangles: NDArray[np.bool_]
    """(m,) True for the object's triangles inside the region."""


@dataclass(frozen=True)
class TouchedObject:
    """An object that can be touched."""

    name: str
    vertices: Array
    """(n, 3) vertices in the object's frame O [m]."""
    triangles: NDArray[np.int32]
    """(m, 3) vertex indices."""
    X_WO: Array
    """(4, 4) rest pose in W [m]."""
    regions: tuple[RegionMark, ...] = ()
    moving: Callable[[float], Array] | None = None
    """X_WO (4, 4) [m] at a time [s]; None for a static object."""
    color: tuple[int, int, int] | None = None
    """Colour in the scene, red, green, blue from 0 to 255; None without one."""
    colors: Array | None = None
    """(n, 3) colours of the vertices in the mesh file, 0 to 255; None without colours."""
    is_cloud: bool = False
    """True if each triangle is a point of a cloud; they take no dent."""
    soft: bool = False
    """True if the loop deforms the object; the vertices are then those of the loop's surface at rest."""
    holds: bool = False
    """True if another object lies inside: the object is then drawn transparent."""
    hidden: bool = False
    """True if a simulated remote site alone has the object, so that the hand knows nothing of it."""
    slot: int | None = None
    """Number among the objects that follow a tracker, whose poses a tick holds; None for another object."""


def _empty() -> Array:
    return np.zeros((0, 3))


def _no_triangles() -> NDArray[np.int32]:
    return np.zeros((0, 3), dtype=np.int32)


@dataclass(frozen=True)
class FixtureMark:
    """A virtual fixture at its pose in the scene: a body, a curve or a point, and its margin. All in W [m]."""

    name: str
    forbids: bool
    """True for a forbidden region, drawn red; the others are drawn green."""
    middle: Array
    """(3,) position of the name and of the handle."""
    curve: Array = field(default_factory=_empty)
    """(n, 3) points along a path or a line; a single point for a point fixture."""
    vertices: Array = field(default_factory=_empty)
    """(n, 3) vertices of the surface."""
    triangles: NDArray[np.int32] = field(default_factory=_no_triangles)
    margin_vertices: Array = field(default_factory=_empty)
    margin_triangles: NDArray[np.int32] = field(default_factory=_no_triangles)
    moving: Callable[[float], Array] | None = None
    """Displacement (4, 4) since the start at a time [s]; None for a static fixture."""


@dataclass(frozen=True)
class PlacedFrame:
    """A frame of the scene's list `frames`."""

    name: str
    X_WF: Array
    """(4, 4) pose in W at the start [m]."""
    tracked: bool = False
    """True if a tracker sees it: the spheres of its marker are drawn."""
    moving: Callable[[Ticks], Array | None] | None = None
    """X_WF (4, 4) [m] at a tick, None if it is unknown; None for a frame at rest."""


@dataclass(frozen=True)
class TargetMark:
    """A target of the scene's registration."""

    name: str
    p_W: Array
    """(3,) position in W [m]."""
    covariance: Array
    """(3, 3) of its predicted error in W [m^2]."""
    newest: Callable[[], tuple[Array, Array]] | None = None
    """Newest position and covariance while a registration runs; None for a registration that is done."""


@dataclass(frozen=True)
class DeviceMark:
    """A device that leads, in place of a simulated arm."""

    name: str
    """Its driver."""
    X_WL: Array
    """(4, 4) pose of its base in W [m]."""
    workspace: Array | None
    """(3,) lengths of its workspace along the axes of its base [m]; None: unknown."""
    centre: Array | None
    """(3,) centre of the workspace in its base [m]; None: the first position of the handle."""
    mapping: str
    """Law of the mapping and motion of the tool per motion of the hand, in words."""
    scale: float = 1.0
    """Motion of the tool per motion of the hand [-]."""


@dataclass(frozen=True)
class Stage:
    """The scene before any motion: objects, arms, fixtures, and values for the gauges."""

    title: str
    objects: list[TouchedObject]
    leader: ArmPlace
    follower: ArmPlace
    radius: float
    """Radius of the sphere on the tool tip [m]."""
    stiffness: float
    """Stiffness of the first object [N/m], which is scale 1 on the console."""
    damping: float
    """Damping of the first object [N s/m], which is scale 1 on the console."""
    force_cap: float
    """Force cap of the scene [N]."""
    motion_scale: float
    """Tool motion per hand motion [-]."""
    focus: Array = field(default_factory=lambda: np.zeros(3))
    """(3,) point that the camera looks at, in W [m]."""
    extent: float = 0.4
    """Width of the region that the camera must show [m]."""
    pseudo_haptic: bool = False
    """True if the drawn tool stays on the surface: for a device that renders no force."""
    seen: Array = field(default_factory=_empty)
    """(n, 3) points that the overview shows, in W [m]; without points, the region around the focus."""
    stable_below: Callable[[float], float] | None = None
    """Largest stable stiffness of the first object [N/m] for a damping [N s/m]; None when unknown."""
    spheres: tuple[LinkSphere, ...] = ()
    """Tool spheres in addition to the one at the tip."""
    near: Callable[[Ticks], str] | None = None
    """Says what is nearest to a tool that touches nothing."""
    fixtures: tuple[FixtureMark, ...] = ()
    """Guidance fixtures in the scene's order."""
    frames: tuple[PlacedFrame, ...] = ()
    """Frames of the scene, without arms and objects."""
    carried: tuple[str, ...] = ()
    """Names of the contact spheres on the object that the jaws can carry."""
    rod: GraspableSection | None = None
    """The rod that the instruments can hold."""
    targets: tuple[TargetMark, ...] = ()
    """Targets of the scene's registration."""

    device: DeviceMark | None = None
    """The device that leads; None: a simulated arm."""
    ecm: PlacedEcm | None = None
    """The endoscope arm."""
    shapes: Mapping[int, Track] = field(default_factory=dict)
    """Recorded displacement (n, 3) [m] of the vertices of soft objects, by the object's number."""
    solids: tuple[Solid, ...] = ()
    """Rigid bodies and the links of their threads."""
    bodies: BodyTrack | None = None
    """Recorded poses of the rigid bodies."""
    camera: Track | None = None
    """Recorded joints (4,) of the endoscope arm [rad, m]."""

    def touches(self, tick: Ticks) -> list[str]:
        """Contact pairs with the force of the surface before all caps, the strongest first."""
        pairs = zip(tick["touch_sphere"], tick["touch_object"], tick["touch_force"], strict=True)
        names = ["tip", *(sphere.name for sphere in self.spheres), *self.carried]
        objects = [*(obj.name for obj in self.objects), UNKNOWN]
        return [
            f"{names[int(s)]} on {objects[int(o)]}: {force:.2f} N before caps"
            for s, o, force in list(pairs)[: int(tick["contacts"])]
        ]
