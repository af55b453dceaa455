"""What the viewer draws, as plain data: no session, no browser."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm

Array = NDArray[np.float64]


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
class Thing:
    """An object that can be touched."""

    name: str
    vertices: Array
    """(n, 3) [m] in the object's frame O."""
    triangles: NDArray[np.int32]
    """(m, 3)."""
    X_WO: Array
    """(4, 4)."""


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
