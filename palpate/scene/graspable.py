"""Section `graspable` of a scene: a rigid rod that the instruments of several pairs hold and hand over."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from palpate import _core
from palpate.base.values import Pose, Positive, Section

CARRIED = -2
"""`link` of a contact sphere on the object that the jaws carry."""


class GraspableSection(Section):
    """A rigid rod with round ends, such as a needle or a peg; its axis is z of its frame O, which is in its middle.

    Jaws that stand on both sides of the rod and touch it hold it. Where nobody holds it, it stays.
    """

    name: str = "rod"
    """name of the object"""
    length: Annotated[Positive, Field(le=0.3)] = 0.03
    """length of the axis, without the round ends [m]"""
    radius: Annotated[Positive, Field(le=0.02)] = 0.001
    """radius [m]"""
    pose: Pose = Field(default_factory=Pose)
    """X_WO: pose at the start"""
    stiffness: Annotated[Positive, Field(le=5000.0)] = 500.0
    """of the spring that both hands feel while two instruments hold the rod [N/m]"""
    hold: Annotated[Positive, Field(le=20.0)] = 3.0
    """largest force of this spring; beyond it the rod slips in the jaws [N]"""

    def core(self) -> _core.RodOptions:
        """The rod as the core takes it."""
        rod = _core.RodOptions()
        rod.a, rod.b = self.ends
        rod.radius, rod.stiffness, rod.hold = self.radius, self.stiffness, self.hold
        rod.X_WO = self.pose.matrix()
        return rod

    @property
    def ends(self) -> np.ndarray:
        """Ends of the axis (2, 3) in O [m]."""
        return np.array([[0.0, 0.0, -0.5 * self.length], [0.0, 0.0, 0.5 * self.length]])

    def spheres(self) -> list[tuple[str, _core.ToolSphere]]:
        """Names and contact spheres of the rod, with which it touches the objects of the scene while it is carried."""
        a, b = self.ends
        return [
            (f"{self.name} {k + 1}", _core.ToolSphere(a + share * (b - a), self.radius, CARRIED))
            for k, share in enumerate((0.0, 0.5, 1.0))
        ]
