"""Where one looks from: the whole scene, or the tool from near by."""

from __future__ import annotations

import numpy as np
import viser

from palpate.arrays import Array
from palpate.viewer.controls import set_value
from palpate.viewer.drawing import Drawing
from palpate.viewer.stage import Stage

View = tuple[Array, Array]
"""Position of the eye and what it looks at, (3,) each [m]."""

GLASS = 0.5
"""How far one sees through the organs from near by."""
FIELD_OF_VIEW = np.radians(42.0)
FROM_ABOVE_IN_FRONT = np.array([-0.10, -1.15, 0.50])
"""The eye of the overview, from the focus, for a scene of 0.4 m [m]: the surgeon's side, patient's feet in front."""


def overview(stage: Stage) -> View:
    """Organ and master arm side by side, with room above for the arms."""
    size = stage.extent / 0.4
    look_at = stage.focus + size * np.array([-0.02, 0.0, 0.10])
    return look_at + size * FROM_ABOVE_IN_FRONT, look_at


def close_up(p_WT: Array) -> View:
    """The tool tip (3,) from a hand's breadth away."""
    return p_WT + np.array([0.03, -0.17, 0.09]), p_WT


def start_with(server: viser.ViserServer, view: View) -> None:
    """The view that a browser begins with."""
    camera = server.initial_camera
    camera.position, camera.look_at = (tuple(point) for point in view)
    camera.up, camera.fov, camera.near, camera.far = (0.0, 0.0, 1.0), float(FIELD_OF_VIEW), 0.01, 30.0


def add_buttons(gui: viser.GuiApi, stage: Stage, drawing: Drawing) -> None:
    """A button for each view, which moves the camera of the browser that asks, and how solid the organs look."""
    with gui.add_folder("View"):
        buttons = gui.add_button_group("look at", ("scene", "tool tip"))
        glass = gui.add_slider("see through", 0.0, 0.9, 0.1, 0.0, hint="Look into the organ: where the tool is inside")

    @glass.on_update
    def _(_: object) -> None:
        drawing.see_through(glass.value)

    @buttons.on_click
    def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
        near = event.target.value == "tool tip"
        view = close_up(drawing.p_WT) if near else overview(stage)
        set_value(glass, GLASS if near else 0.0)
        drawing.see_through(glass.value)
        if event.client is not None:
            with event.client.atomic():
                event.client.camera.position, event.client.camera.look_at = view
