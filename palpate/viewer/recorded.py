"""What a replay draws from the snapshots of a record: soft objects, rigid bodies and the endoscope arm."""

from __future__ import annotations

import numpy as np
import viser

from palpate.base.arrays import Array
from palpate.viewer.bodies import BodiesDrawing
from palpate.viewer.drawing import Drawing
from palpate.viewer.soft_objects import SoftObjects
from palpate.viewer.stage import Stage


class Snapshots:
    """The soft objects, rigid bodies and the endoscope arm of a stage at one time of its record.

    A record without snapshots, for example an older one, shows the objects at rest, bodies and arm at their start.
    """

    def __init__(self, gui: viser.GuiApi, scene: viser.SceneApi, stage: Stage, drawing: Drawing) -> None:
        self._stage, self._drawing, self._t = stage, drawing, 0.0
        self._bodies = BodiesDrawing(scene, stage.solids, self.places) if stage.solids else None
        self.soft = SoftObjects(gui, stage, drawing, self) if stage.shapes else None

    def show(self, t: float) -> None:
        """Draws the time t [s]."""
        self._t = t
        if self.soft is not None:
            self.soft.show()
        if self._bodies is not None:
            self._bodies.show()
        if self._stage.ecm is not None:
            self._drawing.show_ecm(self.joints())

    def soft_vertices(self, index: int) -> Array:
        """Vertices (n, 3) of a soft object in its frame O [m] at the present time."""
        rest, track = self._stage.objects[index].vertices, self._stage.shapes.get(index)
        return rest if track is None else rest + track.at(self._t)

    def places(self) -> dict[str, Array]:
        """Position [m] and quaternion w x y z (7,) of each rigid body at the present time."""
        return {} if self._stage.bodies is None else self._stage.bodies.at(self._t)

    def joints(self) -> Array:
        """Joints (4,) of the endoscope arm at the present time [rad, m]."""
        assert self._stage.ecm is not None
        return np.asarray(self._stage.ecm.q0) if self._stage.camera is None else self._stage.camera.at(self._t)
