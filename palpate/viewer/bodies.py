"""Draws the rigid bodies of a scene, and shows how its task stands."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from palpate.bodies.engine import World
from palpate.bodies.shapes import triangles

_THREAD = (70, 70, 160)


class BodiesDrawing:
    """Each body as one mesh per colour, and its thread as capsules; `show` moves what moves."""

    def __init__(self, scene: viser.SceneApi, world: World) -> None:
        """Draws all bodies at their start."""
        self._world = world
        self._moving: list[tuple[str, Any]] = []
        places = world.drawn()
        for body in world.sections:
            node = f"/bodies/{body.name.replace('/', '_')}"
            frame = scene.add_frame(node, show_axes=False)
            self._place(frame, places[body.name])
            colors = {shape.color for shape in world.shapes[body.name]}
            for k, color in enumerate(sorted(colors)):
                some = [shape for shape in world.shapes[body.name] if shape.color == color]
                vertices, faces, _ = triangles(some)
                scene.add_mesh_simple(f"{node}/{k}", vertices, faces, color=color, flat_shading=True)
            if not body.fixed:
                self._moving.append((body.name, frame))
            for link, radius, length in world.links(body.name):
                import trimesh

                mesh = trimesh.creation.capsule(length, radius, count=[6, 6])
                link_frame = scene.add_frame(f"/bodies/{link.replace('/', '_')}", show_axes=False)
                scene.add_mesh_simple(f"/bodies/{link.replace('/', '_')}/mesh", np.asarray(mesh.vertices),
                                      np.asarray(mesh.faces), color=_THREAD)  # fmt: skip
                self._moving.append((link, link_frame))

    def show(self) -> None:
        """Moves the bodies to where they are."""
        places = self._world.drawn()
        for name, frame in self._moving:
            self._place(frame, places[name])

    @staticmethod
    def _place(frame: Any, place: np.ndarray) -> None:
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
    hint = "Pinch angle of the hand [deg]: 0 closes the jaws"
    slider = gui.add_slider("jaws open [deg]", 0.0, 60.0, 1.0, 50.0, hint=hint)
    slider.on_update(lambda _: send(float(np.radians(slider.value))))
    return slider
