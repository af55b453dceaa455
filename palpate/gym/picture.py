"""What the endoscope of a scene sees of the instruments that a policy moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from palpate.export.video.arms import ArmBodies
from palpate.export.video.drawing import Canvas
from palpate.export.video.film import TISSUE, endoscope
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig


class Eye:
    """The left eye of the endoscope; one that sees the start of the tool if the scene has none.

    Args:
        rigs: those of all pairs of the scene; objects are drawn at rest, and rigid bodies not at all.
        size: height and width of a picture [pixels].

    Raises:
        MissingExtraError, PalpateError: moderngl or OpenGL without a window is missing.
    """

    def __init__(self, rigs: Sequence[Rig], size: tuple[int, int]) -> None:
        rig, arms = rigs[0], rigs[0].arms
        self._ecm = endoscope(rig.scene, np.asarray(arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3])
        self._canvas = Canvas(size, self._ecm.section.endoscope.width_deg)
        for k, surface in enumerate(rig.surfaces):
            body = surface.body
            self._canvas.add(body.vertices, body.triangles, TISSUE[k % len(TISSUE)], 0.25, surface.X_WO)
        self._arms = [ArmBodies(self._canvas, one.arms.follower, one.arms.X_WB) for one in rigs]

    def pictures(self, ticks: Ticks) -> NDArray[np.uint8]:
        """Pictures (n, height, width, 3) of ticks (n,), or (n, hands)."""
        found = []
        for row in ticks.reshape(len(ticks), -1):
            for arm, tick in zip(self._arms, row, strict=True):
                arm.move(np.asarray(tick["q_follower"]), float(tick["jaw"]))
            found.append(self._canvas.picture(self._ecm.eye(self._ecm.q0, "left")))
        return np.stack(found)

    def close(self) -> None:
        """Release what draws."""
        self._canvas.close()
