"""Draws the frames of a scene as axes with their names, tracked ones with the spheres of their marker."""

from __future__ import annotations

import numpy as np
import viser
from viser.transforms import SE3

from palpate.record.ticks import Ticks
from palpate.sensing.trackers.simulated import SPHERES
from palpate.viewer.labels import Label, point_of
from palpate.viewer.stage import PlacedFrame

_AXES = 0.035
"""Length of the axes [m]; red x, green y, blue z."""
_SPHERE = 0.006
"""Radius of a marker's spheres [m]."""
_SILVER = (205, 208, 214)


class FrameDrawing:
    """One frame; it moves if the frame is live."""

    def __init__(self, scene: viser.SceneApi, frame: PlacedFrame) -> None:
        """Draws the frame at its pose at the start."""
        self._place = frame
        name = f"/frames/{frame.name}"
        X = SE3.from_matrix(frame.X_WF)
        self.node = scene.add_frame(
            name, axes_length=_AXES, axes_radius=0.03 * _AXES, origin_radius=0.06 * _AXES,
            wxyz=X.rotation().wxyz, position=X.translation(),
        )  # fmt: skip
        if frame.tracked:
            for k, p in enumerate(SPHERES):
                scene.add_icosphere(f"{name}/sphere{k}", _SPHERE, _SILVER, position=p, cast_shadow=False)
        up = np.array([0.0, 0.0, 1.1 * _AXES])
        label = scene.add_label(f"{name}/name", frame.name, position=up, anchor="bottom-center")
        self.label = Label(label, lambda: point_of(self.node, up), lambda: bool(self.node.visible))

    def show(self, tick: Ticks) -> None:
        """Moves a live frame to its pose at a tick."""
        X_WF = self._place.moving(tick) if self._place.moving is not None else None
        if X_WF is not None:
            X = SE3.from_matrix(X_WF)
            self.node.wxyz, self.node.position = X.rotation().wxyz, X.translation()
