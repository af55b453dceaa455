"""Draws the rigid bodies of a scene, and shows how its task stands."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import viser

from palpate.base.arrays import Array
from palpate.base.arrays.so3 import quaternions
from palpate.world.bodies.shapes import Solid, by_color, triangles


class BodiesDrawing:
    """Each body, and each link of a thread, as one mesh per colour; `show` moves what moves.

    Args:
        scene: where to draw.
        solids: what to draw, at first at its start.
        places: position [m] and quaternion w x y z (7,) of what moves, in W, by name.
    """

    def __init__(
        self, scene: viser.SceneApi, solids: Sequence[Solid], places: Callable[[], Mapping[str, Array]]
    ) -> None:
        self._places, self._moving = places, {}
        for solid in solids:
            node = f"/bodies/{solid.name.replace('/', '_')}"
            frame = scene.add_frame(node, show_axes=False)
            self._place(frame, np.r_[solid.X_WO[:3, 3], quaternions(solid.X_WO[:3, :3])])
            for k, (color, some) in enumerate(by_color(solid.shapes).items()):
                vertices, faces, _ = triangles(some)
                scene.add_mesh_simple(f"{node}/{k}", vertices, faces, color=color, flat_shading=True)
            if solid.moves:
                self._moving[solid.name] = frame

    def show(self) -> None:
        """Moves the bodies to where they are."""
        for name, place in self._places().items():
            if name in self._moving:
                self._place(self._moving[name], place)

    @staticmethod
    def _place(frame: Any, place: Array) -> None:
        if np.isfinite(place).all():
            frame.position, frame.wxyz = place[:3], place[3:]


class TaskWords:
    """How the task stands, in a folder of the panel."""

    def __init__(self, gui: viser.GuiApi, words: Callable[[], str]) -> None:
        self._words, self._shown = words, ""
        with gui.add_folder("Task"):
            self._text = gui.add_markdown(words())

    def show(self) -> None:
        """Shows the present words."""
        words = self._words()
        if words != self._shown:
            self._text.content = self._shown = words


def jaw_slider(gui: viser.GuiApi, send: Callable[[float], None]) -> viser.GuiSliderHandle[float]:
    """The slider that pinches the simulated hand's fingers."""
    # no hint: viser then puts label and slider into one row, which leaves the slider no width in a narrow panel
    slider = gui.add_slider("jaws open [deg]", 0.0, 60.0, 1.0, 50.0)
    slider.on_update(lambda _: send(float(np.radians(slider.value))))
    return slider
