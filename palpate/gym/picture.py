"""What the endoscope of a scene sees of the instruments that a policy moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.export.video.arms import ArmBodies
from palpate.export.video.drawing import Canvas
from palpate.export.video.film import color_of, endoscope
from palpate.export.video.solids import SolidBodies
from palpate.record.ticks import Ticks
from palpate.scene.rig import Rig
from palpate.world.bodies.engine import World


class Eye:
    """The left eye of the endoscope; one that sees the start of the tools if the scene has none.

    Args:
        rigs: those of all pairs of the scene; objects are drawn at rest.
        size: height and width of a picture [pixels].
        shift: displacement (3,) of all objects from their place in the scene [m].

    Raises:
        MissingExtraError, PalpateError: moderngl or OpenGL without a window is missing.
    """

    def __init__(self, rigs: Sequence[Rig], size: tuple[int, int], shift: Array | None = None) -> None:
        rig = rigs[0]
        starts = [one.arms.X_WB @ one.arms.follower.fk(one.arms.q_follower0) for one in rigs]
        self._ecm = endoscope(rig.scene, np.mean(starts, axis=0)[:3, 3])
        self._canvas = Canvas(size, self._ecm.section.endoscope.width_deg)
        for k, surface in enumerate(rig.surfaces):
            body, X_WO = surface.body, np.array(surface.X_WO)
            X_WO[:3, 3] += 0.0 if shift is None else shift
            self._canvas.add(body.vertices, body.triangles, color_of(rig.scene.objects[k], k), 0.25, X_WO)
        self._solids = SolidBodies(self._canvas, rig.scene)
        self._arms = [ArmBodies(self._canvas, one.arms.follower, one.arms.X_WB) for one in rigs]

    def pictures(self, ticks: Ticks, engines: Sequence[World | None]) -> NDArray[np.uint8]:
        """Pictures (n, height, width, 3) of ticks (n,), or (n, hands), and of the rigid bodies of each world."""
        found = []
        for row, engine in zip(ticks.reshape(len(ticks), -1), engines, strict=True):
            self._solids.move({} if engine is None else engine.drawn())
            for arm, tick in zip(self._arms, row, strict=True):
                arm.move(np.asarray(tick["q_follower"]), float(tick["jaw"]))
            found.append(self._canvas.picture(self._ecm.eye(self._ecm.q0, "left")))
        return np.stack(found)

    def close(self) -> None:
        """Release what draws."""
        self._canvas.close()
