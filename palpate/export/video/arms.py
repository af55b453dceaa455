"""An arm in a picture: a body for each of its links and colours."""

from __future__ import annotations

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.export.video.drawing import Body, Canvas
from palpate.viewer.solids import merged


class ArmBodies:
    """The primitives of an arm's links.

    Args:
        canvas: where to draw.
        arm: the arm.
        X_WA: pose (4, 4) of its base in W [m].
    """

    def __init__(self, canvas: Canvas, arm: Arm, X_WA: Array) -> None:
        self._arm, self._X_WA = arm, X_WA
        self._bodies: list[tuple[str, Body]] = []
        for link, colour in dict.fromkeys((visual.link, visual.colour) for visual in arm.visuals):
            points, triangles, _ = merged([v for v in arm.visuals if (v.link, v.colour) == (link, colour)])
            self._bodies.append((link, canvas.add(points, triangles, [255 * c for c in colour[:3]], 0.5)))

    def move(self, q: Array, jaw: float) -> None:
        """Move the links to joints q (n,) or longer [rad, m] and a jaw angle, which counts as closed if it is NaN."""
        poses = self._arm.link_poses(q[: self._arm.n], float(np.nan_to_num(jaw)))
        for link, body in self._bodies:
            body.X_WB = self._X_WA @ poses[link]
