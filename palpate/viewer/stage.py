"""What the viewer draws, as plain data: no session, no browser."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm
from palpate.arrays import Array
from palpate.record.ticks import Ticks
from palpate.scene.tool import LinkSphere


@dataclass(frozen=True)
class ArmPlace:
    """An arm and where its base stands."""

    name: str
    """First part of the names of its nodes: `leader` or `follower`."""
    arm: Arm
    """One of its own: an arm holds a workspace and is not shared between threads."""
    X_WA: Array
    """(4, 4) pose of the base in the world [m]."""


@dataclass(frozen=True)
class RegionMark:
    """Where an object feels otherwise: a box with round edges, or a ball."""

    name: str
    centre: Array
    """(3,) [m] in the object's frame O."""
    half: Array
    """(3,) half the lengths of the box; zero for a ball [m]."""
    radius: float
    """Of the ball, or of the round edges [m]."""
    triangles: NDArray[np.bool_]
    """(m,) those of the object's triangles that lie in it."""


@dataclass(frozen=True)
class Thing:
    """An object that can be touched."""

    name: str
    vertices: Array
    """(n, 3) [m] in the object's frame O."""
    triangles: NDArray[np.int32]
    """(m, 3)."""
    X_WO: Array
    """(4, 4), at rest."""
    regions: tuple[RegionMark, ...] = ()
    moving: Callable[[float], Array] | None = None
    """X_WO (4, 4) at a time [s]; None when it rests."""


def _none() -> Array:
    return np.zeros((0, 3))


def _no_triangles() -> NDArray[np.int32]:
    return np.zeros((0, 3), dtype=np.int32)


@dataclass(frozen=True)
class FixtureMark:
    """A virtual fixture, where the scene has it: a body, a curve or a point, and its margin. All in W [m]."""

    name: str
    forbids: bool
    """Drawn red; what is allowed is green."""
    middle: Array
    """(3,) where its name and its handle are."""
    curve: Array = field(default_factory=_none)
    """(n, 3) along a path or a line; one point of a point."""
    vertices: Array = field(default_factory=_none)
    """(n, 3) of its surface."""
    triangles: NDArray[np.int32] = field(default_factory=_no_triangles)
    margin_vertices: Array = field(default_factory=_none)
    margin_triangles: NDArray[np.int32] = field(default_factory=_no_triangles)
    moving: Callable[[float], Array] | None = None
    """How it has moved since the start (4, 4) at a time [s]; None when it rests."""


@dataclass(frozen=True)
class Stage:
    """Everything that stands in the scene before anything moves."""

    title: str
    things: list[Thing]
    leader: ArmPlace
    follower: ArmPlace
    radius: float
    """Of the spherical proxy region on the tool tip [m]."""
    stiffness: float
    """Of the first object [N/m], what a scale of 1 on the console means."""
    damping: float
    """Of the first object [N s/m]."""
    force_cap: float
    """[N]."""
    motion_scale: float
    """Tool motion per hand motion [-]."""
    focus: Array = field(default_factory=lambda: np.zeros(3))
    """(3,) what the camera looks at [m], in the world."""
    extent: float = 0.4
    """How wide what the camera has to see is [m]."""
    stable_below: Callable[[float], float] | None = None
    """Largest stable stiffness of the first object for a damping [N s/m], [N/m]; None when it is not known."""
    spheres: tuple[LinkSphere, ...] = ()
    """Of the tool beside the one on its tip."""
    fixtures: tuple[FixtureMark, ...] = ()
    """Of guidance, in the scene's order."""

    def touches(self, tick: Ticks) -> list[str]:
        """The pairs that touch, the strongest first: `tip x liver 1.20 N`."""
        pairs = zip(tick["touch_sphere"], tick["touch_object"], tick["touch_force"], strict=True)
        names = ["tip", *(sphere.name for sphere in self.spheres)]
        return [
            f"{names[int(s)]} \u00d7 {self.things[int(o)].name} {force:.2f} N"
            for s, o, force in list(pairs)[: int(tick["contacts"])]
        ]
