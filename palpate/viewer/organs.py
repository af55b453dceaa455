"""What can be touched: each object with the regions that feel otherwise, and where it moves."""

from __future__ import annotations

import numpy as np
import viser
from viser.transforms import SE3

from palpate.viewer.stage import RegionMark, Thing

Color = tuple[int, int, int]

TINT: Color = (222, 178, 62)
"""Of a region: the object's triangles in it, and the body of it inside."""


class OrganDrawing:
    """One object, cut into what feels alike, under a frame that moves."""

    def __init__(self, scene: viser.SceneApi, thing: Thing, color: Color) -> None:
        """Draws it where it rests."""
        self._moving = thing.moving
        name = f"/objects/{thing.name}"
        X = SE3.from_matrix(thing.X_WO)
        self._frame = scene.add_frame(name, show_axes=False, wxyz=X.rotation().wxyz, position=X.translation())
        tinted = np.any([mark.triangles for mark in thing.regions], axis=0) if thing.regions else None
        parts = (
            [(thing.triangles, color)]
            if tinted is None
            else [(thing.triangles[~tinted], color), (thing.triangles[tinted], TINT)]
        )
        self._parts = [
            scene.add_mesh_simple(
                f"{name}/{k}",
                thing.vertices.astype(np.float32),
                triangles.astype(np.uint32),
                color=shade,
                side="double",
            )
            for k, (triangles, shade) in enumerate(parts)
            if len(triangles)
        ]
        for k, mark in enumerate(thing.regions):
            _body(scene, f"{name}/region{k}", mark)

    def see_through(self, share: float) -> None:
        """As solid as it is (0), or so that what is inside shows through it (up to 0.9)."""
        for part in self._parts:
            part.opacity = None if share < 0.01 else 1.0 - share

    def show(self, t: float) -> None:
        """Moves it to where it is at t [s]."""
        if self._moving is None:
            return
        X = SE3.from_matrix(self._moving(t))
        self._frame.wxyz, self._frame.position = X.rotation().wxyz, X.translation()


def _body(scene: viser.SceneApi, name: str, mark: RegionMark) -> None:
    """A little smaller than the region, so that its surface does not flicker with the object's."""
    if mark.half.any():
        x, y, z = (0.98 * 2.0 * (mark.half + mark.radius)).tolist()
        scene.add_box(name, TINT, (x, y, z), position=mark.centre, cast_shadow=False)
    else:
        scene.add_icosphere(name, 0.98 * mark.radius, TINT, position=mark.centre, cast_shadow=False)
