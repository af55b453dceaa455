"""An edge of the graph of frames: the pose of one frame in another, with its covariance, source and age."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import FrameError
from palpate.world.frames import checks


def _none() -> Array:
    return np.zeros((6, 6))


@dataclass(frozen=True)
class Edge:
    """Pose of the frame `child` in the frame `parent`.

    Raises:
        FrameError: a name is empty, both names are equal, or the pose or its covariance is invalid.
    """

    parent: str
    child: str
    X: Array
    """X_parent_child (4, 4) [m]"""
    covariance: Array = field(default_factory=_none)
    """covariance (6, 6) of ``[dp; dtheta]`` in the parent frame (`palpate.base.arrays.rigid`) [m, rad]"""
    source: str = ""
    """origin of the pose: a file, a tracker, a registration method"""
    kind: Literal["known", "measured", "live"] = "known"
    """known: exact by definition; measured: a registration; live: replaced while a session runs"""
    stamp: float | None = None
    """time of the measurement, seconds since 1970; None: unknown"""
    check: bool = False
    """True: a second path to `child`, which is compared with the first and places nothing"""
    fre_m: float | None = None
    """rms residual of the registration [m]"""
    tre_m: float | None = None
    """predicted error of the registration at its target [m]"""

    def __post_init__(self) -> None:
        for name in (self.parent, self.child):
            if not name or name != name.strip():
                raise FrameError(f"a frame is named {name!r}", mend="give parent and child a name")
        if self.parent == self.child:
            raise FrameError(f"frame {self.child!r} is placed in itself", mend="name another parent")
        name = f"X_{self.parent}_{self.child}"
        X, C = checks.pose(name, self.X), checks.covariance(f"the covariance of {name}", self.covariance)
        if self.stamp is not None and not math.isfinite(self.stamp):
            raise FrameError(f"the stamp of {name} is {self.stamp}", mend="give seconds since 1970, or leave it out")
        for array in (X, C):
            array.flags.writeable = False
        object.__setattr__(self, "X", X)
        object.__setattr__(self, "covariance", C)

    def age(self, now: float) -> float | None:
        """Time since the measurement [s]; None if its stamp is unknown. now: seconds since 1970."""
        return None if self.stamp is None else now - self.stamp


def isotropic(sigma_m: float, sigma_rad: float) -> Array:
    """Covariance (6, 6) of a pose with the same standard deviation on each axis [m, rad]."""
    return np.diag([sigma_m**2] * 3 + [sigma_rad**2] * 3)
