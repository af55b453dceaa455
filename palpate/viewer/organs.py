"""Draws the objects that can be touched, with their regions of different stiffness, and moves them."""

from __future__ import annotations

import numpy as np
import viser
from viser.transforms import SE3

from palpate.record import live
from palpate.record.ticks import Ticks
from palpate.viewer.stage import RegionMark, TouchedObject

Color = tuple[int, int, int]

TINT: Color = (222, 178, 62)
"""Colour of a region: of the object's triangles inside the region, and of the region's own body."""


class OrganDrawing:
    """One object, split by region, under a frame that moves."""

    def __init__(self, scene: viser.SceneApi, obj: TouchedObject, color: Color) -> None:
        """Draws the object at its rest pose."""
        self._moving, self._slot = obj.moving, obj.slot
        name = f"/objects/{obj.name}"
        X = SE3.from_matrix(obj.X_WO)
        self._frame = scene.add_frame(name, show_axes=False, wxyz=X.rotation().wxyz, position=X.translation())
        tinted = np.any([mark.triangles for mark in obj.regions], axis=0) if obj.regions else None
        parts = (
            [(obj.triangles, color)]
            if tinted is None
            else [(obj.triangles[~tinted], color), (obj.triangles[tinted], TINT)]
        )
        self._parts = [
            scene.add_mesh_simple(
                f"{name}/{k}",
                obj.vertices.astype(np.float32),
                triangles.astype(np.uint32),
                color=shade,
                side="double",
            )
            for k, (triangles, shade) in enumerate(parts)
            if len(triangles)
        ]
        for k, mark in enumerate(obj.regions):
            _body(scene, f"{name}/region{k}", mark)

    def see_through(self, share: float) -> None:
        """Sets the transparency: 0 opaque, up to 0.9."""
        for part in self._parts:
            part.opacity = None if share < 0.01 else 1.0 - share

    def show(self, tick: Ticks) -> None:
        """Moves the object to its pose at a tick."""
        X_WO = self._moving(float(tick["t"])) if self._moving is not None else None
        if self._slot is not None:
            X_WO = live.object_pose(tick, self._slot)
        if X_WO is None:
            return
        X = SE3.from_matrix(X_WO)
        self._frame.wxyz, self._frame.position = X.rotation().wxyz, X.translation()


def _body(scene: viser.SceneApi, name: str, mark: RegionMark) -> None:
    """Draws a region slightly too small, so that coincident surfaces do not flicker."""
    if mark.half.any():
        x, y, z = (0.98 * 2.0 * (mark.half + mark.radius)).tolist()
        scene.add_box(name, TINT, (x, y, z), position=mark.centre, cast_shadow=False)
    else:
        scene.add_icosphere(name, 0.98 * mark.radius, TINT, position=mark.centre, cast_shadow=False)
